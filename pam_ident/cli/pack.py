"""pam-ident pack."""

from dataclasses import replace
from typing import Annotated

from . import options, text


def pack(
    record: options.Record,
    out: Annotated[str, options.option("--out", "FOLDER", "The folder to write, which is not there yet.")],
    metadata: Annotated[
        str | None,
        options.option(
            "--metadata",
            "FILE.toml",
            "What is known of the record (rig, calibration, operator, date, licence; any keys); default: metadata.toml "
            "beside it.",
        ),
    ] = None,
    specimen: options.SpecimenFile = None,
    json: options.JsonFile = None,
    where: options.Where = None,
) -> None:
    """Put a record and all that belongs to it into one folder.

    Data, units, specimen and metadata as a Data Package, which every command reads.
    """
    from ..export.package import check_folder, write_package
    from ..records.gate import doubts_of
    from ..records.package import metadata_of, told
    from ..schema.versions import schema, warnings_json
    from ..tasks.setup import load

    check_folder(out)
    found = load(record, specimen, where)
    if metadata is not None:
        found = replace(found, metadata=metadata_of(metadata))
    files = [str(path) for path in write_package(found, out)]
    doubts = doubts_of(found)
    options.give_json(
        json,
        lambda: {
            "schema": schema("package"),
            "record": record,
            "n": len(found),
            "files": files,
            "metadata": dict(found.metadata),
            "warnings": warnings_json(doubts),
        },
    )
    text.say(*(f"wrote {file}" for file in files))
    text.say(*(f"known: {words}: {value}" for words, value in told(found.metadata)))
    if not found.metadata:
        text.say("Nothing else is known of it; write a metadata.toml (rig, calibration, operator, date, licence).")
    text.say(*map(str, doubts))
