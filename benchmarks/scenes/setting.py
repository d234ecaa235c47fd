"""What every family of scenes draws: scene, speed, press, holder and noise."""

from typing import NamedTuple

from benchmarks.harness.draw import Draw
from peg_on_hole_ros.mechanics.scene import Scene

D = 0.050


class Setting(NamedTuple):
    """What every family draws; a family replaces what it is about."""

    clearance: float
    friction: float
    mass: float
    speed: float  # of closing [rad/s]
    slide: float  # psi' [rad/s]
    slip: float  # phi' [rad/s]
    press: float  # commanded into the hole [m]
    stiffness: float
    rotational_stiffness: float
    noise: float
    max_normal: float

    @property
    def scene(self) -> Scene:
        """Return the true scene."""
        return Scene(
            hole_diameter=D,
            peg_diameter=D - self.clearance,
            friction=self.friction,
            peg_mass=self.mass,
        )


def setting_of(draw: Draw, **given) -> Setting:
    """Return a setting with what is given in place of what would be drawn."""
    drawn = Setting(
        clearance=draw.log(5e-5, 4e-4),
        friction=draw.even(0.1, 0.3),
        mass=draw.even(0.3, 1.0),
        speed=draw.log(0.06, 0.4),
        slide=draw.even(-0.3, 0.3),
        slip=draw.sign() * draw.even(1.0, 3.0),
        press=draw.even(0.5e-3, 1.5e-3),
        stiffness=2e4 * draw.log(0.6, 1.6),
        rotational_stiffness=2e3 * draw.log(0.6, 1.6),
        noise=draw.log(0.5, 2.0),
        max_normal=1000.0,
    )
    drawn = drawn._replace(**given)
    # Not more than the hole's tilt left to go on after the transition.
    return drawn._replace(speed=min(drawn.speed, 3.0 * drawn.scene.gamma0))
