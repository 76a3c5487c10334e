"""The diagnosis beside what a careful user would try: stepwise regression by BIC, and PySINDy on the residual.

    python benchmarks/diagnosis_peers.py [--n 60] [--seed 103] [--holdout forms] [--workers 2]
                                         [--markdown FILE] [--out SET]

All answer the same sealed set and are scored by the same rules. Each peer is there twice: with the textbook formula of
every effect and white noise, and with every written formula of the catalogue and noise that is correlated from sample
to sample (AR(1), Cochrane & Orcutt 1949). What is method and what is dictionary shows then. `--holdout` leaves what is
hidden out of the catalogue of all. Prints right / exact by kind and the median time of a record for each; `--markdown`
writes the table between the marks in a file. `--out` keeps the set and each method's answers, for `pam-ident challenge
--out SET --answers FILE` to tell more of; a run that was cut off goes on there. PySINDy is left out where it is not
installed (extra `test`).
"""

import argparse
import json
import math
import os
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np
from scipy.optimize import least_squares

from pam_ident.core.files import write_whole
from pam_ident.diagnosis.dictionary import grid, regressors_at, slopes
from pam_ident.effects import catalogue
from pam_ident.fitting import fit
from pam_ident.fitting.solve import jacobian
from pam_ident.model import Model, Term
from pam_ident.records import Record, read_record
from pam_ident.tasks.setup import Setup
from pam_ident.validation.challenge import answer_case, questions, write_challenge
from pam_ident.validation.score import KINDS, score, tally

try:
    import pysindy
except ImportError:
    pysindy = None

MARKS = ("<!-- peers -->", "<!-- /peers -->")
STRONG = 10.0
"""Fall of BIC that counts as very strong evidence (Kass & Raftery 1995, JASA 90, 773–795)."""
REFITTED = 5
"""Terms of a step that are fitted exactly, those that a linear fit promises most of."""
White = Callable[[np.ndarray], np.ndarray]
KNOWN = {False: "textbook", True: "all forms, AR(1)"}


@dataclass(frozen=True)
class Dictionary:
    """What a peer knows of a record: forms of effects that it may add, and whether noise may be correlated."""

    record: Record
    terms: tuple[Term, ...]
    correlated: bool

    @classmethod
    def of(cls, record: Record, without: Sequence[str], everything: bool) -> "Dictionary":
        """Every candidate that the record can show, in its textbook form or in every one that is written."""
        terms = []
        for effect in catalogue().values():
            if effect.candidate and not effect.missing(record.inputs):
                forms = effect.written if everything else effect.written[:1]
                found = [Term(effect, form) for form in forms]
                terms += [t for t in found if not {t.effect.name, f"{effect.name}:{t.form.name}"} & set(without)]
        return cls(record, tuple(terms), everything)

    def whitened(self, residual: np.ndarray) -> White:
        """Differences of neighbours that leave noise white which is as correlated as a residual (n,); columns too."""
        rho = (
            float(np.clip(residual[:-1] @ residual[1:] / (residual @ residual), 0.0, 0.99)) if self.correlated else 0.0
        )

        def white(values: np.ndarray) -> np.ndarray:
            return np.concatenate([values[:1] * math.sqrt(1.0 - rho**2), values[1:] - rho * values[:-1]])

        return white


def bic(squares: float, n: int, parameters: int) -> float:
    return n * float(np.log(squares / n)) + parameters * float(np.log(n))


def answer(selected: Sequence[str], rmse: float) -> dict:
    return {"verdict": "missing_effect" if selected else "adequate", "selected": list(selected), "rmse_after_N": rmse}


def refit(model: Model, record: Record, start: dict[str, float], white: White) -> tuple[float, dict[str, float]]:
    """scipy's trust region over all parameters within their bounds: sum of squares, values."""
    params = model.bounded(record.inputs)
    unit = np.array([p.typical(start[p.name]) for p in params])
    lower, upper = (np.array([getattr(p, end) for p in params]) / unit for end in ("lower", "upper"))
    begin = np.clip(np.array([p.inside(start[p.name]) for p in params]) / unit, lower, upper)

    def residual(x: np.ndarray) -> np.ndarray:
        values = dict(zip(model.names, x * unit, strict=True))
        return white(np.nan_to_num(left_by(model, record, values), nan=1e6))

    def slopes_at(x: np.ndarray) -> np.ndarray:
        values = dict(zip(model.names, x * unit, strict=True))
        return -white(np.nan_to_num(jacobian(model, record.inputs, values, record.force))) * unit

    found = least_squares(residual, begin, slopes_at, bounds=(lower, upper), x_scale="jac", max_nfev=40)
    return 2.0 * float(found.cost), dict(zip(model.names, map(float, found.x * unit), strict=True))


