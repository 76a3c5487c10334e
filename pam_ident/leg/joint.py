"""The knee as one degree of freedom: the leg swings from its hip, hip and ankle move as prescribed.

Lagrange's equation for the flexion φ. With places ρ in the thigh's frame, whose origin is the hip,

    Σ m (∂ρ/∂φ) · (a − g) + Σ I (∂ω/∂φ̇) ω̇ = T ds/dφ + Q,

over shank, foot, crank and rocker; T is the torque on the sprocket, Q damping, stops and load. The thigh moves as
prescribed and does no work on φ. The frame turns with the hip, so a holds what a turning frame adds.
"""

from .anatomy import Leg
from .four_bar import Array, Posture, as_array
from .gait import LegAngles, Swing

GRAVITY = 9.81
"""m/s²"""


def acceleration(leg: Leg, flexion: Array, rate: Array, sprocket_torque: Array, motion: LegAngles) -> Array:
    """φ̈ in rad/s² at flexion (rad), its rate (rad/s) and a torque on the sprocket (N·m, positive flexes).

    Any shape that broadcasts, NumPy or JAX. Of `motion` only hip and ankle are used.
    """
    posture = leg.knee.at(flexion)
    inertia, bias = _equation(leg, posture, flexion, rate, motion)
    return (sprocket_torque * posture.ratio + passive_torque(leg, flexion, rate) - bias) / inertia


def inverse(leg: Leg, flexion: Array, rate: Array, wanted: Array, motion: LegAngles) -> Array:
    """Torque on the sprocket in N·m under which the flexion's acceleration is `wanted` (rad/s²), all of one shape."""
    posture = leg.knee.at(flexion)
    inertia, bias = _equation(leg, posture, flexion, rate, motion)
    return (inertia * wanted + bias - passive_torque(leg, flexion, rate)) / posture.ratio


def passive_torque(leg: Leg, flexion: Array, rate: Array) -> Array:
    """Damping, stops and load torque on the flexion (rad, any shape), N·m, positive where they flex.

    A stop passed by y pushes back by stiffness · y²/(y + width): nothing and no stiffness where it sets in.
    """
    flexion = as_array(flexion)
    xp = flexion.__array_namespace__()
    low, high = leg.stops_rad
    below, above = xp.maximum(low - flexion, 0.0), xp.maximum(flexion - high, 0.0)
    push = below**2 / (below + leg.stop_width_rad) - above**2 / (above + leg.stop_width_rad)
    return leg.stop_stiffness_N_m * push - leg.damping_N_m_s * rate + leg.load_torque_N_m


def _equation(leg: Leg, posture: Posture, flexion: Array, rate: Array, motion: LegAngles) -> tuple[Array, Array]:
    """Generalised inertia in kg·m² and bias in N·m, so that inertia φ̈ + bias = T ds/dφ + Q."""
    hip, ankle = motion.hip, motion.ankle
    xp = as_array(flexion).__array_namespace__()
    knee = -1j * leg.thigh.length_m
    turned = xp.cos(flexion) - 1j * xp.sin(flexion)
    up = 1j * GRAVITY * (xp.cos(hip.angle) - 1j * xp.sin(hip.angle))

    shank = _carried(knee, posture, turned * leg.shank.centre_m)
    foot_arm = turned * (xp.cos(ankle.angle) + 1j * xp.sin(ankle.angle)) * leg.foot.centre_m
    foot = _carried(knee, posture, foot_arm - 1j * turned * leg.shank.length_m)
    dorsiflexing = (
        1j * ankle.rate * foot_arm,
        (1j * ankle.acceleration - ankle.rate**2 + 2 * ankle.rate * rate) * foot_arm,
    )
    crank, rocker = posture.crank, posture.rocker
    long, _, short, _ = leg.knee.lengths
    crank_inertia = leg.crank_mass_kg * long**2 / 12.0 + leg.sprocket_inertia_kg_m2
    rocker_turn = _turn(rocker, short**2)

    terms = (
        _moved(leg.shank.mass_kg, shank, rate, hip, up),
        _moved(leg.foot.mass_kg + leg.load_mass_kg, foot, rate, hip, up, dorsiflexing),
        _moved(leg.crank_mass_kg, _rod(knee + leg.knee.crank_thigh, crank), rate, hip, up),
        _moved(leg.rocker_mass_kg, _rod(knee + leg.knee.rocker_thigh, rocker), rate, hip, up),
        _rotated(leg.shank.inertia_kg_m2, (-1.0, 0.0), rate, hip.acceleration),
        _rotated(leg.foot.inertia_kg_m2, (-1.0, 0.0), rate, hip.acceleration + ankle.acceleration),
        _rotated(crank_inertia, (-posture.ratio, -posture.bend), rate, hip.acceleration),
        _rotated(leg.rocker_mass_kg * short**2 / 12.0, rocker_turn, rate, hip.acceleration),
    )
    return sum(inertia for inertia, _ in terms), sum(bias for _, bias in terms)


def _carried(knee: complex, posture: Posture, arm: Array) -> tuple[Array, Array, Array]:
    """Place, and its two derivatives by φ, of a point that the shank carries at `arm` from its origin."""
    place, first, second = posture.knee
    return knee + place + arm, first - 1j * arm, second - arm


def _rod(pivot: complex, link: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """The same of the middle of a link that turns about a pivot on the thigh."""
    return pivot + 0.5 * link[0], 0.5 * link[1], 0.5 * link[2]


def _turn(link: tuple[Array, Array, Array], square: float) -> tuple[Array, Array]:
    """First and second derivative by φ of a link's angle, counter-clockwise."""
    back = link[0].conjugate()
    return (back * link[1]).imag / square, (back * link[2]).imag / square


def _moved(
    mass: float,
    place: tuple[Array, Array, Array],
    rate: Array,
    hip: Swing,
    up: Array,
    own: tuple[Array, Array] = (0.0, 0.0),
) -> tuple[Array, Array]:
    """Inertia and bias of a mass; `own` is its velocity and acceleration in the thigh's frame while φ rests."""
    where, first, second = place
    velocity = first * rate + own[0]
    felt = second * rate**2 + own[1] + 2j * hip.rate * velocity + (1j * hip.acceleration - hip.rate**2) * where + up
    back = first.conjugate()
    return mass * (back * first).real, mass * (back * felt).real


def _rotated(inertia: float, turn: tuple[Array, Array], rate: Array, frame: Array) -> tuple[Array, Array]:
    """Inertia and bias of a body whose angle has derivatives `turn` by φ and otherwise accelerates by `frame`."""
    return inertia * turn[0] ** 2, inertia * turn[0] * (turn[1] * rate**2 + frame)
