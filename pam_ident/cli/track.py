"""pam-ident track."""

import math
from typing import TYPE_CHECKING, Annotated

import typer

from . import options, text

if TYPE_CHECKING:
    from ..leg.track import Track, Tracking

Fit = "a file that `fit --json`, `add --json` or `ladder --json` wrote"


def track(
    plant: Annotated[
        str | None, options.option("--plant", "FIT", f"Muscle in the leg: {Fit}; of a ladder the last step.")
    ] = None,
    controller: Annotated[
        str | None, options.option("--controller", "FIT", f"The model that the feed-forward knows: {Fit}.")
    ] = None,
    gait: Annotated[
        str, typer.Option("--gait", metavar="GAIT", help="winter (adult), children, or a CSV file with knee_deg.")
    ] = "winter",
    cadence: Annotated[float | None, typer.Option("--cadence", metavar="HZ", help="Strides a second.")] = None,
    paper: Annotated[bool, typer.Option("--paper", help="Judge the paper's 0.2 s instead of a whole stride.")] = False,
    prototype: Annotated[
        bool, typer.Option("--prototype", help="Run in the multibody leg (needs the extra `prototype`).")
    ] = False,
    kp: Annotated[float | None, typer.Option("--kp", metavar="K", help="Proportional gain, MPa/rad.")] = None,
    ki: Annotated[float | None, typer.Option("--ki", metavar="K", help="Integral gain, MPa/(rad s).")] = None,
    kd: Annotated[float | None, typer.Option("--kd", metavar="K", help="Derivative gain, MPa s/rad.")] = None,
    supply: Annotated[
        float | None, options.option("--supply", "MPa", "Gauge pressure of the supply, by default 0.7.")
    ] = None,
    load: Annotated[float | None, options.option("--load", "kg", "Mass added at the foot.")] = None,
    leg: Annotated[
        str | None, options.option("--leg", "TOML", "Geometry, sprocket, muscles, supply, load and more.")
    ] = None,
    write_leg: Annotated[
        str | None, options.option("--write-leg", "TOML", "Write the leg's own file, to begin from, and end.")
    ] = None,
    off: Annotated[
        tuple[float, float] | None,
        options.option("--off", "F E", "Force of the plant's flexor and extensor off the fit, per cent: --off -10 10."),
    ] = None,
    ageing: Annotated[
        float | None, options.option("--ageing", "%", "Force that the plant's muscles lose with each stride.")
    ] = None,
    unknown: Annotated[
        str | None,
        options.option(
            "--unknown",
            "EFFECT",
            "An effect of the plant that no controller knows.",
            autocompletion=options.effect_names,
        ),
    ] = None,
    ground: Annotated[
        bool, typer.Option("--ground", help="The prototype's foot treads a padded belt, heel first.")
    ] = False,
    learn: Annotated[
        int,
        typer.Option(
            "--learn", metavar="STRIDES", help="Strides that PID with feed-forward learns from, before one is judged."
        ),
    ] = 0,
    effect_file: options.EffectFiles = None,
    specimen: options.SpecimenFile = None,
    out: Annotated[
        str | None, options.option("--out", "DIR", "Folder for figures; of a prototype its MJCF and pictures.")
    ] = None,
    json: options.JsonFile = None,
) -> None:
    """Run fitted models in the controller of a leg of two muscles.

    Without --plant and --controller the bundled muscle and ladder are taken.
    """
    from ..schema.track import track_json
    from ..tasks import track as task

    if write_leg is not None:
        task.write_leg(write_leg)
        text.say(f"wrote {write_leg}")
        return
    if out is not None:
        from ..tasks.figures import make_folder

        make_folder(out)
    gains = (kp, ki, kd)
    wishes = task.TrackOptions(
        plant,
        controller,
        gait,
        cadence,
        paper,
        prototype,
        gains,
        supply,
        load,
        tuple(effect_file or ()),
        specimen,
        leg,
        off,
        ageing,
        unknown,
        ground,
        learn,
    )
    found = task.track_leg(wishes)
    options.give_json(json, lambda: track_json(found))
    text.say(*map(str, found.doubts), *_head(found), "", *_table(found), *_troubles(found), "", *_budget(found))
    if out is not None:
        from ..tasks.figures import write_track

        text.say("", *(f"wrote {path}" for path in write_track(out, found)))


