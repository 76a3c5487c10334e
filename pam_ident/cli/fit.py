"""pam-ident fit."""

from typing import TYPE_CHECKING, Annotated

import typer

from ..schema.fit import in_order
from . import options, text

if TYPE_CHECKING:
    from ..fitting import IsobarTable
    from ..fitting.methods import MethodRow
    from ..tasks.fit import FitAnswer, FitOptions
    from ..tasks.setup import Setup

MOST_OF_MEMORY = 1 / 8
"""Share of the free memory from which a record's text is read in chunks."""
IN_CHUNKS = (
    "read in chunks: these samples are an even part of it, from which the energies and the sensors' faults are found; "
    "parameters, errors and n are of all; noise floor and lack of fit are not tested"
)


def fit(
    record: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORD",
            help="Record of a test rig: a file, a folder, a quoted glob, or the name of a bundled data set; "
            "several are fitted together.",
            show_default=False,
        ),
    ],
    law: options.Law = "auto",
    shared: Annotated[
        list[str] | None,
        options.option(
            "--shared",
            "NAME",
            "Of several records: a parameter that has one value for all, an effect's name for all of its own, or all; "
            "repeatable. Any other is each record's own.",
        ),
    ] = None,
    branch: options.Branch = "together",
    method: Annotated[
        str,
        typer.Option(
            "--method",
            metavar="METHOD",
            help="global; two-stage: each isobar alone, then over pressure; both: side by side, held out too.",
        ),
    ] = "global",
    hold: Annotated[
        list[str] | None, options.option("--hold", "NAME=VALUE", "Parameter that keeps a value; repeatable.")
    ] = None,
    weights: Annotated[
        str,
        typer.Option("--weights", metavar="WEIGHTS", help="equal, or sensors: from [sensors] in the specimen's file."),
    ] = "equal",
    loss: Annotated[
        str, typer.Option("--loss", metavar="LOSS", help="linear, or huber: outliers count by size, not square.")
    ] = "linear",
    intervals: Annotated[
        str, typer.Option("--intervals", metavar="HOW", help="linear, profile (likelihood) or bootstrap (by cycles).")
    ] = "linear",
    workers: Annotated[
        int | None, options.option("--workers", "N", "Processes at a time; the answer stays the same. Default: 1.")
    ] = None,
    scheduler: options.Scheduler = None,
    chunked: Annotated[
        bool, typer.Option("--chunked", help="Read the record in chunks, as is done where memory is short.")
    ] = False,
    asked: options.Asked = options.NOTHING,
    figures: Annotated[
        str | None,
        options.option(
            "--figures",
            "DIR",
            "Folder for SVG figures of the isobars, the fit, other laws and the coefficients; it is made.",
        ),
    ] = None,
) -> None:
    """Fit a law: parameters with standard errors.

    Several records are fitted together by one law; each takes its own specimen.toml.
    """
    from ..core import UsageError
    from ..parallel.executor import Executor
    from ..records.files import share_of_memory
    from ..schema.fit import fit_json
    from ..schema.prediction import law_choice_json
    from ..tasks.fit import FitOptions, fit_record
    from ..tasks.law_choice import settle
    from ..tasks.setup import AUTO

    setup, path = asked.setup(law), record[0]
    executor = Executor(workers, scheduler)
    wishes = FitOptions(branch, method, options.held(hold), weights, loss, intervals, executor=executor)
    if len(record) > 1 or shared:
        if chunked or figures is not None:
            raise UsageError("--chunked and --figures are for one record; leave them out to fit several together")
        return _together(record, setup, tuple(shared or ()), wishes, asked.json)
    if figures is not None:
        from ..tasks.figures import make_folder

        make_folder(figures)
    chunked = chunked or share_of_memory(path) > MOST_OF_MEMORY
    if chunked and law == AUTO:
        raise UsageError(f"{path}: is read in chunks, and laws are compared in memory; name one with --law")
    measured = path if chunked else setup.read(path)
    setup, choice = (setup, None) if isinstance(measured, str) else settle(measured, setup)
    answer = fit_record(measured, setup, wishes)
    if figures is not None and any(one.lengths for one in answer.fits.values()):
        raise UsageError("--figures draws isobars, and in an isotonic test the length answers; leave it out")
    options.give_json(asked.json, lambda: fit_json(path, setup.law, answer) | law_choice_json(choice))
    text.say(text.title(path, answer.record), *([IN_CHUNKS] if answer.in_chunks else []), *text.chosen(choice))
    text.say(*text.equation(setup.model), *text.banner(answer.warnings))
    _print(answer)
    if figures is not None:
        from ..tasks.figures import paper_figures, write_figures

        text.say("", *(f"figure: {path}" for path in write_figures(figures, paper_figures(answer))))
    options.stop_if_invalid(path, answer.problems)


