"""All that is thrown at the program, counted: damaged files, degenerate records, spikes, nulls, hostile requests.

    python benchmarks/faults.py [--seed N] [--share 0.1] [--only CLASS ...] [--markdown docs/validation.md]

Without a seed a fresh one is drawn. CLASS is one of files, degenerate, spikes, hostile, nulls, or one noise of the
nulls: what was cut off goes on with the same seed and the noises that are left. `--markdown` puts the lines into the
page's table, in place of those of the same classes. Commands run by the program's own door, so that exit codes and
stderr are the true ones. A failure of any class: an exit code but 0, 2, 3, 4, a traceback, an error of more than two
lines, a warning of Python; and what the table says of each.
"""

import argparse
import contextlib
import io
import json
import re
import runpy
import secrets
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

ROOT = Path(__file__).parents[1]
for _place in ("benchmarks", "tests/records", "tests/tasks", "tests/workbench"):
    sys.path.insert(0, str(ROOT / _place))

import degenerate
import nulls

from pam_ident.cli import app
from pam_ident.rig import Plan, Secret, make_record, write_case

TEXTS, BINARIES, DEGENERATE, SPIKED, NULLS, HOSTILE = 20_000, 2_000, 500, 60, 1_000, 200
HEAD = ("| class | a failure is also | seed | tried | ended | failures |", "|---|---|---:|---:|---|---:|")
OPEN, CLOSE = "<!-- faults -->\n", "<!-- /faults -->"
SPECIMEN = runpy.run_path(str(ROOT / "tests" / "cli" / "conftest.py"))["SPECIMEN"]
VERBS = ("inspect", "fit", "compare", "diagnose", "ladder")
PROGRESS = re.compile(r"after \d+ s: ")
"""What a slow command says on stderr as it goes."""
MOST_OFF = 2.0
"""Standard errors by which a spike may move a parameter: as far as its 95 % interval goes."""
Outcome = tuple[str, str]
"""How one trial ended, and what is wrong with it, empty where nothing is."""


@dataclass(frozen=True)
class Row:
    """A line of the table: class, what else counts as a failure there, number tried, how they ended, failures."""

    name: str
    asked: str
    seed: int
    tried: int
    ends: Counter[str]
    failures: list[str]

    def __str__(self) -> str:
        ends = ", ".join(f"{what} {n}" for what, n in sorted(self.ends.items()))
        return f"| {self.name} | {self.asked} | {self.seed} | {self.tried} | {ends} | {len(self.failures)} |"


def program(*words: object) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command, run in this process; what Python warns of is on stderr."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
        warnings.simplefilter("always")
        try:
            app([str(word) for word in words], prog_name="pam-ident")
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0
    return code, out.getvalue(), err.getvalue()


def ask(*words: object) -> tuple[int, dict, str]:
    """Exit code, answer and failure of a command with `--json -`."""
    code, out, err = program(*words, "--json", "-")
    err = "".join(line for line in err.splitlines(keepends=True) if not PROGRESS.match(line))
    wrong = "" if code in (0, 2, 3, 4) else f"exit code {code}: {err[-400:]}"
    if "Traceback" in err or len(err.strip().splitlines()) > 2 or (code == 0 and err):
        wrong = wrong or f"stderr: {err[-400:]}"
    try:
        answer = json.loads(out, parse_constant=lambda word: wrong_number(word)) if out else {}
    except ValueError as error:
        answer, wrong = {}, wrong or f"JSON: {error}"
    return code, answer, wrong or ("no JSON" if code in (0, 3, 4) and not answer else "")


def wrong_number(word: str) -> None:
    """No NaN or infinity may stand in JSON."""
    raise ValueError(f"holds {word}")