def _head(found: "Track") -> list[str]:
    course, gains = found.course, found.automatic.gains
    stretch = "a whole stride" if course.window is None else f"{course.window.duration_s:g} s of a stride"
    where = "in the multibody prototype" if found.prototype else "in the reduced leg"
    where += "" if found.ground is None else " on the ground"
    muscle = found.loop.pair.muscle.specimen
    lines = [
        f"knee of gait {course.gait.name} at {course.gait.cadence_Hz:g} Hz, {stretch}, {where}",
        f"two muscles as the fit's: {muscle.initial_length_mm:g} mm long, {muscle.initial_radius_mm:g} mm in radius",
        f"PID tuned by hand ({found.by_hand.runs} runs): {_gains(found.by_hand.gains)}; "
        f"{found.by_hand.rms_deg:.2f}° rms, {_worst(found.by_hand.worst_deg)}",
        f"PID {'tuned automatically' if found.automatic.runs else 'as given'}: {_gains(gains)}; "
        f"{found.automatic.rms_deg:.2f}° rms, "
        f"{_worst(found.automatic.worst_deg)}",
    ]
    if str(found.off):
        lines.append(f"the plant is off what the controller knows: {found.off}")
    if found.course.lessons:
        lines.append(f"PID with feed-forward learns from {found.course.lessons} strides; the PID alone does not")
    if found.agreement_deg is not None:
        lines.append(f"reduced leg and prototype differ by {found.agreement_deg:.3f}° rms in the last step")
    return lines


def _gains(gains: "tuple[float, ...]") -> str:
    return "Kp {} MPa/rad, Ki {} MPa/(rad s), Kd {} MPa s/rad".format(*(text.number(g, 3) for g in gains))


def _worst(value: float) -> str:
    return "unstable on a plant 20 % off" if value > 90.0 else f"{value:.2f}° on the worst plant 20 % off"


def _table(found: "Track") -> list[str]:
    from ..tasks.ladder import steps

    rows = [("PID, by hand", "", *_numbers(found.pid_by_hand), ""), ("PID", "", *_numbers(found.pid), "")]
    names = steps(rung.muscle.model for rung in found.rungs)
    for k, (name, rung) in enumerate(zip(names, found.rungs, strict=True)):
        band = "" if rung.band is None else f"{rung.band[0]:.3f} to {rung.band[1]:.3f}"
        said = f"{k} {'PID + ' * (k == 0)}{name}".replace("\n", " ")
        left = "" if math.isnan(rung.muscle.rmse) else text.number(rung.muscle.rmse, 3)
        rows.append((said, left, *_numbers(rung.tracking), band))
    rows.append(("PID + the plant's own model", "", *_numbers(found.ideal), ""))
    return text.table(("controller", "fit leaves [N]", "rms [deg]", "peak [deg]", "95 % band of rms"), rows)


def _troubles(found: "Track") -> list[str]:
    """Of plain PID and of the last rung; those of all runs are in the JSON."""
    shown = {"PID": found.pid}
    if found.rungs:
        shown[f"step {len(found.rungs) - 1}"] = found.rungs[-1].tracking
    lines = [f"  {name}: {trouble}" for name, run in shown.items() for trouble in run.troubles]
    return ["", *lines] if lines else []


def _numbers(run: "Tracking") -> tuple[str, str]:
    return f"{run.rms_deg:.3f}", f"{run.peak_deg:.3f}"


def _budget(found: "Track") -> list[str]:
    b = found.budget
    rows = [
        ("tuned by hand", f"{b.by_hand:.3f}", ""),
        ("tuned automatically", f"{b.automatic:.3f}", f"tuning {b.tuning:+.3f}"),
        ("so, with a hinge in place of the four-bar knee", f"{b.hinge:.3f}", f"structure {b.structure:+.3f}"),
        ("so, with a linear muscle without hysteresis", f"{b.linear:.3f}", f"muscle {b.muscle:+.3f}"),
    ]
    head = ("PID alone, the paper's three causes switched off", "rms [deg]", "share of the cause [deg]")
    return text.table(head, rows)
