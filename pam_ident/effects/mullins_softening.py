"""The rubber is stiffer in its first cycles."""

from dataclasses import replace

from ..core import Inputs, Param
from ._history import cycles_of_test, greatest_so_far, way_travelled
from .base import AddsForce, Array, Effect, ScalesForce, Values, free_form, one
from .bladder_elasticity import hoop_force

EXTRA = Param("s", "1", "extra force in the first cycle, as a share", 0.0, 1.0, scale=0.02)
S_EXTRA = Param("s_e", "1", "growth of that share with contraction", -20.0, 20.0, scale=0.1)
S_LATER = Param("s_later", "1", "the same on the isobars after the first", -1.0, 1.0, scale=0.02)
P_EXTRA = Param("P_extra", "N/MPa", "extra force per pressure in the first cycle", 0.0, 2e4, scale=100.0)
F_LATER = Param("F_later", "N", "extra force on the isobars after the first", -2000.0, 2000.0, scale=10.0)
G_LATER = Param("G_later", "N", "extra force per contraction on the isobars after the first", -1e5, 1e5, scale=100.0)
E_EXTRA = Param("E_extra", "MPa", "extra modulus of the bladder in the first cycle", 0.0, 200.0, scale=1.0)
F_EXTRA = Param("F_extra", "N", "extra force in the first cycle", -2000.0, 2000.0, scale=10.0)
G_EXTRA = Param("G_extra", "N", "extra force per contraction in the first cycle", -1e5, 1e5, scale=100.0)
# Never below zero: a force at the reversals passed for rubber that stiffens below its greatest stretch.
E_LOST = Param("E_lost", "MPa", "modulus that the bladder loses below its greatest stretch", 0.0, 200.0, scale=1.0)
M = Param("m", "1", "way below the greatest energy at which it is lost", 0.003, 3.0, start=0.1, grid=(0.02, 0.1))
EXPONENT = Param("q", "1", "exponent of the number of the cycle", 0.2, 4.0, start=1.0, grid=(0.6, 1.5))
WAY = Param("s_0", "mm", "way over which the softening fades", 5.0, 1e4, start=150.0, grid=(60.0, 150.0, 400.0))
SLOWING = Param("q", "1", "how little the fading slows down", 0.3, 20.0, start=5.0, grid=(0.7, 5.0))
N0 = Param("n_0", "1", "cycles over which the softening fades", 0.2, 20.0, start=1.5, grid=(0.7, 1.5, 4.0))


def _fading(inputs: Inputs, values: Values) -> Array:
    assert inputs.cycle is not None
    return inputs.xp.exp(-(inputs.cycle - 1.0) / values["n_0"])


def _straight(inputs: Inputs, fading: Array) -> Array:
    """What fades, (n,), as a force and as a force per contraction, shape (n, 2)."""
    return inputs.xp.stack([fading, -fading * inputs.contraction]).T


