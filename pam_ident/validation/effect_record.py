"""A clean record that moves everything a test rig can move, to hold an effect's formulas against."""

import numpy as np

from ..core import Specimen
from ..records import Record, build_record

MUSCLE = Specimen("clean", 200.0, 10.0, 25.4, 1.5)


def clean_record(per_move: int = 20, per_hold: int = 6) -> Record:
    """Three isobars, three speeds, two cycles of each, holds, minor loops, a temperature that climbs and falls.

    Minor loops speed up and brake all the way, the others go at one speed. The force is zero. `per_move` and
    `per_hold` are samples of each stroke and each hold.
    """
    rows, clock = [], 0.0
    for pressure in (0.2, 0.5, 0.35):
        clock += 15.0
        cycle = 0
        for speed in (2.0, 10.0, 40.0):
            for low, high in ((0.0, 46.0), (20.0, 34.0)):
                cycle += 1
                for begin, end in ((low, high), (high, low)):
                    took = abs(end - begin) / speed
                    share = np.arange(1, per_move + 1) / per_move
                    way = share if low == 0.0 else share**2 * (3.0 - 2.0 * share)
                    rows += [
                        (clock + took * s, pressure, begin + (end - begin) * x, cycle)
                        for s, x in zip(share, way, strict=True)
                    ]
                    clock += took
                    rest = 3.0 * np.arange(1, per_hold + 1) / per_hold
                    rows += [(clock + r, pressure, end, cycle) for r in rest]
                    clock += 3.0
    time, pressure, x, cycle = np.array(rows).T
    return build_record(
        MUSCLE.name,
        MUSCLE,
        pressure,
        x / MUSCLE.initial_length_mm,
        np.zeros(len(time)),
        time=time,
        cycle=cycle,
        temperature=22.0 + 6.0 * np.sin(time / time[-1] * 5.0),
    )
