"""Damages good files by chance, and says whether what is read of a damaged file may be believed.

python tests/records/mutations.py [N] [SEED]     N files (default 20000), with what became of them
"""

import re
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from corpus import HEADERS, ROWS, SPECIMEN, as_text, values

from pam_ident.core import PamError
from pam_ident.core.units import ATMOSPHERE_MPA
from pam_ident.records import Specimen, read_record

NAMES = ("time", "pressure", "displacement", "force")
WIDE = np.column_stack([values(), np.arange(ROWS)])
LINES = as_text().splitlines(keepends=True)
TEXTS = {
    "commas": (as_text(), "utf-8", 1),
    "decimal commas": (as_text(sep=";", decimal=","), "utf-8", 1),
    "tabs": (as_text(sep="\t"), "utf-8", 1),
    "blanks": (as_text(sep="  "), "utf-8", 1),
    "UTF-16": (as_text(sep="\t", decimal=","), "utf-16", 1),
    "Latin-1, row of units": ("Prüfstand\n\n" + as_text(NAMES).replace("\n", "\ns,MPa,mm,N\n", 1), "latin-1", 4),
    "quoted": ("\n".join(",".join(f'"{c}"' for c in x.split(",")) for x in as_text().splitlines()), "utf-8", 1),
    "further columns": (as_text((*HEADERS, "valve"), WIDE, end="\r\n"), "utf-8", 1),
    "header twice": ("".join([*LINES[:13], LINES[0], *LINES[13:]]), "utf-8", 1),
}
"""Name → text, its encoding, the lines up to the first sample."""
JUNK = (
    "",
    "NaN",
    "1,5",
    "1.5",
    "inf",
    "--",
    "0x10",
    "1e5",
    "TRUE",
    "1.234,5",
    "1,234.5",
    "١",
    "−3",
    '"',
    "5 N",
    "3\t4",
)
BYTES = '0123456789.,;\t" -+eE\n\rNkPabrm_[]()#\x00é%'
SAID = {
    "pressure": {"MPa": 1.0, "kPa": 1e-3, "Pa": 1e-6, "bar": 0.1, "mbar": 1e-4, "psi": 6.894757293168361e-3},
    "displacement": {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 1e-3, "in": 25.4},
    "force": {"N": 1.0, "kN": 1000.0, "mN": 1e-3, "lbf": 4.4482216152605, "kgf": 9.80665},
}


def damage(text, sep, before, rng):
    """The text with one thing wrong, the number of lines touched, that of cells in any of them, and the first line."""
    at = int(rng.integers(len(text)))
    row = text.count("\n", 0, at)
    lines = text.splitlines(keepends=True)
    k = int(rng.integers(len(lines) - 1))
    kind = int(rng.integers(12))
    if kind == 0:
        return text[:at] + rng.choice(list(BYTES)) + text[at + 1 :], 2, 1, row
    if kind == 1:
        return text[:at] + text[at + 1 :], 2, 1, row
    if kind == 2:
        return text[:at] + rng.choice(list(BYTES)) + text[at:], 2, 1, row
    if kind == 3:
        return "".join(lines[:k] + lines[k + 1 :]), 1, 0, k
    if kind == 4:
        return "".join([*lines[: k + 1], *lines[k:]]), 1, 0, k
    if kind == 5:
        return "".join([*lines[:k], lines[k + 1], lines[k], *lines[k + 2 :]]), 2, 0, k
    if kind == 6:
        kept = text[: max(at, len(text) // 4)]
        return kept, len(lines), 1, kept.count("\n")
    cells = lines[k].rstrip("\r\n").split(sep)
    j = int(rng.integers(len(cells)))
    rest = lines[k][len(lines[k].rstrip("\r\n")) :]
    if kind == 7 and k >= before:
        i = int(rng.integers(len(cells)))
        cells[i], cells[j] = cells[j], cells[i]
    elif kind in (8, 9):
        cells[j] = str(rng.choice(JUNK))
    elif kind == 10:
        del cells[j]
    else:
        cells.insert(j, cells[j])
    return "".join([*lines[:k], sep.join(cells) + rest, *lines[k + 1 :]]), 1, 2 if kind == 7 else 1, k


def verdict(record, head, lines, cells):
    """What is wrong with a record read of a damaged file, empty where nothing is: each row must be one of the good
    file's but for the damaged cells, in the unit that the header says, and no more rows lost than were touched."""
    seen = np.column_stack([record.inputs.pressure, record.inputs.displacement_mm, record.force])
    if re.search(r"(?:pa|bar|psi)a(?![a-z])", head, re.I):  # a letter more, and the pressure counts from vacuum
        seen[:, 0] += ATMOSPHERE_MPA
    good = values()[:, 1:]
    for j, known in enumerate(SAID.values()):
        said = [f for unit, f in known.items() if re.search(rf"(?<![a-z]){unit}(?![a-z])", head, re.I)]
        scaled = [seen[:, j] / f for f in said or [1.0]]
        hits = [np.isclose(s[:, None], good[:, j], rtol=1e-6, atol=1e-9).any(axis=1).sum() for s in scaled]
        seen[:, j] = scaled[int(np.argmax(hits))]
    off = (~np.isclose(seen[:, None, :], good, rtol=1e-6, atol=1e-9)).sum(axis=2).min(axis=1)
    if (off > cells).any():
        return f"row {int(np.argmax(off > cells))} has {off.max()} cells of no row of the good file"
    if (off > 0).sum() > lines:
        return f"{int((off > 0).sum())} rows differ, {lines} lines were touched"
    if len(record) < ROWS - lines:
        return f"{len(record)} rows are left of {ROWS}, {lines} lines were touched"
    return ""


def one(folder, rng):
    """Damage a good file once or twice and read it: its kind, "refused" or "read", and what is wrong, else empty."""
    kind = str(rng.choice(list(TEXTS)))
    text, encoding, before = TEXTS[kind]
    sep = {"decimal commas": ";", "tabs": "\t", "UTF-16": "\t", "blanks": "  "}.get(kind, ",")
    lines = cells = 0
    rows = []
    for _ in range(int(rng.integers(1, 3))):
        text, more_lines, more_cells, row = damage(text, sep, before, rng)
        lines, cells, rows = lines + more_lines, cells + more_cells, [*rows, row]
    if len(rows) == 2 and abs(rows[0] - rows[1]) <= 1:
        cells = len(NAMES)  # a cell cut out of a row and another put in: no format can tell
    path = folder / "record.csv"
    path.write_bytes(text.encode(encoding, errors="replace"))
    try:
        record = read_record(path, Specimen("m1", 200.0, 10.0, 25.4, 1.5))
    except PamError as error:
        clear = "record.csv" in str(error) and len(str(error).splitlines()) <= 2
        return kind, "refused", "" if clear else f"unclear: {error}"
    except Exception:
        return kind, "broke", traceback.format_exc()
    head = "\n".join(text.splitlines()[: before + 1])
    return kind, "read", verdict(record, head, lines, cells)


def main(count=20_000, seed=0):
    warnings.simplefilter("error")
    found, wrong = Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "specimen.toml").write_text(SPECIMEN)
        for k in range(count):
            kind, end, fault = one(Path(folder), np.random.default_rng([seed, k]))
            found[kind, end] += 1
            if fault:
                wrong += 1
                print(f"[{seed}, {k}] {kind}: {end}: {fault}")
    for kind in TEXTS:
        print(f"{kind:24} read {found[kind, 'read']:6}  refused {found[kind, 'refused']:6}")
    print(f"{count} damaged files, {wrong} wrong")
    return wrong


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])) > 0)
