"""Estimates made by hand for the tests of messages: three-point contact of the paper's scene."""

import numpy as np
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.mechanics.geometry import contact_geometry, contact_points, normals
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.monitor.output_row import MONITOR, NOTHING, ROW
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.monitor.states import MODES
from peg_on_hole_ros.records import Rows

SCENE = Scene()
ALARMS = ("jamming", "contact_loss", "overload")


def estimate(t_ns=1_500_000_000, gamma=0.15, psi=0.4, phi=-1.1, **more) -> OutputView:
    """Return one estimate; its contact points, rotation and normals fit together."""
    geometry = contact_geometry(SCENE, gamma)
    turn = Rotation.from_euler("z", psi).as_matrix()
    rotation = Rotation.from_euler("ZYZ", [psi, -gamma, phi])
    points = contact_points(geometry, SCENE.hole_diameter) @ turn.T
    normal = np.array([20.0, 9.0, 11.0])
    forces = normal[:, None] * (normals(geometry) @ turn.T)
    axis = rotation.as_matrix()[:, 2]
    centre = np.array([0.0, 0.0, float(geometry.a1)]) - float(geometry.a2) * axis
    variance = [1e-10, 2e-10, 3e-10, 1e-4, 2e-4, 3e-4]
    orientation = rotation.as_quat()
    made = {
        "state": [gamma, psi, phi, -0.16, 0.1, 2.0],
        "state_stddev": np.sqrt(variance),
        "state_covariance": np.diag(variance),
        "normal": normal,
        "normal_stddev": [0.5, 0.3, 0.4],
        "slip_speed": [0.05, 0.04, 0.03],
        "slip_speed_stddev": [0.001, 0.002, 0.003],
        "closed": 1.0,
        "contact_wrench": np.hstack([forces, np.cross(points, forces)]),
        "contact_point": points,
        "position": centre,
        "rotation": rotation.as_matrix(),
        "orientation": orientation * np.copysign(1.0, orientation[3]),
        "pose_covariance": 1e-8 * np.ones((6, 6)),
        "monitor": {
            "transition_probability": 0.25,
            "jamming_risk": 0.5,
            "reactions_determined": 1.0,
        },
        "contact_mode": "three_point",
        "transition": False,
        "alarms": dict.fromkeys(ALARMS, 0),
    }
    return changed(OutputView(t_ns, NOTHING[0]), **made | more)


def changed(
    outputs: OutputView, alarms=None, monitor=None, contact_mode=None, **fields
) -> OutputView:
    """
    Return outputs with other values.

    Those of the row by their names; `alarms` as levels by name, empty: nobody looks after them;
    `monitor` has all numbers that exist; and `contact_mode` by its name.
    """
    row = outputs.row.copy()
    for name, value in fields.items():
        row[name] = value
    if contact_mode is not None:
        row["contact_mode"] = MODES.index(contact_mode)
    if alarms is not None:
        row["alarms"]["level"] = [alarms.get(name, 0 if alarms else -1) for name in ALARMS]
    if monitor is not None:
        left = dict(monitor)
        for field, output in MONITOR.items():
            values = [left.pop(name, np.nan) for name in output.names or (field,)]
            row[field] = values if output.names else values[0]
        assert not left
    return OutputView(outputs.t_ns, row)


def columns(stream, *outputs: OutputView) -> OutputColumns:
    """Return what outputs of stamps that rise make a stream say."""
    values = np.empty(len(outputs), ROW)
    for i, each in enumerate(outputs):
        values[i] = each.row
    rows = Rows(np.array([each.t_ns for each in outputs], np.int64), values)
    return OutputColumns(rows, stream.beside(rows))


def messages(stream, outputs: OutputView):
    """Return all messages that outputs make a stream say."""
    return columns(stream, outputs).messages(0)


def learnt(kalman):
    """Return bias and tilt that a filter has learnt, with standard deviations, by name."""
    bias = [f"bias_{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz"]
    found, mixture, places = {}, kalman.mixture, kalman.places
    tilt = ["hole_tilt_x", "hole_tilt_y"]
    for first, names in ((places.bias, bias), (places.tilt, tilt)):
        for k, name in enumerate(names if first >= 0 else [], first):
            found[name] = float(mixture.mean[k])
            found[f"{name}_stddev"] = float(np.sqrt(max(mixture.covariance[k, k], 0.0)))
    return found
