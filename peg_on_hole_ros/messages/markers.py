"""Peg, rim, contact forces and friction cones as visualization_msgs markers in the hole frame."""

from math import cos, pi, sin

import numpy as np

from peg_on_hole_ros.mechanics.geometry import contact_geometry, normals
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.plain import HOLE_FRAME, header, quaternion, xyz
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.monitor.publishable_reactions import are_publishable
from peg_on_hole_ros.records import CONTACTS

# visualization_msgs/Marker
ARROW, CYLINDER, LINE_STRIP, LINE_LIST, TRIANGLE_LIST = 0, 3, 4, 5, 11
ADD, DELETE = 0, 2

# Elsewhere the estimate's place is one that the peg would have on its contacts.
TOUCHING = ("three_point", "two_point", "inserted")
RIM_SEGMENTS = 48
CONE_SEGMENTS = 16
LONGEST_ARROW = 3.0  # in hole diameters; a wedged peg's forces have no bound

_PEG_COLOR = {"r": 0.6, "g": 0.65, "b": 0.7, "a": 0.5}
_RIM_COLOR = {"r": 0.1, "g": 0.1, "b": 0.1, "a": 1.0}
_FORCE_COLOR = {"r": 0.85, "g": 0.15, "b": 0.1, "a": 1.0}
_CONE_COLOR = {"r": 0.1, "g": 0.4, "b": 0.85, "a": 0.3}
_NO_TURN = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def marker_array(outputs: OutputView, scene: Scene, frame: str = HOLE_FRAME) -> dict:
    """
    Return visualization_msgs/MarkerArray; what is not there any more is deleted by name.

    A peg whose place is not known, as nothing is known to touch, is drawn hollow; forces that are
    not determined, and cones of a contact that is not, are left out.

    Parameters
    ----------
    outputs : OutputView
    scene : Scene
    frame : str
        The hole's.

    """
    markers = [
        _peg(outputs, scene),
        _rim(outputs.t_ns, scene),
        *_forces(outputs, scene),
        *_cones(outputs, scene),
    ]
    for marker in markers:
        marker["header"]["frame_id"] = frame
    return {"markers": markers}


def _marker(t_ns, name, number, kind, scale, color, **more):
    pose = {"position": xyz((0, 0, 0)), "orientation": dict(_NO_TURN)}
    marker = {
        "header": header(t_ns),
        "ns": name,
        "id": number,
        "type": kind,
        "action": ADD,
        "pose": pose,
        "scale": xyz(scale),
        "color": color,
    }
    return marker | more


def _deleted(t_ns, name, number):
    return {"header": header(t_ns), "ns": name, "id": number, "action": DELETE}


def _peg(outputs, scene):
    d, H = scene.peg_diameter, scene.peg_height
    centre = outputs.position + outputs.rotation[:, 2] * (H / 2)
    pose = {"position": xyz(centre), "orientation": quaternion(outputs.rotation)}
    if outputs.contact_mode in TOUCHING:
        return _marker(outputs.t_ns, "peg", 0, CYLINDER, (d, d, H), _PEG_COLOR, pose=pose)
    lines = _outline(d / 2, H / 2)
    color = _PEG_COLOR | {"a": 1.0}
    return _marker(
        outputs.t_ns, "peg", 0, LINE_LIST, (d / 50, 0, 0), color, pose=pose, points=lines
    )


def _outline(R, half):
    """Return the ends of lines along both rims of a cylinder, and from one to the other."""
    turns = [2 * pi * i / CONE_SEGMENTS for i in range(CONE_SEGMENTS + 1)]
    low, high = ([xyz((R * cos(a), R * sin(a), z)) for a in turns] for z in (-half, half))
    rims = [end for rim in (low, high) for pair in zip(rim[:-1], rim[1:]) for end in pair]
    sides = zip(low[:-1:4], high[:-1:4])
    return [dict(end) for end in (*rims, *(end for side in sides for end in side))]


def _rim(t_ns, scene):
    R = scene.hole_diameter / 2
    turns = (2 * pi * i / RIM_SEGMENTS for i in range(RIM_SEGMENTS + 1))
    points = [xyz((R * cos(turn), R * sin(turn), 0)) for turn in turns]
    return _marker(t_ns, "rim", 0, LINE_STRIP, (R / 25, 0, 0), _RIM_COLOR, points=points)


def _forces(outputs, scene):
    D = scene.hole_diameter
    known = are_publishable(outputs.row)
    metre_per_newton = D / (5 * scene.peg_mass * 9.80665)
    for i in range(len(CONTACTS)):
        force = outputs.contact_force[i]
        length = float(np.linalg.norm(force)) * metre_per_newton
        if not known or not outputs.closed[i] or length < 1e-3 * D:
            yield _deleted(outputs.t_ns, "contact_force", i)
            continue
        tip = force * metre_per_newton * min(1.0, LONGEST_ARROW * D / length)
        # The arrow pushes at the contact: its head is there, outside the peg is its tail.
        points = [xyz(outputs.contact_point[i] - tip), xyz(outputs.contact_point[i])]
        scale = (D / 50, D / 25, D / 20)
        yield _marker(outputs.t_ns, "contact_force", i, ARROW, scale, _FORCE_COLOR, points=points)


def _cones(outputs, scene):
    gamma, psi = float(outputs.state[0]), float(outputs.state[1])
    three_point = outputs.contact_mode == "three_point" and scene.gamma0 < gamma < pi / 2
    axes = normals(contact_geometry(scene, gamma)) @ _about_z(psi).T if three_point else None
    # As it has been learnt, where it is.
    friction = outputs.monitor.get("friction", scene.friction)
    for i in range(len(CONTACTS)):
        if not three_point or not outputs.closed[i]:
            yield _deleted(outputs.t_ns, "friction_cone", i)
            continue
        points = _cone(outputs.contact_point[i], axes[i], friction, scene.hole_diameter / 5)  # type: ignore[index]
        yield _marker(
            outputs.t_ns, "friction_cone", i, TRIANGLE_LIST, (1, 1, 1), _CONE_COLOR, points=points
        )


def _about_z(angle):
    c, s = cos(angle), sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _cone(apex, axis, friction, height):
    """Return triangles of the mantle, three points each, opening along the normal."""
    least = np.eye(3)[np.argmin(np.abs(axis))]
    side = np.cross(axis, least)
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    turns = 2 * pi * np.arange(CONE_SEGMENTS + 1) / CONE_SEGMENTS
    circle = np.outer(np.cos(turns), side) + np.outer(np.sin(turns), other)
    base = apex + height * (axis + friction * circle)
    top = xyz(apex)
    return [point for a, b in zip(base[:-1], base[1:]) for point in (dict(top), xyz(a), xyz(b))]
