"""A fitted model as a functional mock-up unit, FMI 3.0, for model exchange and co-simulation."""

from functools import partial

from ..fmi import FMU, FMIVersion, write_unit
from ..target import Target


def _texts(unit: FMU) -> dict[str, str]:
    able = f'modelIdentifier="{unit.name}" canGetAndSetFMUState="true" canSerializeFMUState="true"'
    rows = [f"    <Float64 {head}{kind}/>" for head, kind in unit.variables()]
    force, time = len(unit.inputs), len(unit.inputs) + 1
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<fmiModelDescription fmiVersion="3.0" instantiationToken="{unit.token}" {unit.head}',
        '    variableNamingConvention="flat">',
        f'  <ModelExchange {able} needsCompletedIntegratorStep="true"/>',
        f'  <CoSimulation {able} canHandleVariableCommunicationStepSize="true"/>',
        f"  <UnitDefinitions>{unit.units}</UnitDefinitions>",
        "  <ModelVariables>",
        *rows,
        f'    <Float64 name="time" valueReference="{time}" causality="independent" variability="continuous"/>',
        "  </ModelVariables>",
        "  <ModelStructure>",
        f'    <Output valueReference="{force}"/><InitialUnknown valueReference="{force}"/>',
        "  </ModelStructure>",
        "</fmiModelDescription>",
    ]
    build = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<fmiBuildDescription fmiVersion="3.0">',
        f'  <BuildConfiguration modelIdentifier="{unit.name}">',
        '    <SourceFileSet language="C99"><SourceFile name="fmi3.c"/></SourceFileSet>',
        "  </BuildConfiguration>",
        "</fmiBuildDescription>",
    ]
    return {
        "modelDescription.xml": "\n".join([*lines, ""]),
        "sources/buildDescription.xml": "\n".join([*build, ""]),
    }


FOLDERS = {
    ("Linux", "x86_64"): "x86_64-linux",
    ("Linux", "aarch64"): "aarch64-linux",
    ("Darwin", "x86_64"): "x86_64-darwin",
    ("Darwin", "arm64"): "aarch64-darwin",
    ("Windows", "AMD64"): "x86_64-windows",
}
TARGET = Target(".fmu", partial(write_unit, FMIVersion("fmi3.c", FOLDERS, _texts)))