def damaged(share: float, seed: int) -> Iterator[Row]:
    """Text and binary files, each class in a process of its own with 4 GiB of memory."""
    faults = runpy.run_path(str(ROOT / "tests" / "records" / "faults.py"))
    import test_formats

    kinds = {"damaged cells and lines": TEXTS - len(faults["TEXTS"]) * (TEXTS // 8)}
    kinds |= dict.fromkeys(faults["TEXTS"], TEXTS // 8)
    kinds |= {name.removeprefix("r."): BINARIES for name in test_formats.GOOD_FILES}
    for kind, count in kinds.items():
        n = max(int(share * count), 20)
        ends, wrong = faults["tried"](kind, n, seed)
        yield Row(f"files: {kind}", "a wrong number or unit; a message without the file's name", seed, n, ends, wrong)


def trials(
    name: str, asked: str, count: int, seed: int, one: Callable[[int, np.random.Generator, Path], Outcome]
) -> Row:
    """`count` trials, each with a stream and a folder of its own."""
    ends, failures = Counter[str](), []
    for k in range(count):
        with tempfile.TemporaryDirectory() as folder:
            end, wrong = one(k, np.random.default_rng([seed, k]), Path(folder))
        ends[end] += 1
        if wrong:
            failures.append(f"[{seed}, {k}] {name}: {wrong}")
    return Row(name, asked, seed, count, ends, failures)


def degenerate_one(k: int, rng: np.random.Generator, folder: Path) -> Outcome:
    """A degenerate record before every verb, with a law that is stiff or one that bends."""
    kind = list(degenerate.KINDS)[k % len(degenerate.KINDS)]
    with np.errstate(all="ignore"):
        degenerate.frame(np.asarray(degenerate.KINDS[kind](rng), float)).to_csv(folder / "record.csv", index=False)
    (folder / "specimen.toml").write_text(SPECIMEN)
    law = ("chou_hannaford", "exponential_law", "auto")[k // len(degenerate.KINDS) % 3]
    named = "refused"
    for verb in VERBS:
        more = () if verb == "inspect" else ("--law", law)
        code, answer, wrong = ask(verb, folder / "record.csv", *more)
        if wrong:
            return "broke", f"{kind}, {verb} --law {law}: {wrong}"
        if verb == "diagnose" and code == 0:
            named = "named" if answer["selected"] else "nothing named"
    odd = named == "named" and kind in degenerate.NAMELESS
    return named, f"{kind}, --law {law}: named" if odd else ""


def spiked_one(k: int, rng: np.random.Generator, folder: Path) -> Outcome:
    """Spikes of 50 to 500 N in 0.2 % of the rows, one of 1e6 N, or one of 1e10 or 1e300: as of the clean record."""
    secrets_ = (Secret(("coulomb_friction", "creep", "force_drift")[k % 3]),) if k % 2 else ()
    write_case(folder, make_record(Plan(int(rng.integers(1 << 31)), secrets=secrets_)))
    path = folder / "record.csv"
    law = ("--law", "exponential_law")
    clean = {verb: ask(verb, path, *law)[1] for verb in ("fit", "diagnose")}
    table = pd.read_csv(path)
    n, size = len(table), (0.0, 1e6, (1e10, 1e300)[k % 2])[k % 3]
    rows = rng.choice(n, 1 if size else max(n // 500, 1), replace=False)
    table["force_N"] = table["force_N"].to_numpy(float)
    table.loc[rows, "force_N"] += size or rng.choice([-1.0, 1.0], len(rows)) * rng.uniform(50.0, 500.0, len(rows))
    table.to_csv(path, index=False)
    found = {verb: ask(verb, path, *law) for verb in VERBS[1:]}
    wrong = next((f"{verb}: {one[2]}" for verb, one in found.items() if one[2]), "")
    codes = {verb: code for verb, (code, *_) in found.items()}
    if size > 1e9:
        return "stopped, the row named", wrong or ("" if set(codes.values()) == {4} else f"exit codes {codes}")
    if size:
        assumed = ask("diagnose", path, *law, "--assume", "impossible_value")[1]
        wrong = wrong or ("" if codes["diagnose"] == codes["ladder"] == 4 else f"exit codes {codes}")
    else:
        assumed = found["diagnose"][1]
    off = furthest(found["fit"][1], clean["fit"])
    if off > MOST_OFF:
        wrong = wrong or f"a parameter is {off:.2g} standard errors off"
    same = all(assumed.get(key) == clean["diagnose"][key] for key in ("verdict", "selected"))
    return "left out", wrong or ("" if same else f"{assumed.get('selected')}, not {clean['diagnose']['selected']}")


def furthest(fit: dict, clean: dict) -> float:
    """Largest distance of a parameter from that of the clean record, in its standard errors."""
    now, then = (one["branches"]["together"]["parameters"] for one in (fit, clean))
    return max(abs(now[p]["value"] - then[p]["value"]) / then[p]["stderr"] for p in then if then[p]["stderr"])


def null_rows(kinds: list[str], share: float, seed: int) -> Iterator[Row]:
    """Nothing hidden: anything but `adequate`, or a refusal, is a false alarm."""
    each = -(-NULLS // len(nulls.NOISES))
    for kind in kinds:

        def one(k: int, rng: np.random.Generator, folder: Path, kind: str = kind) -> Outcome:
            law = nulls.write_null(kind, folder, rng)
            code, answer, wrong = ask("diagnose", folder / "record.csv", "--law", law)
            if code:
                return "refused", wrong
            pattern = (answer["pattern"] or {}).get("text", "")
            alarm = f"{answer['verdict']}: {', '.join(answer['selected'])} {pattern}"
            return answer["verdict"], wrong or ("" if answer["verdict"] == "adequate" else alarm)

        yield trials(f"null: {kind}", "a false alarm", max(int(share * each), 2), seed, one)


def hostile(share: float, seed: int) -> Row:
    """Requests and messages to a workbench that no browser sends."""
    from hostile import tried

    n = max(int(share * HOSTILE), 10)
    ends, failures = tried(n, seed, ROOT)
    asked = "the server ends, a traceback in its log, a path of the machine in an answer, a later client is not served"
    return Row("hostile requests to the workbench", asked, seed, n, ends, failures)


def rows(share: float, seed: int, only: tuple[str, ...]) -> Iterator[Row]:
    """The table, line by line."""
    if "files" in only:
        yield from damaged(share, seed)
    if "degenerate" in only:
        n = max(int(share * DEGENERATE), len(degenerate.KINDS))
        yield trials("degenerate records", "a name out of nothing", n, seed, degenerate_one)
    if "spikes" in only:
        asked = "a parameter moved out of its 95 % interval, another diagnosis, another story of the verbs"
        yield trials("records with spikes", asked, max(int(share * SPIKED), 6), seed, spiked_one)
    if "hostile" in only:
        yield hostile(share, seed)
    yield from null_rows([kind for kind in nulls.NOISES if "nulls" in only or kind in only], share, seed)


CLASSES = ("files", "degenerate", "spikes", "hostile", "nulls")


def main(words: list[str] | None = None) -> int:
    """Print the table, and each failure; how many there were."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=secrets.randbits(31))
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--only", nargs="+", choices=(*CLASSES, *nulls.NOISES), default=CLASSES)
    parser.add_argument("--markdown", type=Path)
    asked = parser.parse_args(words)
    print(*HEAD, sep="\n", flush=True)
    failures: list[str] = []
    for row in rows(asked.share, asked.seed, tuple(asked.only)):
        print(row, *row.failures[:20], sep="\n", flush=True)
        failures += row.failures
        if asked.markdown:
            put(row, asked.markdown)
    return len(failures)


def put(row: Row, page: Path) -> None:
    """Write a line into a page's table, in place of the one of the same class, else at the end."""
    before, rest = page.read_text(encoding="utf-8").split(OPEN, 1)
    lines = {line.split("|")[1].strip(): line for line in rest.split(CLOSE, 1)[0].splitlines()[len(HEAD) :]}
    lines[row.name] = str(row)
    text = "\n".join([*HEAD, *lines.values()])
    page.write_text(f"{before}{OPEN}{text}\n{CLOSE}{rest.split(CLOSE, 1)[1]}", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main() > 0)
