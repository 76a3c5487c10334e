"""A virtual rig that writes records with sealed hidden physics, to examine a diagnosis.

It shares nothing with the program it examines: its laws, effects and fits are written out here a second time,
on a finer time grid and in more forms.
"""

from .challenge import make_challenge
from .drives import PROTOCOLS
from .protocol import Protocol
from .record import Plan, RigRecord, Secret, demo_plans, make_record, write_case

__all__ = [
    "PROTOCOLS",
    "Plan",
    "Protocol",
    "RigRecord",
    "Secret",
    "demo_plans",
    "make_challenge",
    "make_record",
    "write_case",
]
