"""What is each rule of the diagnosis worth? Sets are answered with all rules, then with one left out at a time.

    pam-ident challenge --n 200 --seed 1 --protocols all --out SET
    python benchmarks/diagnosis_ablation.py SET ... [--rule NAME ...] [--most 60] [--workers 2]

The first answers tell which rules made a difference on their way; with a rule left out only the records are answered
again where it did. Prints a line a rule: records that it reached, those answered again, and of these how many were
right and exact, and how many statements of 0.9 or more false, with the rule and without. What differs follows it.
"""

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

from pam_ident.diagnosis.search import CLOSE
from pam_ident.validation.challenge import answer_case, questions
from pam_ident.validation.score import Score, score

Rule = tuple[str, str, Callable[..., Any]]
RULES: dict[str, Rule] = {
    "effects that written forms find": ("diagnose", "likelier_instead", lambda answer, others: []),
    "names that something unknown outweighs go": ("adequacy", "outdoes_free", lambda selection, fitted: True),
    "needless and unlikely names go": ("answer", "_likely", lambda selection, fitted: fitted),
    "names that explain nearly all stand": ("adequacy", "Adequacy.standing", lambda self: self._following(frozenset())),
    "names that what is left does not overturn": (
        "answer",
        "in_spite_of",
        lambda selection, *_: (selection, selection.empty),
    ),
    "noise is as large as its innovations": ("adequacy", "larger_than_noise", lambda selection, fitted: False),
    "no set is compared by noise that it exceeds": ("select", "larger_than_noise", lambda selection, fitted: False),
    "noise does not come back": ("adequacy", "comes_back", lambda record, residual, rows: 0.0),
    "what comes back is no noise": ("noise", "without_repeats", lambda record, residual, rows: residual),
    "1/f noise": ("noise", "likelier_colour", lambda *_: (0.0, 1.0)),
    "a pattern outlives heavy tails": ("select", "_outlives_tails", lambda selection, found, fitted: True),
    "forms are exchanged": ("select", "_in_other_forms", lambda selection, fitted, fewer: []),
    "noise is foretold by its colour alone": ("remainder", "_foretold", lambda selection, fitted: None),
    "noise does not jump": ("remainder", "_jumps", lambda selection, fitted: None),
    "noise has no bursts": ("remainder", "_bursts", lambda selection, fitted: None),
    "noise does not know the speed": ("remainder", "_slow", lambda selection, fitted: None),
    "noise does not know whether the muscle moves": ("remainder", "_in_motion", lambda selection, fitted: None),
    "load cells hum": ("remainder", "hum", lambda selection, fitted: 0.0),
    "noise does not grow at the turns": ("remainder", "_at_turns", lambda selection, fitted: None),
    "values are held in nature's range": ("confirmed", "_as_nature_allows", lambda best, wrong: best),
    "values against nature go": ("confirmed", "_beyond_nature", lambda best, fitted: []),
    "a form's own name": ("confounding", "_same_form", lambda selection, term: []),
    "groups by what was fitted": ("confounding", "_fitted", lambda selection, fitted, effect: []),
    "groups at one speed": ("confounding", "_same_at_one_speed", lambda selection, rest, effect: []),
    "names by their form alone": ("outcome", "by_form_alone", lambda *_: {}),
    "groups by a free form": ("confounding", "_general", lambda *_: []),
    "groups by what a search finds": ("confounding", "_close", lambda *_: []),
    "rivals of one driver differ by more than a form": (
        "confounding",
        "_near",
        lambda selection, _: {e.name: CLOSE for e in selection.weighed},
    ),
    "of alike sets the one that follows the drivers": ("answer", "_as_followed", lambda selection, fitted: fitted),
    "the map must be named where it is most": ("adequacy", "Adequacy._static_part_open", property(lambda self: False)),
    "a form must change in the record": ("selection", "stands", lambda *_: False),
    "names of one driver earn twice": ("search", "_lengths_own", lambda effect: (effect.name,)),
    "drivers in place of another": ("follows", "Following.possible", property(lambda self: self.likely)),
    "drivers beside others": ("follows", "Following.drivers", property(lambda self: self.likely)),
    "other forms in place of values against nature": ("confirmed", "_in_other_forms", lambda *_: []),
    "what is too small goes": ("confirmed", "_large_enough", lambda base, named, fitted, least: named),
    "doubtful names go beside something unknown": ("diagnose", "_without_doubtful", lambda outcome: outcome),
    "no other noise where sure": ("select", "_sure", lambda selection, fitted: False),
    "where much is unread, a name is less sure": ("outcome", "Outcome.unread", property(lambda self: False)),
    "another driver explains as much": ("probability", "_undecided", lambda *_: ""),
    "a held pressure is its mean": ("follows", "without_sensor", lambda record: record.inputs),
    "sets of drivers compete in their own noise": (
        "follows",
        "Following._own_noise",
        property(lambda self: None),
    ),
}
"""Where a rule lives in pam_ident.diagnosis, and what stands there without it."""
Case = tuple[Path, str]


