"""A second of closed loop, and ten thousand sets of gains, beside plain Python in one run.

    python benchmarks/closed_loop.py [--times 5] [--sets 10000]

The plant is the leg at 1 Hz with two muscles of an exponential law with linear damping, under a plain PID. The peer is
`tests/leg/plain_loop.py`, the same plant in plain floats, which is the fastest that a slope gets without a compiler.

First a second of the loop: ours, Runge–Kutta at 0.5 ms compiled by JAX, beside scipy's `solve_ivp(method="RK45")` with
rtol = atol = 1e-8, 1e-7 and 1e-6, stopped at every sample of the controller. What they are off is measured against
DOP853 at 1e-10; the ratio is to the fastest. Then sets of gains: ours as one batch, beside a Python loop over the same
steps of Runge and Kutta, timed on a few of the sets. Minima of several processor times, taken in turn, without
compilation, which is shown apart. Exits with 1 where a ratio misses 50, ours is more than 2e-6 rad off, or both sweeps
differ.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")  # before numpy is imported

import numpy as np
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "leg"))
from plain_loop import PlainGait, PlainPid, closed_loop, runge_kutta, smooth_example

from pam_ident.leg.arrays import jax
from pam_ident.leg.control import Gains, Sensor
from pam_ident.leg.course import Course
from pam_ident.leg.gait import winter
from pam_ident.leg.loop import Loop, Scale

GAINS = Gains(2.0, 1.0, 0.1)
SAMPLES, SETS_OF_PYTHON, GOAL = 200, 3, 50.0
TOLERANCES = (1e-8, 1e-7, 1e-6)
FAR_RAD = 2e-6
"""As far as ours may be off: 0.0001°."""
TYPICAL = np.array([1.0, 1.0, 1e5, 1e5, 1e-4, 1e-4, 1.0, 1.0])


def stepped(method: str, rtol: float, atol: object) -> Callable[..., list[float]]:
    def advance(slope, begin, end, state):
        return solve_ivp(slope, (begin, end), state, method=method, rtol=rtol, atol=atol).y[:, -1].tolist()

    return advance


def timed(work: Callable[[], object]) -> tuple[float, object]:
    """Processor time of all threads in s, so that what else runs on the machine counts little, and what came out."""
    begin = time.process_time()
    found = work()
    return time.process_time() - begin, found


def minima(times: int, **works: Callable[[], object]) -> tuple[dict[str, float], dict[str, object]]:
    """Least times in s, and what came out, of works done in turn, short ones ten times a turn."""
    least, found = {name: timed(work)[0] for name, work in works.items()}, {}
    for _ in range(times):
        for name, work in works.items():
            for _ in range(1 if least[name] > 0.05 else 10):
                took, found[name] = timed(work)
                least[name] = min(least[name], took)
    return least, found


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--times", type=int, default=5)
    parser.add_argument("--sets", type=int, default=10_000)
    asked = parser.parse_args()

    pair, plain = smooth_example()
    course = Course(winter(1.0))
    loop, gait, values = Loop(pair, Sensor(bits=40)), PlainGait(course.gait), pair.muscle.values()
    task = jax.tree.map(lambda a: a[:SAMPLES], course.task(np.full(2, pair.mean_MPa)))

    def one() -> np.ndarray:
        return np.asarray(loop.run(values, GAINS, Scale(), task).flexion)

    def python(advance: Callable[..., list[float]], gains: Gains = GAINS) -> np.ndarray:
        return np.array(closed_loop(plain, gait, PlainPid(*gains), SAMPLES, advance))[:, 0]

    exact = python(stepped("DOP853", 1e-10, 1e-10 * TYPICAL))
    first, _ = timed(one)
    peers = {f"{atol:g}": stepped("RK45", atol, atol) for atol in TOLERANCES}
    works = {name: (lambda advance=advance: python(advance)) for name, advance in peers.items()}
    least, found = minima(asked.times, ours=one, **works)
    off = {name: float(np.max(np.abs(path - exact))) for name, path in found.items()}
    second = min(least[name] for name in peers) / least["ours"]
    print(f"| one second of closed loop ({SAMPLES} samples) | time | off DOP853 at 1e-10 |\n|---|---:|---:|")
    for name in peers:
        row = f"scipy RK45, rtol = atol = {name}, plain floats"
        print(f"| {row} | {1e3 * least[name]:.0f} ms | {off[name]:.1e} rad |")
    print(f"| pam-ident, RK4 of 0.5 ms | {1e3 * least['ours']:.2f} ms | {off['ours']:.1e} rad |")
    print(f"| ratio to the fastest | {second:.0f} | |\n\nfirst call, with compilation: {first:.1f} s\n")

    rng = np.random.default_rng(1)
    sets = Gains(*(g * np.exp(rng.uniform(-0.7, 0.7, asked.sets)) for g in GAINS))
    scales = Scale(*np.ones((3, asked.sets)))
    many = task._replace(ahead=np.broadcast_to(np.asarray(task.ahead), (asked.sets, *task.ahead.shape)))

    def batch() -> np.ndarray:
        return loop.batch(sets, scales, many).flexion

    def few() -> np.ndarray:
        return np.array([python(runge_kutta, Gains(*(g[k] for g in sets))) for k in range(SETS_OF_PYTHON)])

    first, _ = timed(batch)
    least, found = minima(min(asked.times, 3), ours=batch, python=few)
    each = {"ours": least["ours"] / asked.sets, "python": least["python"] / SETS_OF_PYTHON}
    apart = float(np.max(np.abs(found["ours"][:SETS_OF_PYTHON] - found["python"])))
    sweep = each["python"] / each["ours"]
    print(f"| {asked.sets} sets of gains, one second each | whole | a set |\n|---|---:|---:|")
    print(
        f"| Python loop over the same RK4, plain floats, scaled from {SETS_OF_PYTHON} | "
        f"{each['python'] * asked.sets:.0f} s | {1e3 * each['python']:.1f} ms |"
    )
    print(f"| pam-ident, one batch | {least['ours']:.1f} s | {1e3 * each['ours']:.2f} ms |")
    print(f"| ratio | {sweep:.0f} | |\n\nfirst call: {first:.1f} s; the sets agree to {apart:.0e} rad")
    return int(min(second, sweep) < GOAL or off["ours"] > FAR_RAD or apart > 1e-9)


if __name__ == "__main__":
    sys.exit(main())
