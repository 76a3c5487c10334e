"""The diagnosis beside what a careful user would try: stepwise regression by BIC, and PySINDy on the residual.

    python benchmarks/diagnosis_peers.py [--n 60] [--seed 103] [--workers 2] [--markdown FILE] [--out SET]

All answer the same sealed set, are scored by the same rules, and have the textbook formulas from the same catalogue.
Prints right / exact by kind and the median time of a record for each; `--markdown` writes the table between the marks
in a file. `--out` keeps the set and each method's answers, for `pam-ident challenge --out SET --answers FILE` to tell
more of; a run that was cut off goes on there. PySINDy is left out where it is not installed (extra `test`).
"""

import argparse
import json
import os
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np
from scipy.optimize import least_squares

from pam_ident.core.files import write_whole
from pam_ident.diagnosis.dictionary import regressors_at, slopes
from pam_ident.fitting import fit
from pam_ident.fitting.solve import jacobian
from pam_ident.model import Model, Term
from pam_ident.records import Record, read_record
from pam_ident.validation.challenge import answer_case, questions, write_challenge
from pam_ident.validation.score import KINDS, score, tally

try:
    import pysindy
except ImportError:
    pysindy = None

MARKS = ("<!-- peers -->", "<!-- /peers -->")
STRONG = 10.0
"""Fall of BIC that counts as very strong evidence (Kass & Raftery 1995, JASA 90, 773–795)."""


def textbook(record: Record) -> list[Term]:
    """Every candidate that the record can show, in its textbook form."""
    from pam_ident.effects import catalogue

    effects = [e for e in catalogue().values() if e.candidate and not e.missing(record.inputs)]
    return [Term(e, e.forms[0]) for e in effects]


def bic(squares: float, n: int, parameters: int) -> float:
    return n * float(np.log(squares / n)) + parameters * float(np.log(n))


def answer(selected: Sequence[str], rmse: float) -> dict:
    return {"verdict": "missing_effect" if selected else "adequate", "selected": list(selected), "rmse_after_N": rmse}


def refit(model: Model, record: Record, start: dict[str, float]) -> tuple[float, dict[str, float]]:
    """scipy's trust region over all parameters within their bounds: sum of squares, values."""
    params = model.bounded(record.inputs)
    unit = np.array([p.typical(start[p.name]) for p in params])
    lower, upper = (np.array([getattr(p, end) for p in params]) / unit for end in ("lower", "upper"))
    begin = np.clip(np.array([p.inside(start[p.name]) for p in params]) / unit, lower, upper)

    def residual(x: np.ndarray) -> np.ndarray:
        values = dict(zip(model.names, x * unit, strict=True))
        return np.nan_to_num(record.force - model.force(record.inputs, values), nan=1e6)

    found = least_squares(residual, begin, bounds=(lower, upper), x_scale="jac", max_nfev=40)
    return 2.0 * float(found.criterion), dict(zip(model.names, map(float, found.x * unit), strict=True))


def starts(term: Term) -> list[dict[str, float]]:
    """Sizes a tenth of their typical magnitude off neutral, shapes at each point of their grids."""
    name, form = term.effect.name, term.form
    sizes = {f"{name}.{p.name}": p.clip(p.neutral + 0.1 * p.scale) for p in form.linear}
    grids = product(*(p.grid or (p.start,) for p in form.nonlinear))
    return [sizes | {f"{name}.{p.name}": x for p, x in zip(form.nonlinear, point, strict=True)} for point in grids]


def stepwise(record: Record, law: str) -> dict:
    """Forward: add the textbook effect that lowers BIC most, all parameters refitted, while BIC falls strongly."""
    model = Model.build(law)
    n, selected = len(record), []
    squares, values = refit(model, record, fit(model, record, detail=False).values)
    terms = textbook(record)
    while True:
        now = bic(squares, n, len(model.params))
        selections = []
        for term in terms:
            if term.effect.name not in selected:
                larger = model.adding(term)
                best = min((refit(larger, record, values | s) for s in starts(term)), key=lambda item: item[0])
                selections.append((bic(best[0], n, len(larger.params)), term, larger, best))
        least, term, larger, best = min(selections, key=lambda item: item[0])
        if least > now - STRONG:
            return answer(selected, float(np.sqrt(squares / n)))
        model, (squares, values) = larger, best
        selected.append(term.effect.name)


def sindy(optimizers: Callable[[float], list]) -> Callable[[Record, str], dict]:
    """PySINDy on what the law leaves, with the textbook signatures as library; the sparsity is chosen by BIC.

    What the law itself can follow is projected out of residual and signatures, and these are scaled to unit rms, so
    that thresholds are forces in N.
    """

    def run(record: Record, law: str) -> dict:
        model, inputs, n = Model.build(law), record.inputs, len(record)
        base = fit(model, record, detail=False)
        around = slopes(model, inputs, base.values)
        basis = np.linalg.qr(jacobian(model, inputs, base.values, record.force))[0]
        names, columns = [], []
        for term in textbook(record):
            shapes = [{p.name: s[f"{term.effect.name}.{p.name}"] for p in term.form.nonlinear} for s in starts(term)]
            for regressor in regressors_at(term.effect, term.form, shapes, inputs, around):
                left = regressor.columns - basis @ (basis.T @ regressor.columns)
                seen = np.linalg.norm(left, axis=0) > 0.05 * np.linalg.norm(regressor.columns, axis=0) + 1e-9
                columns.append(left[:, seen] / np.sqrt(np.mean(left[:, seen] ** 2, axis=0)))
                names += [term.effect.name] * int(seen.sum())
        library, residual = np.hstack(columns), base.residual - basis @ (basis.T @ base.residual)
        best = (bic(float(residual @ residual), n, 0), np.zeros(len(names)))
        for optimizer in optimizers(float(np.sqrt(np.mean(residual**2)))):
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


def stlsq(rms: float) -> list:
    return [pysindy.STLSQ(threshold=rms * share, alpha=1e-6) for share in np.geomspace(0.01, 0.9, 12)]


def ssr(rms: float) -> list:
    return [pysindy.SSR(alpha=1e-6, max_iter=60)]


PEERS: dict[str, Callable[[Record, str], dict]] = {"stepwise BIC, scipy": stepwise}
if pysindy is not None:
    PEERS |= {"PySINDy STLSQ": sindy(stlsq), "PySINDy SSR": sindy(ssr)}


def case(folder: Path, name: str, law: str) -> dict[str, tuple[dict, float]]:
    """Each method's answer to a case, and its time in s; kept beside the record, and taken from there."""
    kept = folder / name / "answers.json"
    if kept.exists():
        return {method: (found, seconds) for method, (found, seconds) in json.loads(kept.read_text()).items()}
    warnings.simplefilter("ignore")
    found, start = {}, time.perf_counter()
    ours = answer_case(folder, name, law)
    found["pam-ident"] = (ours, time.perf_counter() - start)
    for peer, method in PEERS.items():
        start = time.perf_counter()
        found[peer] = (method(read_record(str(folder / name / "record.csv")), law), time.perf_counter() - start)
    write_whole(kept, json.dumps(found))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=60)
    parser.add_argument("--seed", type=int, default=103)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--markdown", type=Path)
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    if pysindy is None:
        print("PySINDy is not installed and left out: pip install 'pam-ident[test]'", file=sys.stderr)
    with TemporaryDirectory() as temporary:
        folder = asked.out or Path(temporary, "set")
        if not (folder / "truth.json").exists():
            write_challenge(str(folder), asked.n, asked.seed)
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
