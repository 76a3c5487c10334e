"""The leg as its file of numbers makes it. SI units, angles in rad.

Planar places are complex numbers in the frame of their segment, x forward and y up while the leg is straight.
"""

from dataclasses import dataclass

import numpy as np

from .four_bar import Array, FourBar
from .leg_file import DEFAULT, Tables


@dataclass(frozen=True)
class Segment:
    """A rigid body: length along −y, mass, mass centre in its own frame (complex), inertia about that centre."""

    length_m: float
    mass_kg: float
    centre_m: complex
    inertia_kg_m2: float


def winter_segments(height_m: float, mass_kg: float) -> tuple[Segment, Segment, Segment]:
    """Thigh, shank and foot of a body of that height and mass.

    Lengths, shares of mass, mass centres and radii of gyration after D. A. Winter, Biomechanics and Motor Control of
    Human Movement, 4th edition, Figure 4.1 and Table 4.1. The foot's segment runs from ankle to the ball; that the
    ball lies 0.47 of the foot's length ahead of the ankle and 0.8 of its height below is assumed.
    """
    thigh, shank = 0.245 * height_m, 0.246 * height_m
    ball = 0.47 * 0.152 * height_m - 0.8j * 0.039 * height_m
    return (
        Segment(thigh, 0.100 * mass_kg, -0.433j * thigh, 0.100 * mass_kg * (0.323 * thigh) ** 2),
        Segment(shank, 0.0465 * mass_kg, -0.433j * shank, 0.0465 * mass_kg * (0.302 * shank) ** 2),
        Segment(0.039 * height_m, 0.0145 * mass_kg, 0.5 * ball, 0.0145 * mass_kg * (0.475 * abs(ball)) ** 2),
    )


@dataclass(frozen=True)
class Servo:
    """A DC motor behind a harmonic gear, holding its joint to a target: the prototype's hip and ankle."""

    gear_ratio: float
    rotor_inertia_kg_m2: float
    stiffness_N_m: float
    damping_N_m_s: float
    torque_limit_N_m: float

    @property
    def reflected_kg_m2(self) -> float:
        """Inertia of the rotor as the joint feels it."""
        return self.rotor_inertia_kg_m2 * self.gear_ratio**2


@dataclass(frozen=True)
class Leg:
    """The leg on its stand. Everything may be replaced with `dataclasses.replace`.

    The sprocket, of `sprocket_radius_m`, is fixed to the crank; a muscle of rest length L0 has the contraction
    `rest_contraction` ± R s / L0, plus for the flexor (index 0), minus for the extensor (1). Links are uniform rods.
    The stops are stiff springs beyond `stops_rad`, which set in over `stop_width_rad`. `load_mass_kg` sits at the
    foot's mass centre; `load_torque_N_m` acts on the flexion, positive where it flexes.
    """

    thigh: Segment
    shank: Segment
    foot: Segment
    knee: FourBar
    sprocket_radius_m: float
    rest_contraction: tuple[float, float]
    crank_mass_kg: float
    rocker_mass_kg: float
    sprocket_inertia_kg_m2: float
    damping_N_m_s: float
    stops_rad: tuple[float, float]
    stop_stiffness_N_m: float
    load_mass_kg: float
    load_torque_N_m: float
    hip_servo: Servo
    ankle_servo: Servo
    stop_width_rad: float = float(np.radians(0.1))

    def contraction(self, sprocket_rad: Array, length_m: float) -> tuple[Array, Array]:
        """Contraction ratios of flexor and extensor of that rest length at a sprocket's angle of any shape."""
        turned = self.sprocket_radius_m * sprocket_rad / length_m
        return self.rest_contraction[0] + turned, self.rest_contraction[1] - turned


PIVOTS = ("crank_thigh", "rocker_thigh", "crank_shank", "rocker_shank")


def leg_of(tables: Tables) -> Leg:
    """The leg of a file. Raises UsageError where its linkage does not close."""
    knee, sprocket, load = (tables[name] for name in ("knee", "sprocket", "load"))
    pivots = (complex(*knee[f"{name}_m"]) for name in PIVOTS)
    flexor, extensor = tables["muscles"]["rest_contraction"]
    low, high = np.radians(knee["stops_deg"])
    return Leg(
        *winter_segments(**tables["body"]),
        knee=FourBar(**dict(zip(PIVOTS, pivots, strict=True))),
        sprocket_radius_m=sprocket["radius_m"],
        rest_contraction=(flexor, extensor),
        crank_mass_kg=knee["crank_mass_kg"],
        rocker_mass_kg=knee["rocker_mass_kg"],
        sprocket_inertia_kg_m2=sprocket["inertia_kg_m2"],
        damping_N_m_s=knee["damping_N_m_s"],
        stops_rad=(float(low), float(high)),
        stop_stiffness_N_m=knee["stop_stiffness_N_m"],
        load_mass_kg=load["mass_kg"],
        load_torque_N_m=load["torque_N_m"],
        hip_servo=Servo(**tables["hip_servo"]),
        ankle_servo=Servo(**tables["ankle_servo"]),
    )


LEG = leg_of(DEFAULT)
"""The leg of the examples."""
KNEE = LEG.knee
