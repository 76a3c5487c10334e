"""The command line: a command a file. Nothing heavy is imported before a command runs."""

import os
import sys

import typer

from . import (
    add,
    against,
    batch,
    challenge,
    compare,
    demo,
    diagnose,
    effects,
    export,
    fit,
    inspect,
    ladder,
    laws,
    pack,
    predict,
    report,
    rig,
    selftest,
    track,
    validate,
    workbench,
)
from .completion import whole_words
from .door import Command, Door
from .verbs import verb

app = typer.Typer(
    name="pam-ident",
    cls=Door,
    help="Compare a force model of a pneumatic artificial muscle with a test-rig record: see where it fails, learn "
    "which physical effect is missing, add it.",
    epilog="Exit codes: 0 done, 2 usage, 3 the fit is not valid, 4 bad data.",
    rich_markup_mode=None,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for command in (
    demo.demo,
    inspect.inspect,
    fit.fit,
    compare.compare,
    diagnose.diagnose,
    add.add,
    ladder.ladder,
    against.against,
    report.report,
    workbench.workbench,
    validate.validate,
    predict.predict,
    export.export,
    pack.pack,
    batch.batch,
    rig.rig,
    challenge.challenge,
    track.track,
    laws.laws,
    selftest.selftest,
):
    app.command(cls=Command)(verb(command))
app.add_typer(effects.app, name="effects")


def _version(wanted: bool) -> None:
    if wanted:
        from .. import __version__

        typer.echo(f"pam-ident {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(False, "--version", help="Print the version.", callback=_version, is_eager=True),
) -> None:
    pass


def main() -> None:
    """Entry point of `pam-ident`, `python -m pam_ident` and `python cli.py`."""
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # matrices of a few columns: a second thread costs more than it brings
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr]
    with whole_words():
        app(prog_name="pam-ident")
