"""A knee of one fixed axis, as the joint of the paper's equation (8)."""

from dataclasses import dataclass

from .four_bar import Array, FourBar, Posture, as_array


@dataclass(frozen=True)
class Hinge:
    """The shank turns about the knee's origin, the sprocket with it at the fixed `ratio`. Its links are idle."""

    ratio: float
    lengths = (0.0, 1.0, 1.0, 1.0)
    crank_thigh = rocker_thigh = 0j

    @classmethod
    def like(cls, knee: FourBar, flexion_rad: tuple[float, float]) -> "Hinge":
        """The mean transmission of a four-bar between two flexions."""
        begin, end = (float(knee.at(angle).sprocket) for angle in flexion_rad)
        return cls((end - begin) / (flexion_rad[1] - flexion_rad[0]))

    def at(self, flexion: Array) -> Posture:
        """The posture at `flexion` in rad, any shape."""
        flexion = as_array(flexion)
        still = 0.0 * flexion
        link = (still + 0j, still + 0j, still + 0j)
        return Posture(self.ratio * flexion, still + self.ratio, still, link, link, link)
