"""A fitted model as a functional mock-up unit, FMI 2.0, for model exchange and co-simulation."""

from functools import partial

from ..fmi import FMU, FMIVersion, write_unit
from ..target import Target


def _texts(unit: FMU) -> dict[str, str]:
    able = f'modelIdentifier="{unit.name}" canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
    files = '<SourceFiles><File name="fmi2.c"/></SourceFiles>'
    rows = [f"    <ScalarVariable {head}><Real{kind}/></ScalarVariable>" for head, kind in unit.variables()]
    unknown = f'<Unknown index="{len(rows)}"/>'
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<fmiModelDescription fmiVersion="2.0" guid="{unit.token}" {unit.head}',
        '    variableNamingConvention="flat" numberOfEventIndicators="0">',
        f"  <ModelExchange {able}>{files}</ModelExchange>",
        f'  <CoSimulation {able} canHandleVariableCommunicationStepSize="true">{files}</CoSimulation>',
        f"  <UnitDefinitions>{unit.units}</UnitDefinitions>",
        "  <ModelVariables>",
        *rows,
        "  </ModelVariables>",
        f"  <ModelStructure><Outputs>{unknown}</Outputs><InitialUnknowns>{unknown}</InitialUnknowns></ModelStructure>",
        "</fmiModelDescription>",
    ]
    return {"modelDescription.xml": "\n".join([*lines, ""])}


FOLDERS = {
    ("Linux", "x86_64"): "linux64",
    ("Darwin", "x86_64"): "darwin64",
    ("Darwin", "arm64"): "darwin64",
    ("Windows", "AMD64"): "win64",
}
TARGET = Target(".fmu", partial(write_unit, FMIVersion("fmi2.c", FOLDERS, _texts)))
