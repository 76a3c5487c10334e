"""Does this installation compute what it should? Certified problems, a record of known parameters, a hidden effect."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..core.progress import steps
from ..diagnosis import diagnose
from ..fitting import VariableProjection, covariance, fit
from ..model import Model
from ..records import Record, read_record
from ..rig import Plan, demo_plans, make_record, write_case
from .certified import PROBLEMS, Certified

DIGITS, DIGITS_STDERR = 6.0, 4.0
"""Digits that parameters and their standard errors must share with the certified ones."""
FURTHEST = 4.0
"""Standard errors that a recovered parameter may lie from the truth: by chance one of seven does once in 2000 seeds."""


@dataclass(frozen=True)
class Digits:
    """Digits reached on one certified problem from one of its starts."""

    name: str
    start: int
    digits: float
    digits_stderr: float

    @property
    def passed(self) -> bool:
        """Enough digits in both."""
        return self.digits >= DIGITS and self.digits_stderr >= DIGITS_STDERR


@dataclass(frozen=True)
class Recovery:
    """Simulated records: parameters of one with nothing hidden, and what a diagnosis names in its twin.

    `furthest` is the largest distance of a parameter from its true value in standard errors; `named` and `hidden`
    are effects.
    """

    furthest: float
    clean_verdict: str
    hidden: str
    named: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Parameters within their errors, nothing named where nothing is hidden, what is hidden named alone."""
        right = self.clean_verdict == "adequate" and self.named == (self.hidden,)
        return right and self.furthest <= FURTHEST


@dataclass(frozen=True)
class SelfTest:
    """What was tried and whether all of it came out."""

    problems: tuple[Digits, ...]
    recovery: Recovery

    @property
    def passed(self) -> bool:
        """Every part passed."""
        return self.recovery.passed and all(score.passed for score in self.problems)


def selftest() -> SelfTest:
    """Run all of it; some seconds."""
    asked = [(one, start) for one in PROBLEMS for start in (1, 2)]
    return SelfTest(tuple(_score(*one) for one in steps(asked, "certified problems")), _recover())


def _score(one: Certified, start: int) -> Digits:
    problem = one.problem(start)
    values = VariableProjection().solve(problem).values
    variance = np.diag(covariance(problem.jacobian(values), problem.residual(values)).matrix)
    errors = dict(zip([p.name for p in problem.params], np.sqrt(variance), strict=True))
    return Digits(one.name, start, one.digits(values), one.digits_stderr(errors))


def _recover() -> Recovery:
    friction, twin = demo_plans()
    law = make_record(twin).muscle.law
    model = Model.build(law.name)
    clean, rubbing = _record(twin), _record(friction)
    furthest = max(abs(e.value - getattr(law, e.name)) / e.stderr for e in fit(model, clean).estimates)
    named = tuple(diagnose(model, rubbing).selected)
    return Recovery(furthest, diagnose(model, clean).verdict, friction.secrets[0].name, named)


def _record(plan: Plan) -> Record:
    with TemporaryDirectory() as folder:
        write_case(folder, make_record(plan))
        return read_record(str(Path(folder) / "record.csv"))
