"""The bladder's rubber relaxes after each change of length."""

from dataclasses import replace

import numpy as np

from ..core import Inputs, Param
from ._history import relax, relax_from_none, since_first
from .base import AddsForce, Array, Effect, Values, free_form, one, with_pressure
from .bladder_elasticity import hoop_force
from .force_drift import elapsed

G = Param("G", "N", "relaxing force per contraction", 0.0, 1e5, scale=100.0)
G_P = Param("G_p", "N/MPa", "growth of that force with pressure", 0.0, 1e6, scale=300.0)
TAU = Param(
    "tau", "s", "relaxation time", 0.2, 3000.0, start=10.0, grid=(0.3, 1.0, 3.0, 10.0, 30.0, 100.0), slowest=1.0
)
"""What relaxes faster than 0.2 s is damping: −G q is −G τ ε̇ then."""
SLOW = replace(TAU, lower=0.5, grid=TAU.grid[1:])
"""What lags less and grows with pressure is the gas."""
MIDDLE = Param(
    "tau", "s", "middle relaxation time", 2.0, 3000.0, start=10.0, grid=(3.0, 10.0, 30.0, 100.0), slowest=10.0
)
LATE_TAU = replace(MIDDLE, doc="relaxation time", slowest=1.0)
THREE = tuple(
    Param(f"G_{k}", "N", f"relaxing force per contraction, {word} term", 0.0, 1e5, scale=100.0)
    for k, word in enumerate(("fastest", "middle", "slowest"), 1)
)
E_R = Param("E_r", "MPa", "relaxing part of the bladder's modulus", 0.0, 1e3, scale=0.1)
SHARE = Param("share", "1", "share of a change of force that relaxes", 0.0, 2.0, scale=0.02)
LATE = Param("late", "1", "share of a change of force that comes late", 0.0, 1.0, scale=0.02)
NEW = Param("new", "1", "share of the first contraction, or force, that is new", 0.0, 1.0, start=0.5, grid=(0.0, 1.0))
RATIOS = (0.1, 1.0, 10.0)
"""Relaxation times of three elements, over the middle one's."""
DECADES = np.logspace(-1.0, 3.0, 9)


def _drive(inputs: Inputs, drive: Array, tau: float) -> Array:
    return -relax(inputs, drive, tau)


def _three(inputs: Inputs, drive: Array, tau: float) -> Array:
    return inputs.xp.stack([_drive(inputs, drive, tau * ratio) for ratio in RATIOS]).T


def _single(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(_drive(inputs, inputs.way, values["tau"]))


def _pressed(inputs: Inputs, values: Values, force: Array) -> Array:
    """The gas presses more of the rubber between the threads."""
    return with_pressure(_single(inputs, values, force), inputs)


def _prony(inputs: Inputs, values: Values, force: Array) -> Array:
    return _three(inputs, inputs.way, values["tau"])


def _begun(inputs: Inputs, values: Values, force: Array) -> Array:
    """And of the contraction that the first sample finds: nobody knows how long it was there."""
    return _prony(inputs, values, force) - values["new"] * _late(inputs, inputs.way, values["tau"])


def _late(inputs: Inputs, drive: Array, tau: float) -> Array:
    since, first = elapsed(inputs), drive - since_first(inputs, drive)
    return inputs.xp.stack([first * inputs.xp.exp(-since / (tau * ratio)) for ratio in RATIOS]).T


def _pressurised(inputs: Inputs, values: Values, force: Array) -> Array:
    """The pressure strains the rubber, too: from none when an isobar begins, or from what it was on the one before."""
    taus = (values["tau"] * ratio for ratio in RATIOS)
    return -inputs.xp.stack([relax_from_none(inputs, inputs.pressure, tau, values["new"]) for tau in taus]).T


def _logarithmic(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(inputs.xp.stack([_drive(inputs, inputs.way, tau) for tau in DECADES]).sum(axis=0) / len(DECADES))


def _force(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-_drive(inputs, force, values["tau"]))


def _force_prony(inputs: Inputs, values: Values, force: Array) -> Array:
    """And of the force that the first sample finds: nobody knows how long it was there."""
    return values["new"] * _late(inputs, force, values["tau"]) - _three(inputs, force, values["tau"])


def _following(inputs: Inputs, values: Values, force: Array) -> Array:
    """The muscle creeps on the way it was pulled or pressed."""
    return -_force(inputs, values, force)


def _elastic(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(-_drive(inputs, hoop_force(inputs), values["tau"]))


EFFECT = Effect(
    name="creep",
    title="creep and stress relaxation",
    source="standard linear solid, Prony series; Vo-Minh, Kamers, Ramon & Van Brussel 2012, Mechatronics 22, 923–933",
    forms=(
        AddsForce("textbook", "−G q, q̇ = ε̇ − q/τ", (G,), _single, (TAU,), remembers=True),
        AddsForce("logarithmic", "−G Σ q_i/9, τ_i from 0.1 to 1000 s", (G,), _logarithmic, remembers=True),
        AddsForce("pressed", "as textbook, with G + G_p p for G", (G, G_P), _pressed, (SLOW,), remembers=True),
        AddsForce("prony_3", "−Σ G_i q_i, τ_i = τ/10, τ, 10 τ", THREE, _prony, (MIDDLE,), remembers=True),
        AddsForce("elastic", "+E_r q, q̇ = ḟ − q/τ, E f the bladder's force", (E_R,), _elastic, (TAU,), remembers=True),
        AddsForce("force_driven", "+share · q, q̇ = Ḟ − q/τ", (SHARE,), _force, (TAU,), uses_force=True, remembers=True),
        AddsForce(
            "following", "−late · q, q̇ = Ḟ − q/τ", (LATE,), _following, (LATE_TAU,), uses_force=True, remembers=True
        ),
        free_form(
            "−q_i, τ_i = τ/10, τ, 10 τ",
            _prony,
            3,
            contraction=1,
            nonlinear=(MIDDLE,),
            unit=("N", 100.0),
            remembers=True,
        ),
        free_form(
            "−q_i, q_i(0) = new · ε(0), τ_i = τ/10, τ, 10 τ",
            _begun,
            3,
            contraction=1,
            nonlinear=(MIDDLE, NEW),
            unit=("N", 100.0),
            remembers=True,
            name="free_begun",
        ),
        free_form(
            "−q_i, q̇_i = ṗ − q_i/τ_i, each isobar from (1 − new) · the one before, τ_i = τ/10, τ, 10 τ",
            _pressurised,
            3,
            pressure=0,
            contraction=1,
            nonlinear=(MIDDLE, NEW),
            unit=("N/MPa", 100.0),
            remembers=True,
            name="free_pressurised",
        ),
        free_form(
            "+q_i, q̇_i = Ḟ − q_i/τ_i, q_i(0) = new · F(0), τ_i = τ/10, τ, 10 τ",
            _force_prony,
            3,
            pressure=0,
            contraction=0,
            nonlinear=(MIDDLE, NEW),
            unit=("1", 0.02),
            remembers=True,
            name="free_tension",
            uses_force=True,
        ),
    ),
    follows=("rest",),
    test="holds over three decades of time",
    needs=("motion", "time"),
    levers=("hold", "speed"),
)
