"""The table of a batch as Parquet: the same bytes for the same answers, and read back whatever program wrote it."""

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core import UsageError, blank_nan
from ..schema.fit import in_order
from ..schema.versions import schema
from .record import Store
from .request import BatchRequest, Item, WorkList

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

Json = dict[str, Any]
SCHEMA = schema("batch")
ROWS_AT_ONCE = 4096
TAKEN_OVER = ("branch", "error", "selected", "warnings", "n", "rmse_N", "rmse_mm", "noise_floor_N")
SPECIMEN = {"name": "string", "initial_length_mm": "double", "diameter_mm": "double", "serial_number": "int64"}


def require_arrow() -> None:
    """Raises UsageError where pyarrow, which the table needs, is not installed."""
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise UsageError("batch writes Parquet, which needs pyarrow; pip install 'pam-ident[cluster]'") from None


def table(plan: WorkList, question: BatchRequest, store: Store, lost: dict[str, str]) -> bytes:
    """The bytes of the Parquet table: a row for each record and branch, in the order of their names.

    `lost` maps names of records to why nothing is kept of them. Nothing that changes from run to run is in it: no
    date, no place, no number of workers. It is built a few thousand rows at a time.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    out, versions = io.BytesIO(), set[str]()
    schema = _schema(question)
    with pq.ParquetWriter(out, schema, compression="zstd", version="2.6") as writer:
        rows: list[Json] = []
        for row in _rows(plan, question, store, lost, versions):
            rows.append(row)
            if len(rows) == ROWS_AT_ONCE:
                writer.write_table(pa.Table.from_pylist(rows, schema))
                rows = []
        if rows:
            writer.write_table(pa.Table.from_pylist(rows, schema))
        writer.add_key_value_metadata({"versions": json.dumps([json.loads(one) for one in sorted(versions)])})
    return out.getvalue()


def _schema(question: BatchRequest) -> "pa.Schema":
    import pyarrow as pa

    model = question.setup.model
    texts, numbers = pa.string(), pa.float64()
    fields: list[Any] = [("record", texts), ("branch", texts), ("law", texts), ("effects", pa.list_(texts))]
    fields += [("verdict", texts), ("rmse_N", numbers), ("noise_floor_N", numbers)]
    for param in in_order(model.params):
        about = {"unit": param.unit, "meaning": param.doc}
        fields += [pa.field(name, numbers, metadata=about) for name in (param.name, f"{param.name}_stderr")]
    fields += [("error", texts), ("selected", pa.list_(texts)), ("warnings", pa.list_(texts))]
    fields += [("n", pa.int64()), ("rmse_mm", numbers)]
    fields += [(f"specimen_{name}", pa.type_for_alias(kind)) for name, kind in SPECIMEN.items()]
    about = {"schema": SCHEMA, "question": json.dumps(question.words() | {"law": model.law.name}, sort_keys=True)}
    return pa.schema(fields, metadata=about)


def _rows(
    plan: WorkList, question: BatchRequest, store: Store, lost: dict[str, str], versions: set[str]
) -> Iterator[Json]:
    model = question.setup.model
    common = {"law": model.law.name, "effects": model.labels}
    items: dict[str, Item | None] = {item.name: item for item in plan.items} | dict.fromkeys(plan.faults)
    for name, item in sorted(items.items()):
        kept = None if item is None else store.get(item.key)
        if kept is None:
            message = (lost | plan.faults)[name]
            for branch in question.branches:
                yield common | {"record": name, "branch": branch, "error": message}
            continue
        versions.add(json.dumps(kept["versions"], sort_keys=True))
        muscle = {f"specimen_{key}": value for key, value in (kept["specimen"] or {}).items()}
        for row in kept["rows"]:
            yield common | muscle | {"record": name} | _flat(row)


def _flat(row: Json) -> Json:
    """A row as it is kept, its parameters as columns; without a diagnosis the test for a lack of fit is the verdict."""
    flat = {key: row.get(key) for key in TAKEN_OVER}
    flat["verdict"] = row.get("verdict", row.get("lack_of_fit"))
    for name, (value, stderr) in row.get("parameters", {}).items():
        flat |= {name: value, f"{name}_stderr": stderr}
    return blank_nan(flat)


def as_csv(parquet: bytes) -> str:
    """The same table as text, for programs that read no Parquet; lists are joined by ';'."""
    import pyarrow.parquet as pq

    frame = pq.read_table(io.BytesIO(parquet)).to_pandas(integer_object_nulls=True)
    for name in ("effects", "selected", "warnings"):
        frame[name] = [None if one is None else ";".join(one) for one in frame[name]]
    return frame.to_csv(index=False, lineterminator="\n")


def read_results(path: str | Path) -> "pd.DataFrame":
    """The table of a batch, from its folder or file, whichever version of the program wrote it.

    `attrs` hold its question and the versions of what computed it. Raises UsageError for what is no such table, or
    one of a later schema.
    """
    require_arrow()
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = Path(path)
    path = path / "results.parquet" if path.is_dir() else path
    try:
        file = pq.ParquetFile(path)
    except (OSError, pa.ArrowInvalid) as error:
        raise UsageError(f"{path}: not a table of a batch ({' '.join(str(error).split())[:80]})") from None
    about = {key.decode(): value.decode() for key, value in (file.metadata.metadata or {}).items()}
    if about.get("schema") != SCHEMA:
        raise UsageError(f"{path}: schema {about.get('schema')!r}; expected {SCHEMA}. Update pam-ident, or batch again")
    found = file.read()
    frame = found.to_pandas()
    frame.attrs = {"question": json.loads(about["question"]), "versions": json.loads(about["versions"])}
    frame.attrs["units"] = {f.name: f.metadata[b"unit"].decode() for f in found.schema if f.metadata}
    return frame
