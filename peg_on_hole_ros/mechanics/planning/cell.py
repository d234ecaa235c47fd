"""What a planned motion may use of its cell: holder, rates, chances of passing a limit."""

from dataclasses import dataclass
from math import pi

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene

AIMS = ("time", "turning")


@dataclass(frozen=True)
class Cell:
    """
    Holder and limits of a planned motion.

    Attributes
    ----------
    aim : str
        What is least: `time`, or `turning`, the way of slip and slide together.
    start_tilt : float
        Tilt at which the peg has been set on the rim [rad].
    press : tuple of 3 float
        Push of the holder along h, e, z beside the peg's weight, which it carries [N].
    grip_height : float
        Of the point that the holder grips above the lower end face, on the peg's axis [m].
    stiffness, rotational_stiffness : float
        Of the holder [N/m], [N m/rad].
    damping_ratio : float
        Of the peg on the free holder.
    force_limit, torque_limit : float
        Of the holder, about the mass centre [N], [N m].
    min_closing_rate, max_closing_rate : float
        [rad/s]
    max_slip_rate, max_slide_rate : float
        Of phi and psi; 0: that turn is not used [rad/s].
    max_acceleration : float
        Of each angle [rad/s^2].
    tilt_margin : float
        By how much of tilt turning begins before it has to, for a tilt that is not quite known
        [rad].
    wedge_probability : float
        That friction's and clearance's spread may leave for a wedge.
    overload_probability : float
        The same for a load beyond its limit, a contact that parts, or a limit of the holder.

    """

    aim: str = "time"
    start_tilt: float = 0.2
    press: tuple[float, float, float] = (-10.0, 0.0, -30.0)
    grip_height: float = 0.070
    stiffness: float = 2.0e4
    rotational_stiffness: float = 2.0e3
    damping_ratio: float = 0.7
    force_limit: float = 200.0
    torque_limit: float = 20.0
    min_closing_rate: float = 0.02
    max_closing_rate: float = 0.2
    max_slip_rate: float = 2.0
    max_slide_rate: float = 0.0
    max_acceleration: float = 10.0
    tilt_margin: float = 0.005
    wedge_probability: float = 0.01
    overload_probability: float = 0.03

    def damping(self, scene: Scene) -> tuple[float, float]:
        """Return the holder's damping [N s/m], [N m s/rad]."""
        ratio = 2 * self.damping_ratio
        return (
            ratio * (self.stiffness * scene.peg_mass) ** 0.5,
            ratio * (self.rotational_stiffness * scene.transverse_inertia) ** 0.5,
        )


def check_start(scene: Scene, tilt: float, name: str = "plan.start_tilt") -> None:
    """
    Refuse a tilt at which a peg does not rest on three points.

    Raises
    ------
    PegOnHoleError

    """
    if not scene.gamma0 < tilt < pi / 2:
        raise PegOnHoleError(
            f"{name} = {tilt:g} rad is not between gamma0 = {scene.gamma0:.6g} rad and "
            f"{pi / 2:.6g} rad, both excluded: the peg rests on three points between them; gamma0 "
            "follows from the two diameters"
        )
