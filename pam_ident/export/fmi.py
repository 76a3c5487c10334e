"""A functional mock-up unit (FMU) of a fitted model: what the versions of the standard FMI share."""

import io
import platform
import shutil
import subprocess
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import NAMESPACE_URL, uuid5
from xml.sax.saxutils import quoteattr

from .. import __version__
from .fitted import Fitted
from .program import ARGUMENTS, Program, program
from .target import Written
from .targets.c import c_header
from .writer import harmless

HERE = Path(__file__).parent
UNITS = {
    "pressure_MPa": ("MPa", 'kg="1" m="-1" s="-2" factor="1e6"'),
    "velocity_mm_s": ("mm/s", 'm="1" s="-1" factor="1e-3"'),
    "temperature_C": ("degC", 'K="1" offset="273.15"'),
    "force_N": ("N", 'kg="1" m="1" s="-2"'),
}
START = {"temperature_C": 20.0}
"""What an input is before anybody sets it, where that is not 0."""
ENDINGS = {"Linux": ".so", "Darwin": ".dylib", "Windows": ".dll"}


@dataclass(frozen=True)
class FMIVersion:
    """A version of FMI: its C file beside this one, folders of a library by system and machine, and `texts`, which
    writes what describes a unit, by its path in it."""

    source: str
    folders: Mapping[tuple[str, str], str]
    texts: Callable[["FMU"], dict[str, str]]


@dataclass(frozen=True)
class FMU:
    """What is told of a unit: its `name` and `token`, the inputs by value reference, `force_N` behind them, and
    attributes of XML that all versions have."""

    name: str
    token: str
    inputs: tuple[str, ...]
    head: str

    @property
    def units(self) -> str:
        """The units as XML."""
        named = [UNITS[key] for key in (*self.inputs, "force_N") if key in UNITS]
        return "".join(f'<Unit name="{name}"><BaseUnit {base}/></Unit>' for name, base in named)

    def variables(self) -> list[tuple[str, str]]:
        """Attributes of each variable, and those of its type, as XML."""
        rows = [(n, ARGUMENTS[n], 'causality="input"', f' start="{START.get(n, 0.0)}"') for n in self.inputs]
        told = "force, positive where the muscle pulls"
        rows.append(("force_N", told, 'causality="output" initial="calculated"', ""))
        found = []
        for reference, (name, about, more, start) in enumerate(rows):
            unit = f' unit="{UNITS[name][0]}"' if name in UNITS else ""
            head = f'name="{name}" valueReference="{reference}" {more} variability="continuous"'
            found.append((f"{head} description={quoted(about)}", f"{unit}{start}"))
        return found


def quoted(text: str) -> str:
    """Text as an attribute of XML."""
    return quoteattr(harmless(text))


def write_unit(version: FMIVersion, fitted: Fitted, name: str) -> Written:
    """A fitted model as a unit, compiled for this machine where it has a C compiler.

    Raises UsageError for a name that C does not take, or a model that cannot be exported.
    """
    made = program(fitted, live=True)
    inputs = tuple(argument for argument in made.arguments if argument != "time_s")
    header = c_header(fitted, name, made)
    token = f"{{{uuid5(NAMESPACE_URL, version.source + header)}}}"
    about = f"{fitted.model.law.name} with {', '.join(fitted.model.labels) or 'no effects'}, fitted to {fitted.record}"
    head = f'modelName="{name}" description={quoted(about)} generationTool="pam-ident {__version__}"'
    sources = {file: (HERE / file).read_text(encoding="utf-8") for file in ("fmi.h", version.source)}
    sources["model.h"] = header + _model(made, name, inputs, token)
    library, note = _compiled(version, sources, name)
    files = version.texts(FMU(name, token, inputs, head))
    files |= {f"sources/{file}": text for file, text in sources.items()}
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for path, content in {**files, **library}.items():
            one = zipfile.ZipInfo(path)
            one.external_attr = 0o644 << 16
            archive.writestr(one, content, zipfile.ZIP_DEFLATED)
    return Written(packed.getvalue(), notes=(note,))


def _model(made: Program, name: str, inputs: tuple[str, ...], token: str) -> str:
    """What `fmi.h` needs to know of the model."""
    given = ", ".join("time" if a == "time_s" else f"input[{inputs.index(a)}]" for a in made.arguments)
    remembers = made.later is not None
    call = f"{name}_step(memory, {given})" if remembers else f"{name}_force({given})"
    unused = [] if remembers else ["    (void)memory;"]
    unused += [] if "time_s" in made.arguments else ["    (void)time;"]
    lines = [
        "",
        f'#define TOKEN "{token}"',
        f"enum {{ INPUTS = {len(inputs)} }};",
        f"static const double START[INPUTS] = {{{', '.join(repr(START.get(one, 0.0)) for one in inputs)}}};",
        f"typedef {f'{name}_state' if remembers else 'struct { int none; }'} Memory;",
        "",
        "static double force_at(Memory *memory, const double *input, double time)",
        "{",
        *unused,
        f"    return {call};",
        "}",
    ]
    return "\n".join([*lines, ""])


def _compiled(version: FMIVersion, sources: Mapping[str, str], name: str) -> tuple[dict[str, bytes], str]:
    """The library of this machine by its place, and what is to be said; none where it cannot be compiled."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    folder = version.folders.get((platform.system(), platform.machine()))
    alone = f"only sources are in {name}.fmu, to be compiled where it is used (fmpy compile {name}.fmu): "
    if compiler is None or folder is None:
        return {}, alone + ("no C compiler here" if folder else f"no folder is named for {platform.machine()}")
    ending = ENDINGS[platform.system()]
    with TemporaryDirectory() as where:
        for file, text in sources.items():
            Path(where, file).write_text(text, encoding="utf-8")
        flags = ["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared", "-fPIC"]
        words = [compiler, *flags, version.source, "-o", f"library{ending}", "-lm"]
        done = subprocess.run(words, cwd=where, capture_output=True, text=True, check=False)
        if done.returncode:
            return {}, f"{alone}{compiler} says {(done.stderr.splitlines() or ['nothing'])[0]}"
        library = Path(where, f"library{ending}").read_bytes()
    return {f"binaries/{folder}/{name}{ending}": library}, f"compiled for {folder}; its sources are in {name}.fmu, too"