def left_by(model: Model, record: Record, values: dict[str, float]) -> np.ndarray:
    return record.force - model.force(record.inputs, values)


def promising(
    known: Dictionary, model: Model, values: dict[str, float], white: White, selected: Sequence[str]
) -> list[tuple[Term, dict[str, float]]]:
    """The terms that a linear fit around the model promises most of, with where that fit ends, the best first."""
    record, found = known.record, []
    around = slopes(model, record.inputs, values)
    basis = np.linalg.qr(white(jacobian(model, record.inputs, values, record.force)))[0]
    target = white(left_by(model, record, values))
    for term in (t for t in known.terms if t.effect.name not in selected):
        best = (0.0, {})
        for regressor in regressors_at(term.effect, term.form, grid(term.form, record.inputs), record.inputs, around):
            columns = white(regressor.columns)
            columns = columns - basis @ (basis.T @ columns)
            sizes = np.linalg.lstsq(columns, target, rcond=1e-9)[0]
            gain = float(target @ columns @ sizes) - math.log(len(target)) * regressor.free
            start = regressor.point | {
                p.name: p.clip(p.neutral + x) for p, x in zip(regressor.linear, sizes, strict=True)
            }
            best = max(best, (gain, start), key=lambda one: one[0])
        found.append((best[0], term, {f"{term.effect.name}.{k}": float(v) for k, v in best[1].items()}))
    found.sort(key=lambda one: -one[0])
    return [(term, start) for gain, term, start in found[:REFITTED] if start]


def stepwise(everything: bool) -> Callable[[Record, Setup], dict]:
    """Forward: add the term that lowers BIC most, all parameters refitted, while BIC falls strongly."""

    def run(record: Record, setup: Setup) -> dict:
        known, model, n = Dictionary.of(record, setup.without, everything), Model.build(setup.law), len(record)
        values = fit(model, record, detail=False).values
        selected: list[str] = []
        while True:
            white = known.whitened(left_by(model, record, values))
            squares, values = refit(model, record, values, white)
            now, selections = bic(squares, n, len(model.params)), []
            for term, start in promising(known, model, values, white, selected):
                larger = model.adding(term)
                squares, found = refit(larger, record, values | start, white)
                selections.append((bic(squares, n, len(larger.params)), term, larger, found))
            least, term, larger, found = min(selections, key=lambda one: one[0], default=(math.inf, None, None, None))
            if least > now - STRONG:
                return answer(selected, float(np.sqrt(np.mean(left_by(model, record, values) ** 2))))
            model, values = larger, found
            selected.append(term.effect.name)

    return run


def sindy(everything: bool) -> Callable[[Record, Setup], dict]:
    """PySINDy on what the law leaves, with signatures of the terms as library; the sparsity is chosen by BIC.

    What the law itself can follow is projected out of residual and signatures, and these are scaled to unit rms, so
    that thresholds are forces in N.
    """

    def run(record: Record, setup: Setup) -> dict:
        known, model, n = Dictionary.of(record, setup.without, everything), Model.build(setup.law), len(record)
        base = fit(model, record, detail=False)
        white, around = known.whitened(base.residual), slopes(model, record.inputs, base.values)
        basis = np.linalg.qr(white(jacobian(model, record.inputs, base.values, record.force)))[0]
        names, columns = [], []
        for term in known.terms:
            points = grid(term.form, record.inputs)
            for regressor in regressors_at(term.effect, term.form, points, record.inputs, around):
                whole = white(regressor.columns)
                left = whole - basis @ (basis.T @ whole)
                seen = np.linalg.norm(left, axis=0) > 0.05 * np.linalg.norm(whole, axis=0) + 1e-9
                columns.append(left[:, seen] / np.sqrt(np.mean(left[:, seen] ** 2, axis=0)))
                names += [term.effect.name] * int(seen.sum())
        library, residual = np.hstack(columns), white(base.residual)
        residual = residual - basis @ (basis.T @ residual)
        best = (bic(float(residual @ residual), n, 0), np.zeros(len(names)))
        rms = float(np.sqrt(np.mean(residual**2)))
        for share in np.geomspace(0.01, 0.9, 12):
            optimizer = pysindy.STLSQ(threshold=rms * share, alpha=1e-6)
            sparse = pysindy.SINDy(optimizer=optimizer, feature_library=pysindy.IdentityLibrary())
            sparse.fit(library, t=1.0, x_dot=residual[:, None])
            for sizes in getattr(optimizer, "history_", None) or [sparse.coefficients()]:
                sizes = np.ravel(sizes)
                squares = float(np.sum((residual - library @ sizes) ** 2))
                best = min(best, (bic(squares, n, int(np.count_nonzero(sizes))), sizes), key=lambda item: item[0])
        ordered = sorted(np.flatnonzero(best[1]), key=lambda k: -abs(best[1][k]))
        left = residual - library @ best[1]
        return answer(list(dict.fromkeys(names[k] for k in ordered)), float(np.sqrt(np.mean(left**2))))

    return run