def _whole(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(_fading(inputs, values))


def _shaped(inputs: Inputs, values: Values, force: Array) -> Array:
    fading = _fading(inputs, values)
    return inputs.xp.stack([fading, fading * inputs.contraction]).T


def _recovering(inputs: Inputs, values: Values, force: Array) -> Array:
    """Between isobars the rubber rests, and recovers in part."""
    assert inputs.segment is not None
    fading, first = _fading(inputs, values), inputs.segment == inputs.segment[0]
    return inputs.xp.stack([fading * first, fading * ~first]).T


def _elastic(inputs: Inputs, values: Values, force: Array) -> Array:
    return one(_fading(inputs, values) * hoop_force(inputs))


def _whole_test(inputs: Inputs, values: Values, force: Array) -> Array:
    """Cycles counted from the start of the test, not of the isobar."""
    return _straight(inputs, inputs.xp.exp(-(cycles_of_test(inputs) - 1.0) / values["n_0"]))


def _slowing(after: Array, values: Values) -> Array:
    """Fading after so many times what it takes: from a power law to an exponential (infinite q), one column."""
    return one((1.0 + after / values["q"]) ** -values["q"])


def _any(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.cycle is not None
    return _slowing((inputs.cycle - 1.0) / values["n_0"], values)


def _any_of_test(inputs: Inputs, values: Values, force: Array) -> Array:
    return _slowing((cycles_of_test(inputs) - 1.0) / values["n_0"], values)


def _any_by_way(inputs: Inputs, values: Values, force: Array) -> Array:
    return _slowing(way_travelled(inputs) / values["s_0"], values)


def _any_by_all_way(inputs: Inputs, values: Values, force: Array) -> Array:
    return _slowing(way_travelled(inputs, of_test=True) / values["s_0"], values)


def _linear(inputs: Inputs, values: Values, force: Array) -> Array:
    return _straight(inputs, _fading(inputs, values))


def _pressed(inputs: Inputs, values: Values, force: Array) -> Array:
    fading = _fading(inputs, values)
    return inputs.xp.stack([fading, fading * inputs.pressure]).T


def _rested(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.segment is not None
    fading, first = _fading(inputs, values), inputs.segment == inputs.segment[0]
    return inputs.xp.hstack([_straight(inputs, fading * first), _straight(inputs, fading * ~first)])


def _power(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.cycle is not None
    return _straight(inputs, inputs.cycle ** -values["q"])


def _logarithmic(inputs: Inputs, values: Values, force: Array) -> Array:
    assert inputs.cycle is not None
    return _straight(inputs, -inputs.xp.log(inputs.cycle))


def _travelled(inputs: Inputs, values: Values, force: Array) -> Array:
    """What is gone, not what is counted, softens; between isobars the rubber rests."""
    return _straight(inputs, inputs.xp.exp(-way_travelled(inputs) / values["s_0"]))


def _travelled_on(inputs: Inputs, values: Values, force: Array) -> Array:
    return _straight(inputs, inputs.xp.exp(-way_travelled(inputs, of_test=True) / values["s_0"]))


def _pseudo_elastic(inputs: Inputs, values: Values, force: Array) -> Array:
    """The energy W = (r/r0 − 1)² is that of the hoop, over E/2."""
    energy = (inputs.specimen.radius_ratio(inputs.contraction) - 1.0) ** 2
    below = greatest_so_far(inputs, energy) - energy
    return one(-hoop_force(inputs) * inputs.xp.tanh(below / values["m"]))


EFFECT = Effect(
    name="mullins_softening",
    title="Mullins softening",
    source="Mullins 1969, Rubber Chemistry and Technology 42, 339–362; Dorfmann & Ogden 2003, Int. J. Solids and "
    "Structures 40, 2699–2714 (below the greatest stretch so far)",
    forms=(
        ScalesForce("textbook", "F (1 + s exp(−(n−1)/n_0))", (EXTRA,), _whole, (N0,)),
        ScalesForce("shaped", "F (1 + (s + s_e ε) exp(−(n−1)/n_0))", (EXTRA, S_EXTRA), _shaped, (N0,)),
        ScalesForce(
            "recovering",
            "F (1 + s exp(−(n−1)/n_0)), s_later after the first isobar",
            (EXTRA, S_LATER),
            _recovering,
            (N0,),
        ),
        AddsForce("elastic", "E → E + E_extra exp(−(n−1)/n_0) in the bladder's force", (E_EXTRA,), _elastic, (N0,)),
        AddsForce("linear", "+(F_extra − G_extra ε) exp(−(n−1)/n_0)", (F_EXTRA, G_EXTRA), _linear, (N0,)),
        AddsForce(
            "pressed", "+(F_extra + P_extra p) exp(−(n−1)/n_0)", (replace(F_EXTRA, lower=0.0), P_EXTRA), _pressed, (N0,)
        ),
        AddsForce(
            "rested",
            "as linear, with F_later and G_later after the first isobar",
            (F_EXTRA, G_EXTRA, F_LATER, G_LATER),
            _rested,
            (N0,),
        ),
        AddsForce("power", "+(F_extra − G_extra ε) n^(−q)", (F_EXTRA, G_EXTRA), _power, (EXPONENT,)),
        AddsForce("logarithmic", "−(F_extra − G_extra ε) ln n", (F_EXTRA, G_EXTRA), _logarithmic),
        AddsForce(
            "whole_test",
            "as linear, over all cycles of the test",
            (F_EXTRA, G_EXTRA),
            _whole_test,
            (N0,),
            remembers=True,
        ),
        AddsForce(
            "travelled",
            "+(F_extra − G_extra ε) exp(−s/s_0), s the way gone",
            (F_EXTRA, G_EXTRA),
            _travelled,
            (WAY,),
            remembers=True,
        ),
        AddsForce(
            "travelled_on",
            "as travelled, over the way of the test",
            (F_EXTRA, G_EXTRA),
            _travelled_on,
            (WAY,),
            remembers=True,
        ),
        AddsForce(
            "pseudo_elastic",
            "E → E − E_lost tanh((W_max − W)/m) in the bladder's force, W_max the greatest W so far",
            (E_LOST,),
            _pseudo_elastic,
            (M,),
            remembers=True,
        ),
        free_form("(1 + (n−1)/(q n_0))^−q", _any, nonlinear=(N0, SLOWING)),
        free_form(
            "(1 + (n−1)/(q n_0))^−q, n of the whole test",
            _any_of_test,
            nonlinear=(N0, SLOWING),
            remembers=True,
            name="free_whole_test",
        ),
        free_form("(1 + s/(q s_0))^−q", _any_by_way, nonlinear=(WAY, SLOWING), remembers=True, name="free_travelled"),
        free_form(
            "as free_travelled, s of the whole test",
            _any_by_all_way,
            nonlinear=(WAY, SLOWING),
            remembers=True,
            name="free_travelled_on",
        ),
    ),
    follows=("cycle",),
    test="at least three cycles, and a re-run of the first after rest",
    needs=("cycle", "time"),
    levers=("cycles",),
)