@contextmanager
def replaced(name: str, by: Callable[[Any], Any]) -> Iterator[None]:
    """A rule replaced by what `by` makes of it."""
    module, path, _ = RULES[name]
    owner: Any = import_module(f"pam_ident.diagnosis.{module}")
    *outer, last = path.split(".")
    for one in outer:
        owner = getattr(owner, one)
    known = vars(owner)[last]
    setattr(owner, last, by(known))
    try:
        yield
    finally:
        setattr(owner, last, known)


def watched(name: str, reached: set[str], known: Any) -> Any:
    """A rule that tells when it makes a difference."""
    without = RULES[name][2]

    def ask(*args: Any) -> Any:
        found = call(known, *args)
        if name not in reached and differ(found, call(without, *args)):
            reached.add(name)
        return found

    return property(ask) if isinstance(known, property | cached_property) else ask


def call(rule: Any, *args: Any) -> Any:
    """What a rule, or a property of its one argument, gives."""
    if isinstance(rule, cached_property):
        return rule.func(*args)
    return rule.fget(*args) if isinstance(rule, property) else rule(*args)


def differ(one: Any, other: Any) -> bool:
    """Whether two answers of a rule are not the same; arrays are taken to differ."""
    try:
        return bool(one is not other and one != other)
    except ValueError:
        return True


def with_all(case: Case) -> tuple[Score, set[str]]:
    """How a case is answered, and the rules that made a difference on the way."""
    reached: set[str] = set()
    with ExitStack() as watch:
        for name in RULES:
            watch.enter_context(replaced(name, partial(watched, name, reached)))
        return scored(case), reached


def without(name: str, case: Case) -> Score:
    """How it is answered without a rule."""
    with replaced(name, lambda known: RULES[name][2]):
        return scored(case)


def scored(case: Case) -> Score:
    """How it is answered."""
    folder, name = case
    truth = {one["case"]: one for one in json.loads((folder / "truth.json").read_text())}
    return score(truth[name], answer_case(folder, name, questions(folder)[name]))


def summed(scores: list[Score]) -> str:
    """Right, exact, and statements of 0.9 or more that are false."""
    false = sum(p >= 0.9 and not true for one in scores for p, true in one.statements)
    return f"{sum(one.right for one in scores)}, {sum(one.exact for one in scores)}, {false}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--rule", action="append", choices=RULES)
    parser.add_argument("--most", type=int, default=60, help="records that a rule is left out of, spread evenly")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    cases = [(folder, name) for folder in asked.folders for name in questions(folder)]
    with ProcessPoolExecutor(asked.workers) as pool:
        found = list(pool.map(with_all, cases))
        print(f"all rules, {len(cases)} records: {summed([one for one, _ in found])} (right, exact, false)", flush=True)
        for rule in asked.rule or RULES:
            touched = [(case, one) for case, (one, reached) in zip(cases, found, strict=True) if rule in reached]
            reached, touched = len(touched), touched[:: max(1, -(-len(touched) // asked.most))]
            before = [one for _, one in touched]
            after = list(pool.map(partial(without, rule), [case for case, _ in touched]))
            print(f"| {rule} | {reached} | {len(touched)} | {summed(before)} | {summed(after)} |", flush=True)
            for (folder, name), one, other in zip((case for case, _ in touched), before, after, strict=True):
                if (one.right, one.exact) != (other.right, other.exact):
                    print(f"    {folder / name}: {' + '.join(one.named)} → {' + '.join(other.named)}", flush=True)


if __name__ == "__main__":
    main()
