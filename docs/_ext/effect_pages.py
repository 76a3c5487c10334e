"""A page for an effect and for a law, in Markdown, from what its file says."""

import sys
from collections.abc import Iterable, Sequence

from pam_ident.core import Param
from pam_ident.core.prose import capital
from pam_ident.effects import AddsForce, Effect, Form, ScalesForce, TransformsContraction, TransformsPressure
from pam_ident.laws import Law

ROLE = {
    AddsForce: "adds a force to the law's",
    ScalesForce: "scales the law's force",
    TransformsPressure: "changes the pressure that the law is given",
    TransformsContraction: "changes the contraction that the law is given",
}
NEED = {
    "branch": "the direction of motion: contraction and extension apart",
    "motion": "motion in time: speeds can be told",
    "time": "time",
    "cycle": "cycles, recorded or found from the motion",
    "temperature": "the temperature of the bladder",
}
LEVER = {
    "speed": "the speed of the strokes",
    "pressure": "the pressure",
    "hold": "the length of holds",
    "reversal": "where the motion turns: other strokes, minor loops",
    "temperature": "the temperature",
    "cycles": "the number of cycles",
}


def story(thing: Effect | Law) -> str:
    """First docstring of the file that defines an effect or a law; empty where it has none."""
    functions = [form.columns for form in thing.forms] if isinstance(thing, Effect) else [thing.columns, thing.fixed]
    homes = [getattr(function, "__globals__", {}) for function in functions]
    homes += [vars(module) for name, module in list(sys.modules.items()) if name.startswith("pam_ident.")]
    found = (home.get("__doc__") for home in homes if any(value is thing for value in home.values()))
    return next((text.strip() for text in found if text), "")


def effect_page(
    effect: Effect,
    look_alikes: Sequence[tuple[str, float]] = (),
    left: Sequence[tuple[str, float | None]] = (),
    figure: str | None = None,
    pages: Iterable[str] = (),
) -> str:
    """The page of an effect.

    `look_alikes` are names of effects with the cosine of the signatures, `left` names of laws with the share of the
    signature that they leave, `figure` the path of its picture; `pages` names the effects that have a page to link to.
    """
    linked = frozenset(pages)
    parts = [f"# {capital(effect.title)}", f"`{effect.name}`", story(effect)]
    parts += [f":::{{warning}}\n{effect.warning}\n:::"] if effect.warning else []
    if not effect.candidate:
        parts.append(
            f"The diagnosis does not try it by itself; `diagnose --also {effect.name}` does. It can be added by name."
        )
    parts += ["## Forms", _forms_intro(effect), *(_form(form) for form in effect.forms)]
    needs = [NEED[need] for need in effect.needs]
    parts += ["## What a record must hold", _listed(needs, "Nothing beyond pressure, contraction and force.")]
    parts += ["## The test that shows it", f"{capital(effect.test)}."]
    if effect.levers:
        parts.append("To vary on the rig:\n\n" + _listed([LEVER[one] for one in effect.levers], ""))
    parts += ["## What it is confused with", _confusable(effect, look_alikes, linked)]
    if left:
        parts += ["## What the laws leave of it", _left(left)]
    if figure:
        parts += ["## How it looks", f"![Force of {effect.title} in the standard record]({figure})", _CAPTION]
    parts += ["## Use", _use(effect), "## Source", effect.source]
    return "\n\n".join(part for part in parts if part) + "\n"


def law_page(law: Law) -> str:
    """The page of a force law."""
    isobars = "one isobar" if law.min_levels == 1 else f"{law.min_levels} isobars"
    parts = [f"# {capital(law.title)}", f"`{law.name}`", story(law), "## Formula", _code(law.formula)]
    parts.append("p is the gauge pressure, ε the contraction ratio, F the force, positive in pull.")
    if law.params:
        parts += ["## Parameters", parameter_table(law.params)]
        parts.append(f"The force is linear in {_names(law.linear)}." if law.linear else "")
        parts.append(f"It is curved in {_names(law.nonlinear)}, which is searched." if law.nonlinear else "")
        parts.append(f"A record needs at least {isobars} to tell the parameters apart.")
    else:
        parts.append("Nothing is free but, with `--free-geometry`, the radius and the braid angle of the specimen.")
    parts += ["## Use", f"```sh\npam-ident fit RECORD --law {law.name}\n```", "How to choose: [laws](../../laws.md)."]
    parts += ["## Source", capital(law.source)]
    return "\n\n".join(part for part in parts if part) + "\n"


