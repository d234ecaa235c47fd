"""Estimates made by hand for the tests of messages: three-point contact of the paper's scene."""

import numpy as np
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.estimator.state import BIAS, TILT
from peg_on_hole_ros.mechanics.geometry import contact_geometry, contact_points, normals
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import Alarm, Outputs

SCENE = Scene()
ALARMS = ("jamming", "contact_loss", "overload")


def estimate(t_ns=1_500_000_000, gamma=0.15, psi=0.4, phi=-1.1, **more) -> Outputs:
    """Return one estimate; its contact points, rotation and normals fit together."""
    geometry = contact_geometry(SCENE, gamma)
    turn = Rotation.from_euler("z", psi).as_matrix()
    rotation = Rotation.from_euler("ZYZ", [psi, -gamma, phi]).as_matrix()
    points = contact_points(geometry, SCENE.hole_diameter) @ turn.T
    normal = np.array([20.0, 9.0, 11.0])
    forces = normal[:, None] * (normals(geometry) @ turn.T)
    axis = rotation[:, 2]
    centre = np.array([0.0, 0.0, float(geometry.a1)]) - float(geometry.a2) * axis
    alarms = tuple(Alarm(name, 0, "fine", ("value",), (0.1,)) for name in ALARMS)
    outputs = Outputs(
        t_ns=t_ns,
        state=np.array([gamma, psi, phi, -0.16, 0.1, 2.0]),
        state_covariance=np.diag([1e-10, 2e-10, 3e-10, 1e-4, 2e-4, 3e-4]),
        normal=normal,
        normal_stddev=np.array([0.5, 0.3, 0.4]),
        slip_speed=np.array([0.05, 0.04, 0.03]),
        slip_speed_stddev=np.array([0.001, 0.002, 0.003]),
        closed=np.array([True, True, True]),
        contact_force=forces,
        contact_point=points,
        position=centre,
        rotation=rotation,
        pose_covariance=1e-8 * np.ones((6, 6)),
        monitor={
            "transition_probability": 0.25,
            "jamming_risk": 0.5,
            "reactions_determined": 1.0,
        },
        contact_mode="three_point",
        transition=False,
        alarms=alarms,
    )
    return outputs._replace(**more)


def learnt(kalman):
    """Return bias and tilt that a filter has learnt, with standard deviations, by name."""
    bias = [f"bias_{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz"]
    found, s, at = {}, kalman.state, kalman.held["at"]
    for quantity, names in ((BIAS, bias), (TILT, ["hole_tilt_x", "hole_tilt_y"])):
        for i, name in enumerate(names if at[quantity] >= 0 else []):
            k = at[quantity] + i
            found[name] = float(s.mean[k])
            found[f"{name}_stddev"] = float(np.sqrt(max(s.covariance[k, k], 0.0)))
    return found
