"""Files changed by chance, each read in a process of its own kind: read rightly, or refused in one sentence.

python tests/records/faults.py [TEXTS] [BINARIES] [SEED]

TEXTS text files (default 20000) and BINARIES of each binary format (default 2000); without SEED a fresh one is drawn.
The answer is a table: class, tried, read, refused, failures. What counts as a failure: an error that is none of the
program's own, a warning of Python, a message of more than two lines or without the file's name, a wrong number.
"""

import gzip
import io
import json
import secrets
import subprocess
import sys
import tempfile
import traceback
import warnings
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import mutations
from corpus import HEADERS, ROWS, SPECIMEN, as_text, values

from pam_ident.core import PamError
from pam_ident.core.units import TO_INTERNAL, conversion
from pam_ident.records import Specimen, read_record
from pam_ident.records.gate import doubts_of
from pam_ident.records.inspection import inspect_record

MUSCLE = Specimen("m1", 200.0, 10.0, 25.4, 1.5)
BARE = ("time", "pressure", "displacement", "force")
DIMENSIONS = ("time", "pressure", "length", "force")
UNITS = [unit for table in TO_INTERNAL.values() for unit in table] + [
    "bara",
    "bar abs",
    "psig",
    "kPa(a)",
    "torr",
    "kp",
    "Nm",
]
EXTREME = (
    *("1e300", "-1e300", "1e308", "9e999", "-1e308", "1e-320", "1e19", "-0", "1" * 400, "9" * 140_000, "x" * 140_000),
    *("12:30:00", "2024-02-30T00:00:00", "5 %", "99999999999:00:00", "nan", "-inf", "1__0", "0x1F", "1e", "+-1", ""),
    *('"', '""', "'", "=A1+1", "#DIV/0!", "\ufeff1", "1\u00a0000", "1'000", "\u0661", "1.167", "1,167", "1.234.567"),
)


def extreme(rng):
    """Cells that no sensor reads."""
    sep, decimal = ((",", "."), (";", ","), (";", "."), ("\t", "."), ("|", "."))[rng.integers(5)]
    lines = as_text(sep=sep, decimal=decimal).splitlines()
    touched = int(rng.integers(1, 4))
    for _ in range(touched):
        k = int(rng.integers(1, len(lines)))
        cells = lines[k].split(sep)
        cells[int(rng.integers(len(cells)))] = str(rng.choice(EXTREME))
        lines[k] = sep.join(cells)
    return "\n".join(lines) + "\n", lambda record: of_good_rows(record, 3, touched)


def mixed(rng):
    """Lines of another make than the others: delimiter, decimal mark, quotation marks, line ends."""
    seps = ("\t", ";", ",", "|", "  ")
    sep, decimal = seps[rng.integers(5)], ".,"[rng.integers(2)]
    decimal = "." if sep == "," else decimal
    lines = as_text(sep=sep, decimal=decimal).splitlines()
    touched = int(rng.integers(1, 5))
    for _ in range(touched):
        k, kind = int(rng.integers(len(lines))), int(rng.integers(5))
        if kind == 0:
            lines[k] = lines[k].replace(sep, seps[rng.integers(5)])
        elif kind == 1:
            lines[k] = lines[k].replace(decimal, ".,"[rng.integers(2)])
        elif kind == 2:
            lines[k] = sep.join(f'"{cell}"' for cell in lines[k].split(sep))
        elif kind == 3:
            lines[k] += ("\r", "\r\r", sep, sep * 2, " ", "\x1a", "\x00", " # ok")[rng.integers(8)]
        else:
            lines[k] = '"' + lines[k]
    return "\n".join(lines) + "\n", lambda record: of_good_rows(record, 4, touched)


def units(rng):
    """Any units in the header, in a row below or above it, or in both."""
    said = [str(rng.choice(list(TO_INTERNAL[d]) if rng.random() < 0.7 else UNITS)) for d in DIMENSIONS]
    below = [u if rng.random() < 0.8 else str(rng.choice(UNITS)) for u in said]
    where = int(rng.integers(4))
    style = ("{} [{}]", "{}_{}", "{} ({})")[rng.integers(3)]
    names = [style.format(n, u) if where != 1 else n for n, u in zip(BARE, said, strict=True)]
    row = ",".join(below) + "\n"
    text = as_text(names)
    if where == 1:
        said = below
    if where in (1, 2):
        text = text.replace("\n", "\n" + row, 1)
    if where == 3:
        text = row + text
    agree = where in (0, 1) or all(a.strip("°") == b.strip("°") for a, b in zip(said, below, strict=True))

    def judge(record):
        if not agree:
            return "two units that differ were read"
        for k, (unit, dimension) in enumerate(zip(said, DIMENSIONS, strict=True)):
            factor, offset = conversion(dimension, unit, "")
            seen = (record.inputs.time, record.inputs.pressure, record.inputs.displacement_mm, record.force)[k]
            if len(seen) != ROWS or not np.allclose(seen, values()[:, k] * factor + offset, rtol=1e-6, atol=1e-12):
                return f"{BARE[k]} is not in {unit}"
        return ""

    return text, judge