def _together(
    records: list[str], setup: "Setup", shared: tuple[str, ...], wishes: "FitOptions", json: str | None
) -> None:
    from ..core.files import write_json_lines
    from ..schema.fit import fit_json, shared_json
    from ..tasks.together import fit_records

    answers = fit_records([setup.read(path) for path in records], setup, shared, wishes)
    if json is not None:
        options.answered.set(True)
        each = zip(records, answers, strict=True)
        write_json_lines(json, [fit_json(path, setup.law, one) | shared_json(records, one) for path, one in each])
    text.say(*text.equation(setup.model))
    for branch, first in answers[0].fits.items():
        if first.shared:
            text.say("", f"{text.branch(branch)}, shared by all {len(records)} records:", *text.parameters(first, True))
    for path, answer in zip(records, answers, strict=True):
        text.say("", text.title(path, answer.record), *text.banner(answer.warnings))
        for branch, one in answer.fits.items():
            text.say(f"{text.branch(branch)}: {text.quality(one)}", *text.parameters(one, False))
            text.say(*text.checks(answer.checks[branch], one))
    for path, answer in zip(records, answers, strict=True):
        options.stop_if_invalid(path, answer.problems)


def _print(answer: "FitAnswer") -> None:
    for branch, one in answer.fits.items():
        name = text.branch(branch)
        if answer.isobars is not None:
            name += (
                ", from straight lines through the isobars" if branch in answer.two_stage else ", all isobars at once"
            )
        text.say("", f"{name}: {text.quality(one)}", *text.parameters(one))
        text.say(*text.checks(answer.checks[branch], one))
        for profile in answer.profiles.get(branch, ()):
            met = dict.fromkeys(other for stuck in profile.bounded for other in stuck)
            if met:
                text.say(f"  along {profile.name} another parameter met its bound: {', '.join(met)}")
    if answer.isobars is not None:
        _print_isobars(answer.isobars)
    if answer.methods:
        _print_methods(answer.methods)
    if answer.measured_loops:
        rows = [
            (f"{p:g}", text.number(measured, 3), text.number(answer.loops.get(p), 3))
            for p, measured in sorted(answer.measured_loops.items())
        ]
        text.say("", "energy of a cycle (positive: taken up):")
        text.say(*text.table(("p [MPa]", "measured [J]", "modelled [J]"), rows))


def _print_methods(methods: "tuple[MethodRow, ...]") -> None:
    for branch in dict.fromkeys(row.branch for row in methods):
        mine = [row for row in methods if row.branch == branch]
        names = sorted(mine[0].values)
        rows = [
            (
                row.method,
                "fitted" if row.mu is None else f"{row.mu:g}",
                text.number(row.rmse, 3),
                text.number(row.heldout, 3),
                *(text.number(row.values[name], 4) for name in names),
            )
            for row in mine
        ]
        text.say("", f"both methods, {text.branch(branch)}; held out: each isobar from the others")
        text.say(*text.table(("method", "μ", "rmse [N]", "held out [N]", *names), rows))


def _print_isobars(isobars: "IsobarTable") -> None:
    for branch in dict.fromkeys(row.branch for row in isobars.rows):
        rows = [row for row in isobars.rows if row.branch == branch]
        head = [f"{e.name} [{e.unit}]" if e.unit != "1" else e.name for e in in_order(rows[0].estimates)]
        cells = [
            (
                f"{row.pressure_MPa:g}",
                *(
                    f"{text.value_of(e)} {text.error_of(e)}" if e.identified else "not identified"
                    for e in in_order(row.estimates)
                ),
                text.number(row.rmse, 3),
            )
            for row in rows
        ]
        text.say("", f"each isobar alone, {text.branch(branch)}:")
        text.say(*text.table(("p [MPa]", *head, "rmse [N]"), cells))
        if branch in isobars.correlation:
            pairs = ", ".join(f"{key} {text.number(r, 5)}" for key, r in isobars.correlation[branch].items())
            text.say(f"  correlation with pressure: {pairs}")
