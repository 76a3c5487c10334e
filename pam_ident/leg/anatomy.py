"""Every dimension of the leg, in one place, each with its source or called assumed. SI units, angles in rad.

Planar places are complex numbers in the frame of their segment, x forward and y up while the leg is straight.
"""

from dataclasses import dataclass

import numpy as np

from .four_bar import Array, FourBar

HEIGHT_M, MASS_KG = 1.75, 70.0
"""Of the whole body; assumed."""

KNEE = FourBar(
    crank_thigh=0.0038 - 0.0072j,
    rocker_thigh=-0.0081 + 0.0021j,
    crank_shank=-0.0192 - 0.0374j,
    rocker_shank=0.0080 - 0.0244j,
)
"""The crossed four-bar of the cruciate ligaments; the crank stands for the posterior one, the rocker for the anterior.

Published: the length of the rocker, 31 mm (31 ± 3 mm in 33 knees, isometric; Odensten & Gillquist 1985, J. Bone Joint
Surg. Am. 67, 257–262), and of the crank, 38 mm (Girgis, Marshall & Al Monajem 1975, Clin. Orthop. 106, 216–231; quoted
after others, not checked against the print). That crossed links guide the human knee: Menschik 1974, Z. Orthop. 112,
481–495; O'Connor et al. 1989, Proc. Inst. Mech. Eng. H 203, 223–233.

Assumed: where the four pivots lie. They are our fit, from attachments guessed near the ligaments', to the published
path of the tibia against the femur over 0–75° (Yamaguchi & Zajac 1989, J. Biomech. 22, 1–10, as tabulated in the model
gait2392 of Delp et al. 1990), which the rounded pivots follow to 0.9 mm rms. It is no prosthesis that can be bought.
"""


@dataclass(frozen=True)
class Segment:
    """A rigid body: length along −y, mass, mass centre in its own frame (complex), inertia about that centre."""

    length_m: float
    mass_kg: float
    centre_m: complex
    inertia_kg_m2: float


def winter_segments(height_m: float = HEIGHT_M, mass_kg: float = MASS_KG) -> tuple[Segment, Segment, Segment]:
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
    The stops are stiff springs beyond `stops_rad`, which set in over `stop_width_rad`; Winter's stride reaches −3°, so
    the lower one lies at −5°. `load_mass_kg` sits at the foot's mass centre; `load_torque_N_m` acts on the flexion,
    positive where it flexes. All of it is assumed but the segments.
    """

    thigh: Segment
    shank: Segment
    foot: Segment
    knee: FourBar = KNEE
    sprocket_radius_m: float = 0.042
    rest_contraction: tuple[float, float] = (0.028, 0.2155)
    crank_mass_kg: float = 0.10
    rocker_mass_kg: float = 0.08
    sprocket_inertia_kg_m2: float = 4.0e-4
    damping_N_m_s: float = 0.5
    stops_rad: tuple[float, float] = (float(np.radians(-5.0)), float(np.radians(78.0)))
    stop_stiffness_N_m: float = 5000.0
    stop_width_rad: float = float(np.radians(0.1))
    load_mass_kg: float = 0.0
    load_torque_N_m: float = 0.0
    hip_servo: Servo = Servo(100.0, 6.0e-5, 1.0e5, 600.0, 200.0)
    ankle_servo: Servo = Servo(100.0, 1.2e-5, 1.0e4, 60.0, 60.0)

    def contraction(self, sprocket_rad: Array, length_m: float) -> tuple[Array, Array]:
        """Contraction ratios of flexor and extensor of that rest length at a sprocket's angle of any shape."""
        turned = self.sprocket_radius_m * sprocket_rad / length_m
        return self.rest_contraction[0] + turned, self.rest_contraction[1] - turned


LEG = Leg(*winter_segments())
"""The leg of the examples. Its muscles, of 200 mm, stay between contractions of 0.01 and 0.24 over −5° to 75°."""