def clocks(rng):
    """Times as loggers write them, some cells spoilt."""
    start = float(rng.choice([0.0, 3599.5, 86398.7, 43200.0]))
    form = int(rng.integers(6))

    def cell(t):
        s = start + t
        day, s = (1, s - 86400.0) if s >= 86400.0 else (0, s)
        clock = f"{int(s // 3600):02d}:{int(s % 3600 // 60):02d}:{s % 60:06.3f}"
        date = f"2024-02-{28 + day:02d}"
        return (
            (
                clock,
                f"{date}T{clock}",
                f"{date} {clock}",
                f"{date}T{clock}Z",
                f"{int(1000 * t)}",
                f"{date}T{clock}+02:00",
            )
        )[form]

    rows = [[cell(row[0]), *row[1:]] for row in values().tolist()]
    touched = int(rng.integers(3))
    for _ in range(touched):
        rows[int(rng.integers(ROWS))][0] = str(
            rng.choice(["", "12:00", "0", "24:61:00", "2024-13-01T00:00:00", "noon"])
        )
    header = ("time", "time_s", "time [hh:mm:ss]", "time_ms")[rng.integers(4)] if form != 4 else "time_ms"

    def judge(record):
        time = record.inputs.time - record.inputs.time[0]
        tick = 0.05 if len({row[0] for row in rows}) < ROWS else 0.1  # a reading that is repeated is put into its tick
        steps = np.abs(np.diff(time) / tick - np.round(np.diff(time) / tick)).max()
        wrong = steps > 1e-3 or time[-1] > 2.31
        return f"times {time[:3]} …" if wrong or len(record) < ROWS - touched else ""

    return as_text((header, *HEADERS[1:]), rows), judge


def empty(rng):
    """Cells that are empty, up to all of a column."""
    rows = [[f"{cell:.6g}" for cell in row] for row in values().tolist()]
    columns = rng.permutation(4)[: rng.integers(1, 3)]
    gone = np.zeros(ROWS, bool)
    most = 0.0
    for k in columns.tolist():
        lost = rng.random(ROWS) < rng.choice([0.05, 0.2, 0.45, 1.0])
        for row in np.flatnonzero(lost).tolist():
            rows[row][k] = str(rng.choice(["", "NaN", "-", "n/a", " "]))
        gone, most = gone | lost, max(most, lost.mean())

    def judge(record):
        if most > 0.5:
            return "a column that is empty in most rows was read"
        left = sum(note.rows for note in record.notes)
        fine = left == gone.sum() and np.allclose(record.force, values()[~gone, 3])
        return "" if fine else f"{left} of {gone.sum()} rows are told of"

    return as_text(HEADERS, rows), judge


def of_good_rows(record, cells, lines):
    """Empty where the record's rows are the good table's but for so many cells in so many lines."""
    return mutations.verdict(record, ",".join(HEADERS), lines, cells)


TEXTS = {"extreme cells": extreme, "mixed dialects": mixed, "units": units, "clock times": clocks, "empty cells": empty}


# --- binary formats ----------------------------------------------------------------------------------------------


def good_binary(name, folder):
    """The bytes of the good table in a format."""
    import test_formats

    path = Path(folder) / f"good.{name}"
    test_formats.GOOD_FILES[f"r.{name}"](path)
    return path.read_bytes()


def changed_bytes(rng, data):
    """Bytes flipped, cut off, and once at most taken out or put in: two such changes can make up for each other, which
    no format without checksums can tell."""
    data = bytearray(data)
    flips, shifted = int(rng.integers(1, 4)), False
    for _ in range(flips):
        at, kind = int(rng.integers(len(data))), int(rng.integers(6))
        kind = 0 if kind >= 3 and shifted else kind
        shifted |= kind >= 3
        if kind < 3:
            data[at] = int(rng.choice([0, 1, 127, 128, 255, rng.integers(256)]))
        elif kind == 3:
            data[at : at + int(rng.integers(1, 40))] = b""
        elif kind == 4:
            piece = data[at : at + int(rng.integers(1, 40))]
            data[at:at] = piece
        else:
            del data[max(at, 16) :]
        if not data:
            data = bytearray(b"\0")
    return bytes(data), flips


