"""What is fixed while a peg is set on a hole: sizes, mass, friction, gravity."""

from dataclasses import dataclass
from math import isfinite
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError, wrong_prefix_remedy

# Least, greatest and unit of each number; the table of parameters has them from here.
RANGES = {
    "hole_diameter": (1e-4, 1.0, "m"),
    "peg_diameter": (1e-4, 1.0, "m"),
    "peg_height": (1e-4, 10.0, "m"),
    "peg_mass": (1e-6, 1e4, "kg"),
    "friction": (0.0, 2.0, ""),
    "mass_center_height": (0.0, 10.0, "m"),
    "transverse_inertia": (0.0, 100.0, "kg m^2"),
    "axial_inertia": (0.0, 100.0, "kg m^2"),
    "gravity": (-100.0, 100.0, "m/s^2"),
    "clearance_stddev": (0.0, 0.01, "m"),
    "friction_stddev": (0.0, 1.0, ""),
    "clearance_drift": (0.0, 0.01, "m/s^0.5"),
    "friction_k_stddev": (0.0, 1.0, ""),
    "compliance_stddev": (0.0, 1e-5, "m/N"),
    "hole_chamfer": (0.0, 0.1, "m"),
    "peg_chamfer": (0.0, 0.1, "m"),
}


@dataclass(frozen=True)
class Scene:
    """
    Peg, hole and gravity. Zero for an inertia or a centre height means a solid cylinder's.

    Diameters are those of bore and shank. Where the parts have chamfers, heights count from the
    shoulder, where the shank begins, and the rim is the throat, where the bore does.

    Attributes
    ----------
    hole_diameter, peg_diameter, peg_height : float
        D, d, H [m]; 0 < d < D <= 1, 0 < H <= 10.
    peg_mass : float
        m [kg], including what is rigid with the peg below the sensor.
    friction : float
        Coulomb coefficient f, 0 <= f <= 2.
    mass_center_height : float
        Of the mass centre above the lower end face, or the shoulder [m].
    transverse_inertia, axial_inertia : float
        Ie, Iz about the mass centre [kg m^2].
    gravity : tuple of 3 float
        In hole axes [m/s^2].
    clearance_stddev : float
        Standard deviation of D - d [m].
    friction_stddev : float
        Standard deviation of f.
    clearance_drift : float
        By which the effective clearance walks, as no rim is an ideal circle [m] per root second.
    friction_k_stddev : float
        By which friction at K may differ from f; 0: one friction.
    compliance_stddev : float
        By how much a load may take from the effective clearance [m/N]; 0: rigid.
    hole_chamfer, peg_chamfer : float
        Heights of the chamfers along their axes [m]: how far the throat is below the outer face,
        and the shoulder above the outermost end; 0: sharp. No contact depends on them
        (docs/mechanics.md, "Chamfers"), but where peg and hole are stated does.

    """

    hole_diameter: float = 0.050
    peg_diameter: float = 0.0499
    peg_height: float = 0.070
    peg_mass: float = 0.5
    friction: float = 0.2
    mass_center_height: float = 0.0
    transverse_inertia: float = 0.0
    axial_inertia: float = 0.0
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.80665)
    clearance_stddev: float = 0.0
    friction_stddev: float = 0.05
    clearance_drift: float = 0.0
    friction_k_stddev: float = 0.0
    compliance_stddev: float = 0.0
    hole_chamfer: float = 0.0
    peg_chamfer: float = 0.0

    def __post_init__(self) -> None:
        """Refuse sizes that are no peg and hole, and units slipped by 1000."""
        for name, limits in RANGES.items():
            value = getattr(self, name)
            for number in value if name == "gravity" else (value,):
                _within(f"scene.{name}", number, *limits)
        if self.peg_diameter >= self.hole_diameter:
            raise PegOnHoleError(
                f"scene.peg_diameter = {self.peg_diameter:g} m is not below scene.hole_diameter = "
                f"{self.hole_diameter:g} m: a peg rests on three points of a rim only if it is "
                "thinner than the hole; check whether the two are exchanged"
            )
        for part in ("hole", "peg"):
            height, diameter = getattr(self, f"{part}_chamfer"), getattr(self, f"{part}_diameter")
            if height >= diameter:
                raise PegOnHoleError(
                    f"scene.{part}_chamfer = {height:g} m is not below scene.{part}_diameter = "
                    f"{diameter:g} m: it is the height of the chamfer's cone along the axis, "
                    "mostly tenths of a millimetre; 0.0 where there is none"
                )
        if not self.mass_center_height:
            object.__setattr__(self, "mass_center_height", self.peg_height / 2)
        radius2 = (self.peg_diameter / 2) ** 2
        if not self.transverse_inertia:
            solid = self.peg_mass * (3 * radius2 + self.peg_height**2) / 12
            object.__setattr__(self, "transverse_inertia", solid)
        if not self.axial_inertia:
            object.__setattr__(self, "axial_inertia", self.peg_mass * radius2 / 2)

    @property
    def gamma0(self) -> float:
        """Tilt at which B1 and B2 merge and three-point contact ends, acos(d/D) [rad]."""
        d, D = self.peg_diameter, self.hole_diameter
        # acos(d/D) loses half the digits near 1; this form keeps them.
        return 2 * float(np.arcsin(np.sqrt((D - d) / (2 * D))))


def _within(name, value, low, high, unit):
    number = isinstance(value, (int, float)) and isfinite(value)
    if number and low <= value <= high:
        return
    remedy = number and wrong_prefix_remedy(value, unit, low, high)
    unit = f" {unit}" if unit else ""
    raise PegOnHoleError(
        f"{name} = {value}{unit} is not within {low:g} to {high:g}{unit}"
        + (f"; {remedy}" if remedy else "")
    )


class SceneScalars(NamedTuple):
    """A scene as floats, in the paper's letters; see `Scene` for units."""

    d: float
    D: float
    H_c: float
    gamma0: float
    m: float
    Ie: float
    Iz: float
    f: float
    g_x: float
    g_y: float
    g_z: float


def scene_scalars(scene: Scene) -> SceneScalars:
    """Return the scene for the kernel."""
    return SceneScalars(
        scene.peg_diameter,
        scene.hole_diameter,
        scene.mass_center_height,
        scene.gamma0,
        scene.peg_mass,
        scene.transverse_inertia,
        scene.axial_inertia,
        scene.friction,
        *(float(component) for component in scene.gravity),
    )