PEERS = {f"stepwise BIC, {KNOWN[everything]}": stepwise(everything) for everything in (False, True)}
if pysindy is not None:
    PEERS |= {f"sparse (STLSQ), {KNOWN[everything]}": sindy(everything) for everything in (False, True)}


def case(folder: Path, name: str, setup: Setup) -> dict[str, tuple[dict, float]]:
    """Each method's answer to a case, and its time in s; kept beside the record, and taken from there."""
    kept = folder / name / "answers.json"
    if kept.exists():
        return {method: (found, seconds) for method, (found, seconds) in json.loads(kept.read_text()).items()}
    warnings.simplefilter("ignore")
    found, start = {}, time.perf_counter()
    ours = answer_case(folder, name, setup)
    found["pam-ident"] = (ours, time.perf_counter() - start)
    for peer, method in PEERS.items():
        start = time.perf_counter()
        found[peer] = (method(read_record(str(folder / name / "record.csv")), setup), time.perf_counter() - start)
    write_whole(kept, json.dumps(found))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=60)
    parser.add_argument("--seed", type=int, default=103)
    parser.add_argument("--holdout", choices=("forms", "effects"))
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    if pysindy is None:
        print("PySINDy is not installed and left out: pip install 'pam-ident[test]'", file=sys.stderr)
    with TemporaryDirectory() as temporary:
        folder = asked.out or Path(temporary, "set")
        if not (folder / "truth.json").exists():
            write_challenge(str(folder), asked.n, asked.seed, holdout=asked.holdout)
        names = questions(folder)
        with ProcessPoolExecutor(asked.workers) as pool:
            answers = list(pool.map(case, [folder] * len(names), names, names.values()))
        for method in answers[0]:
            lines = [json.dumps({"case": name} | a[method][0]) for name, a in zip(names, answers, strict=True)]
            (folder / f"{method}.jsonl").write_text("\n".join(lines))
        truth = json.loads((folder / "truth.json").read_text())
    text = table(truth, answers)
    print(text)
    if asked.markdown is not None:
        page = asked.markdown.read_text(encoding="utf-8")
        before, after = page.split(MARKS[0])[0], page.split(MARKS[1])[1]
        asked.markdown.write_text(f"{before}{MARKS[0]}\n{text}\n{MARKS[1]}{after}", encoding="utf-8")
    return 0


def table(truth: list[dict], answers: list[dict[str, tuple[dict, float]]]) -> str:
    """Right / exact by kind, and the median time of a record."""
    methods = list(answers[0])
    lines = {m: tally([score(t, a[m][0]) for t, a in zip(truth, answers, strict=True)]) for m in methods}
    rows = ["| kind | records | " + " | ".join(methods) + " |", "|---|---:|" + "---:|" * len(methods)]
    for k, line in enumerate(lines[methods[0]]):
        cells = [f"{100 * t[k].right / t[k].n:.0f} % / {100 * t[k].exact / t[k].n:.0f} %" for t in lines.values()]
        rows.append(f"| {KINDS.get(line.kind, line.kind)} | {line.n} | " + " | ".join(cells) + " |")
    times = [f"{median(a[m][1] for a in answers):.2f} s" for m in methods]
    return "\n".join([*rows, "| median time of a record | | " + " | ".join(times) + " |"])


if __name__ == "__main__":
    sys.exit(main())