def changed(name, rng, data):
    """A binary file changed, mostly behind its compression, and in how many places."""
    if name == "xlsx" and rng.random() < 0.7:
        book = zipfile.ZipFile(io.BytesIO(data))
        parts = {item: book.read(item) for item in book.namelist()}
        item = sorted(parts)[rng.integers(len(parts))]
        parts[item], flips = changed_bytes(rng, parts[item])
        with zipfile.ZipFile(out := io.BytesIO(), "w") as made:
            for key, content in parts.items():
                made.writestr(key, content)
        return out.getvalue(), flips
    if name == "csv.gz" and rng.random() < 0.7:
        text, flips = changed_bytes(rng, gzip.decompress(data))
        return gzip.compress(text, 1), flips
    return changed_bytes(rng, data)


def binary_judge(record, flips):
    """Each row one of the good table's, but for what a changed byte of a number can spoil."""
    seen = np.column_stack([record.inputs.pressure, record.inputs.displacement_mm, record.force])
    off = (~np.isclose(seen[:, None, :], values()[:, 1:], rtol=1e-6, atol=1e-9)).sum(axis=2).min(axis=1)
    # A piece cut out of, or put into, a column without row marks spoils up to 40 bytes, five numbers. A byte less makes
    # Pa of a heading's MPa: that is not silent where the gate stops at it.
    if (off > 0).sum() > 6 * flips and not any(d.grave and d.code == "scale" for d in doubts_of(record)):
        return f"{(off > 0).sum()} rows differ after {flips} changes"
    return ""


# --- one class ---------------------------------------------------------------------------------------------------


def outcome(path, judge):
    """Whether a file was "read" or "refused", and what is wrong, else empty."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            record = read_record(path, MUSCLE)
            inspect_record(record)
    except PamError as error:
        clear = path.name in str(error) and len(str(error).splitlines()) <= 2 and len(str(error)) < 1000
        return "refused", "" if clear and error.exit_code == 4 else f"unclear: {error!r}"
    except Exception:
        return "broke", traceback.format_exc()
    return "read", judge(record)


def run(kind, count, seed, folder):
    """Try `count` files of a class; print how many were read and refused, and each failure, as lines of JSON."""
    found, good = Counter(), None
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        if kind == "damaged cells and lines":
            _, end, fault = mutations.one(Path(folder), rng)
        elif kind in TEXTS:
            text, judge = TEXTS[kind](rng)
            path = Path(folder) / "record.csv"
            path.write_text(text, encoding=str(rng.choice(["utf-8", "utf-8", "utf-16"])), errors="replace", newline="")
            end, fault = outcome(path, judge)
        else:
            good = good or good_binary(kind, folder)
            data, flips = changed(kind, rng, good)
            path = Path(folder) / f"record.{kind}"
            path.write_bytes(data)
            end, fault = outcome(path, lambda record, flips=flips: binary_judge(record, flips))
        found[end] += 1
        print(json.dumps({"k": k, "end": end, "fault": fault}))


def tried(kind, count, seed):
    """A class in a process of its own, with 4 GiB of memory: its row of the table, and its failures."""
    code = (
        f"import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30)); "
        f"sys.path.insert(0, {str(Path(__file__).parent)!r}); import faults; "
        f"faults.run({kind!r}, {count}, {seed}, sys.argv[1])"
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "specimen.toml").write_text(SPECIMEN)
        done = subprocess.run([sys.executable, "-c", code, folder], capture_output=True, text=True, check=False)
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    ends = Counter(line["end"] for line in lines)
    faults = [f"[{seed}, {line['k']}] {kind}: {line['end']}: {line['fault']}" for line in lines if line["fault"]]
    if done.returncode or len(lines) < count:
        faults.append(f"[{seed}, {len(lines)}] {kind}: the process ended with {done.returncode}: {done.stderr[-800:]}")
    if "Traceback" in done.stderr and not done.returncode:
        faults.append(f"[{seed}] {kind}: on stderr: {done.stderr[-800:]}")
    return ends, faults


def main(texts=20_000, binaries=2_000, seed=None):
    """Print the table; how many failed."""
    import test_formats

    seed = secrets.randbits(32) if seed is None else seed
    share = {"damaged cells and lines": texts - len(TEXTS) * (texts // 8)} | dict.fromkeys(TEXTS, texts // 8)
    share |= {name.removeprefix("r."): binaries for name in test_formats.GOOD_FILES}
    print(f"seed {seed}\n\n| class | tried | read | refused | failures |\n|---|---:|---:|---:|---:|")
    wrong = []
    for kind, count in share.items():
        ends, faults = tried(kind, count, seed)
        print(f"| {kind} | {count} | {ends['read']} | {ends['refused']} | {len(faults)} |", flush=True)
        wrong += faults
    print(*wrong[:40], sep="\n")
    return len(wrong)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])) > 0)
