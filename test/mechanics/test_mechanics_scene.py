"""A scene that is no peg and hole is refused with value, range and remedy."""

import numpy as np
import pytest

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene


@pytest.mark.parametrize(
    "change, message",
    [
        ({"peg_diameter": 0.05}, r"is not below scene.hole_diameter = 0.05 m: a peg"),
        ({"peg_diameter": 0.06}, r"check whether the two are exchanged"),
        ({"hole_diameter": 50.0}, r"hole_diameter = 50.0 m is not within 0.0001 to 1 m; 0.05 m"),
        ({"peg_height": 70.0}, r"0.07 m would be: the units look slipped by 1000"),
        ({"gravity": (0.0, 0.0, -9806.65)}, r"gravity = -9806.65 m/s\^2 is not within .* slipped"),
        ({"friction": -0.1}, r"friction = -0.1 is not within 0 to 2"),
        ({"friction": 150.0}, r"friction = 150.0 is not within 0 to 2$"),
        ({"friction": float("nan")}, r"friction = nan is not within"),
        ({"peg_mass": float("inf")}, r"peg_mass = inf kg is not within"),
        ({"peg_mass": 0.0}, r"peg_mass = 0.0 kg is not within"),
        ({"peg_height": "70 mm"}, r"peg_height = 70 mm m is not within"),
        ({"peg_chamfer": -1e-4}, r"peg_chamfer = -0.0001 m is not within 0 to 0.1 m$"),
        ({"hole_chamfer": 5.0}, r"5.0 m is not within 0 to 0.1 m; 0.005 m would be: the units"),
        ({"hole_chamfer": 0.05}, r"is not below scene.hole_diameter = 0.05 m: it is the height"),
        ({"peg_chamfer": 0.0499}, r"below scene.peg_diameter = 0.0499 m.* 0.0 where there is non"),
        ({"axial_inertia": -1e-4}, r"axial_inertia = -0.0001 kg m\^2 is not within"),
    ],
)
def test_an_impossible_scene_is_refused(change, message):
    with pytest.raises(PegOnHoleError, match=message) as caught:
        Scene(**change)
    # As a file of parameters has it.
    assert str(caught.value).startswith(f"scene.{next(iter(change))} = ")


def test_a_solid_cylinder_unless_given():
    scene = Scene(peg_mass=2.0, peg_diameter=0.04, peg_height=0.1)
    assert scene.mass_center_height == 0.05
    # By the integral over the cylinder, by the midpoint rule.
    r = (np.arange(400) + 0.5) / 400 * 0.02
    z = (np.arange(400) + 0.5) / 400 * 0.1 - 0.05
    share = 2 * r / 0.02**2 * (0.02 / 400)
    assert scene.axial_inertia == pytest.approx(2.0 * np.sum(share * r**2), rel=1e-4)
    transverse = 2.0 * (np.sum(share * r**2) / 2 + np.mean(z**2))
    assert scene.transverse_inertia == pytest.approx(transverse, rel=1e-4)
