"""pam-ident inspect."""

from typing import TYPE_CHECKING

from . import options, text

if TYPE_CHECKING:
    from ..records.inspection import Inspection

COUNTED = {"isobaric": "on one isobar", "isometric": "at one length"}
"""Where cycles are counted, by the kind of test."""


def inspect(
    record: options.Record,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
    where: options.Where = None,
) -> None:
    """What was read of a record, and advice on the rig."""
    from ..records.doubt import grave
    from ..records.inspection import inspect_record
    from ..schema.catalogue import inspection_json
    from ..tasks.setup import load

    found = inspect_record(load(record, specimen, where))
    options.give_json(json, lambda: inspection_json(record, found))
    stops = grave(found.doubts)
    told = {doubt.text for doubt in stops}
    text.say(text.title(record, found.record), "", *_columns(found, told), *_motion(found))
    rows = [
        (
            f"{i.pressure_MPa:g}",
            str(i.n),
            text.number(i.wander_MPa, 2),
            f"{i.contraction[0]:.4f} to {i.contraction[1]:.4f}",
            f"{i.force_N[0]:.1f} to {i.force_N[1]:.1f}",
        )
        for i in found.isobars
        if found.kind == "isobaric"  # where the pressure is driven, it is on none
    ]
    text.say(
        *[""] * bool(rows), *text.table(("p [MPa]", "samples", "std. of p [MPa]", "contraction", "force [N]"), rows)
    )
    rows = [
        (
            f"{i.contraction:.4f}",
            str(i.n),
            f"{i.pressure_MPa[0]:.4f} to {i.pressure_MPa[1]:.4f}",
            f"{i.force_N[0]:.1f} to {i.force_N[1]:.1f}",
        )
        for i in found.lengths
    ]
    text.say(*[""] * bool(rows), *text.table(("contraction", "samples", "p [MPa]", "force [N]"), rows))
    advice = [line for line in found.advice if line not in told]
    if stops:
        head = "Stops naming (meant so? diagnose, ladder and report take --assume CODE):"
        text.say("", head, *(f"- {doubt.code}: {doubt.text}" for doubt in stops))
    if advice or not stops:
        text.say("", "Advice:" if advice else "Nothing amiss.", *(f"- {line}" for line in advice))


def _columns(found: "Inspection", elsewhere: set[str]) -> list[str]:
    """Where the numbers are from, without notes that are told `elsewhere`."""
    from ..records.package import told

    record, s = found.record, found.record.specimen
    wall = f"wall {s.wall_thickness_mm:g} mm" if s.wall_thickness_mm is not None else "wall not given"
    lines = [
        *_files(found),
        f"specimen    {s.name}: {s.geometry}, {wall}",
        f"columns     {', '.join(f'{key} from {column!r}' for key, column in record.columns.items())}",
    ]
    if record.passed:
        lines.append(f"passed over {', '.join(map(repr, record.passed))[:300]}")
    if record.masked:
        lines.append(f"masked      {record.masked} rows marked as slack")
    lines += [f"known       {words}: {value}" for words, value in told(record.metadata)]
    return lines + [f"noted       {note.text}" for note in record.notes if note.text not in elsewhere]


def _files(found: "Inspection") -> list[str]:
    if found.files is None:
        return []
    names = [path.name for path in found.files.paths]
    several = f"{len(names)} files, {names[0]} to {names[-1]}, " if len(names) > 1 else ""
    return [f"written     {several}{found.files.written()}"]


def _motion(found: "Inspection") -> list[str]:
    from ..records.kind import KINDS

    lines = [f"kind        {found.kind}: {KINDS[found.kind]}"]
    lines += [f"branches    {', '.join(f'{name} {n}' for name, n in found.branches.items())} samples"]
    if found.duration_s is None:
        lines.append("time        none: a static table")
        return lines
    speeds = ", ".join(f"{v:.3g}" for v in found.speeds) or "none"
    how = "of the pressure" if found.kind == "isometric" else f"at {speeds} mm/s"
    lines += [
        f"time        {found.duration_s:.6g} s",
        f"strokes     {found.strokes}{'' if not found.strokes else f', {how}'}",
        f"holds       {found.holds} ({found.hold_samples} samples)",
        f"cycles      {found.cycles} at most {COUNTED.get(found.kind, 'in a row')}",
    ]
    if found.temperature_C is not None:
        lines.append(f"temperature {found.temperature_C[0]:.1f} to {found.temperature_C[1]:.1f} °C")
    return lines
