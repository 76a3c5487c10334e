"""A fitted model as a functional mock-up unit, FMI 2.0, for model exchange and co-simulation."""

import io
import platform
import shutil
import subprocess
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import NAMESPACE_URL, uuid5
from xml.sax.saxutils import quoteattr

from ... import __version__
from ..fitted import Fitted
from ..program import ARGUMENTS, Program, program
from ..target import Target, Written
from ..writer import harmless
from .c import c_header

FMI2 = Path(__file__).parents[1] / "fmi2.c"
UNITS = {
    "pressure_MPa": ("MPa", 'kg="1" m="-1" s="-2" factor="1e6"'),
    "velocity_mm_s": ("mm/s", 'm="1" s="-1" factor="1e-3"'),
    "temperature_C": ("degC", 'K="1" offset="273.15"'),
    "force_N": ("N", 'kg="1" m="1" s="-2"'),
}
START = {"temperature_C": 20.0}
"""What an input is before anybody sets it, where that is not 0."""
LIBRARY = {
    ("Linux", "x86_64"): ("linux64", ".so"),
    ("Darwin", "x86_64"): ("darwin64", ".dylib"),
    ("Darwin", "arm64"): ("darwin64", ".dylib"),
    ("Windows", "AMD64"): ("win64", ".dll"),
}
"""Folder and ending that FMI 2.0 gives a library, by system and machine."""


def _write(fitted: Fitted, name: str) -> Written:
    made = program(fitted, live=True)
    inputs = [argument for argument in made.arguments if argument != "time_s"]
    header = c_header(fitted, name, made)
    guid = f"{{{uuid5(NAMESPACE_URL, header)}}}"
    sources = {f"{name}.h": header, "model.h": _model(made, name, inputs, guid), "fmi2.c": FMI2.read_text("utf-8")}
    library, note = _compiled(sources, name)
    files: dict[str, str | bytes] = {"modelDescription.xml": _description(fitted, name, inputs, guid)}
    files |= {f"sources/{file}": text for file, text in sources.items()} | library
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            one = zipfile.ZipInfo(path)
            one.external_attr = 0o644 << 16
            archive.writestr(one, content, zipfile.ZIP_DEFLATED)
    return Written(packed.getvalue(), notes=(note,))


def _model(made: Program, name: str, inputs: list[str], guid: str) -> str:
    """What `fmi2.c` needs to know of the model."""
    given = ", ".join("time" if a == "time_s" else f"input[{inputs.index(a)}]" for a in made.arguments)
    remembers = made.later is not None
    call = f"{name}_step(memory, {given})" if remembers else f"{name}_force({given})"
    unused = [] if remembers else ["    (void)memory;"]
    unused += [] if "time_s" in made.arguments else ["    (void)time;"]
    lines = [
        f'#include "{name}.h"',
        "",
        f'#define GUID "{guid}"',
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


def _compiled(sources: dict[str, str], name: str) -> tuple[dict[str, bytes], str]:
    """The library of this machine by its place, and what is to be said; none where it cannot be compiled."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    place = LIBRARY.get((platform.system(), platform.machine()))
    alone = f"only sources are in {name}.fmu, to be compiled where it is used (fmpy compile {name}.fmu): "
    if compiler is None or place is None:
        return {}, alone + ("no C compiler here" if place else f"FMI 2.0 has no folder for {platform.machine()}")
    folder, ending = place
    with TemporaryDirectory() as where:
        for file, text in sources.items():
            Path(where, file).write_text(text, encoding="utf-8")
        flags = ["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared", "-fPIC"]
        words = [compiler, *flags, "fmi2.c", "-o", f"library{ending}", "-lm"]
        done = subprocess.run(words, cwd=where, capture_output=True, text=True, check=False)
        if done.returncode:
            return {}, f"{alone}{compiler} says {(done.stderr.splitlines() or ['nothing'])[0]}"
        library = Path(where, f"library{ending}").read_bytes()
    return {f"binaries/{folder}/{name}{ending}": library}, f"compiled for {folder}; its sources are in {name}.fmu, too"


def _description(fitted: Fitted, name: str, inputs: list[str], guid: str) -> str:
    about = f"{fitted.model.law.name} with {', '.join(fitted.model.labels) or 'no effects'}, fitted to {fitted.record}"
    able = f'modelIdentifier="{name}" canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
    files = '<SourceFiles><File name="fmi2.c"/></SourceFiles>'
    named = [*inputs, "force_N"]
    units = [f'<Unit name="{u}"><BaseUnit {base}/></Unit>' for key, (u, base) in UNITS.items() if key in named]
    variables = [_variable(one, k, ARGUMENTS[one], "input") for k, one in enumerate(inputs)]
    variables.append(_variable("force_N", len(inputs), "force, positive where the muscle pulls", "output"))
    unknown = f'<Unknown index="{len(named)}"/>'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{guid}" description={_quoted(about)}
    generationTool="pam-ident {__version__}" variableNamingConvention="flat" numberOfEventIndicators="0">
  <ModelExchange {able}>{files}</ModelExchange>
  <CoSimulation {able} canHandleVariableCommunicationStepSize="true">{files}</CoSimulation>
  <UnitDefinitions>{"".join(units)}</UnitDefinitions>
  <ModelVariables>
    {"".join(variables).strip()}
  </ModelVariables>
  <ModelStructure>
    <Outputs>{unknown}</Outputs>
    <InitialUnknowns>{unknown}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def _variable(name: str, reference: int, about: str, causality: str) -> str:
    unit = f' unit="{UNITS[name][0]}"' if name in UNITS else ""
    start = f' start="{START.get(name, 0.0)}"' if causality == "input" else ""
    initial = ' initial="calculated"' if causality == "output" else ""
    head = f'name="{name}" valueReference="{reference}" causality="{causality}" variability="continuous"{initial}'
    return f"    <ScalarVariable {head} description={_quoted(about)}>\n      <Real{unit}{start}/></ScalarVariable>\n"


def _quoted(text: str) -> str:
    return quoteattr(harmless(text))


TARGET = Target(".fmu", _write)
