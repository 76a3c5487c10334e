"""Figures made ready to stand inside an HTML page."""

import base64
import re
import xml.etree.ElementTree as ET
from collections.abc import Collection, Mapping

from markupsafe import Markup, escape
from matplotlib.figure import Figure

from ..plot import to_png, to_svg
from .words import plain

MAX_BYTES = 400_000
SVG, XLINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}"
REFERENCE = re.compile(r"url\(#([^)]+)\)")
LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")
ROOT = re.compile(rb'<svg viewBox="0 0 ([\d.]+) ([\d.]+)"')
FAMILY = re.compile(r"font-family: ([^;]+);? ?")


def embed(
    figure: Figure,
    prefix: str,
    label: str,
    max_bytes: int = MAX_BYTES,
    tips: Mapping[str, str] | None = None,
    classes: Collection[str] = (),
) -> Markup:
    """The figure as inline SVG, or as PNG where the SVG would be longer than `max_bytes`.

    `prefix` goes before every id and must differ from figure to figure; `label` is read out by a screen reader.
    `tips` are texts by the ids (matplotlib's gid) of the parts over which a pointer makes them appear; parts whose ids
    are among `classes` have them as their class.
    """
    svg = inline(to_svg(figure), prefix, label, tips or {}, classes)
    if len(svg.encode()) <= max_bytes:
        return Markup(svg)
    return _image("png", to_png(figure), label)


def image(figure: Figure, label: str, max_bytes: int = MAX_BYTES) -> Markup:
    """The same for hosts that take the marks of an SVG out of a page and leave its words: as an image by itself."""
    svg = inline(to_svg(figure), "i", label).encode()
    if len(svg) > max_bytes:
        return _image("png", to_png(figure), label)
    alone = rb'<svg xmlns="http://www.w3.org/2000/svg" width="\1" height="\2" viewBox="0 0 \1 \2"'
    paper = ROOT.sub(alone, svg, 1).replace(b' style="', b' style="background:white;', 1)
    return _image("svg+xml", paper, label)


def _image(kind: str, content: bytes, label: str) -> Markup:
    data = base64.b64encode(content).decode()
    return Markup(f'<img role="img" alt="{escape(plain(label))}" src="data:image/{kind};base64,{data}"/>')


def inline(
    svg: str, prefix: str, label: str, tips: Mapping[str, str] | None = None, classes: Collection[str] = ()
) -> str:
    """SVG text of matplotlib without prolog, metadata, style sheet and namespaces, ids prefixed, numbers rounded."""
    root = ET.fromstring(plain(svg))
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in (SVG + "metadata", SVG + "style"):
                parent.remove(child)
    if tips:
        _hint(root, tips)
    for element in root.iter():
        if element.get("id") in classes:
            element.set("class", element.get("id", ""))
    used = _references(root)
    names = {old: f"{prefix}-{i}" for i, old in enumerate(sorted(used))}
    for element in root.iter():
        _clean(element, names)
    for group in root.iter("g"):
        _hoist(group)
    family = _family(root)
    box = root.attrib["viewBox"]
    root.attrib.clear()
    # matplotlib's style sheet would apply to the whole page, so its two rules go onto the root alone.
    root.attrib.update(
        {
            "viewBox": box,
            "role": "img",
            "aria-label": plain(label),
            "style": f"stroke-linejoin:round;stroke-linecap:butt{family}",
        }
    )
    return ET.tostring(root, encoding="unicode")


def _hint(root: ET.Element, tips: Mapping[str, str]) -> None:
    """A browser shows the <title> of what is under the pointer, here even of what is not painted."""
    for element in list(root.iter()):
        if (text := tips.get(element.get("id", ""))) is not None:
            title = ET.Element(SVG + "title")
            title.text = plain(text)
            element.insert(0, title)
            element.set("pointer-events", "all")


def _references(root: ET.Element) -> set[str]:
    """Ids that something in the figure points to."""
    used: set[str] = set()
    for element in root.iter():
        for key, value in element.attrib.items():
            used.update(REFERENCE.findall(value))
            if key in (XLINK + "href", "href") and value.startswith("#"):
                used.add(value[1:])
    return used


def _clean(element: ET.Element, names: dict[str, str]) -> None:
    element.tag = element.tag.removeprefix(SVG)
    element.tail = None
    if element.tag != "text" and element.text and not element.text.strip():
        element.text = None
    found: dict[str, str] = {}
    for key, value in element.attrib.items():
        key = key.removeprefix(XLINK)
        if key == "id":
            if value in names:
                found["id"] = names[value]
        elif key == "href":
            if value.startswith("#"):
                found["href"] = f"#{names[value[1:]]}"
            elif value.startswith("data:image/png;base64,"):  # the raster of a colour bar
                found["href"] = "".join(value.split())
        else:
            value = REFERENCE.sub(lambda m: f"url(#{names[m.group(1)]})", value)
            rounded = LONG_NUMBER.sub(_short, value) if key in ("d", "x", "y", "transform") else value
            found[key] = " ".join(rounded.split())
    element.attrib.clear()
    element.attrib.update(found)


def _family(root: ET.Element) -> str:
    """The font that the first text asks for, taken off all that ask for the same: the root can say it once."""
    styles = [(text, FAMILY.search(text.get("style", ""))) for text in root.iter("text")]
    first = next((found.group(1) for _, found in styles if found), "")
    for text, found in styles:
        if found and found.group(1) == first:
            text.set("style", FAMILY.sub("", text.get("style", "")))
    return f";font-family:{first}" if first else ""


def _short(match: re.Match[str]) -> str:
    return f"{float(match.group()):.2f}".rstrip("0").rstrip(".")


def _hoist(group: ET.Element) -> None:
    """Give a group the style that all its markers share: a cloud of points repeats it a thousand times."""
    marks = [child for child in group if child.tag == "use"]
    styles = {child.get("style", "") for child in marks}
    if len(marks) > 1 and len(marks) == len(group) and len(styles) == 1 and "style" not in group.attrib:
        style = styles.pop()
        if style:
            group.set("style", style)
            for child in marks:
                del child.attrib["style"]