def parameter_table(params: Sequence[Param]) -> str:
    """Name, unit, bounds and meaning of parameters as a Markdown table."""
    rows = [(f"`{p.name}`", p.unit, f"{_bound(p.lower)} to {_bound(p.upper)}", _cell(p.doc)) for p in params]
    return table(("parameter", "unit", "bounds", "meaning"), rows)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def _forms_intro(effect: Effect) -> str:
    count = len(effect.forms)
    forms = "One form" if count == 1 else f"{count} forms, from the simplest to the richest"
    return f"{forms}. Parameters are named `{effect.name}.NAME` in a model."


def _form(form: Form) -> str:
    implicit = " Its size depends on the force itself, which is then solved for." if form.uses_force else ""
    implicit += " It remembers the record's past." if form.remembers else ""
    role = next(text for kind, text in ROLE.items() if isinstance(form, kind))
    head = f"### {form.name}\n\n{_code(form.formula)}\n\nIt {role}.{implicit}"
    return f"{head}\n\n{parameter_table(form.params)}"


def _confusable(effect: Effect, look_alikes: Sequence[tuple[str, float]], linked: frozenset[str]) -> str:
    lines = []
    if effect.special_case_of:
        whole = _link(effect.special_case_of, linked)
        lines.append(f"It is a special case of {whole}, one of whose forms is the same physics.")
    if look_alikes:
        rows = [(_link(name, linked), f"{cosine:.2f}") for name, cosine in look_alikes]
        lines.append(
            "The largest cosine between the signature of its simplest form and those of the others', on the standard "
            "record, once the law `modified_chou_hannaford` has taken its part (1: nothing tells the two apart there):"
        )
        lines.append(table(("effect", "cosine"), rows))
    else:
        lines.append("On the standard record the simplest form of no other effect comes close to its signature.")
    lines.append("Which effects a record of yours cannot tell apart is computed for it by `pam-ident diagnose`.")
    return "\n\n".join(lines)


def _left(left: Sequence[tuple[str, float | None]]) -> str:
    if all(share is None for _, share in left):
        return "The standard record does not hold what the effect needs."
    rows = [
        (f"`{law}`", f"{share:.0%}" + (", absorbed" if share < 0.05 else ""))
        for law, share in left
        if share is not None
    ]
    intro = (
        "Share of the simplest form's force that stays when the law is fitted anew, on the standard record. "
        "Below 5 % the diagnosis calls the effect absorbed by the law."
    )
    return f"{intro}\n\n{table(('law', 'left'), rows)}"


_CAPTION = (
    "The simplest form at a typical size, on the standard record: the virtual rig with five pressures, three speeds, "
    "holds of 1, 10 and 100 s and 15 K of warming. Grey: its force. Coloured: what `modified_chou_hannaford` "
    "leaves of it."
)


def _use(effect: Effect) -> str:
    forms = [effect.name, *(f"{effect.name}:{form.name}" for form in effect.forms[1:2])]
    lines = [f"pam-ident add RECORD --law LAW --effect {name}" for name in forms]
    return "```sh\n" + "\n".join(lines) + "\n```"


def _link(name: str, linked: frozenset[str]) -> str:
    return f"[{name}]({name}.md)" if name in linked else f"`{name}`"


def _listed(items: Sequence[str], otherwise: str) -> str:
    return "\n".join(f"- {item}" for item in items) or otherwise


def _names(params: Sequence[Param]) -> str:
    return ", ".join(f"`{p.name}`" for p in params)


def _bound(value: float) -> str:
    return f"{value:g}".replace("inf", "∞").replace("-", "−")


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _code(text: str) -> str:
    return f"```text\n{text}\n```"
