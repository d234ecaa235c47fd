"""A peg in the hole on two points, and what its sensor feels, built from points and normals."""

import numpy as np

from peg_on_hole_ros.records import JointSample, WrenchSample

START_NS = 5_000_000_000
GRAVITY = 9.80665


def length_inside(scene, gamma):
    """Return l, from the peg's lower edge up to K along its side [m]."""
    return (scene.hole_diameter - scene.peg_diameter * np.cos(gamma)) / np.sin(gamma)


def tilt_at(scene, length):
    """Return the tilt below gamma0 at which so much of the peg is in the hole [rad]."""
    low, high = 1e-5, np.arccos(scene.peg_diameter / scene.hole_diameter)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if length_inside(scene, middle) > length else (low, middle)
    return middle


def peg_axes(gamma):
    """Return the peg's axes as columns in the hole's, psi = phi = 0."""
    c, s = np.cos(gamma), np.sin(gamma)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def contacts(scene, gamma):
    """Return mass centre, K and B, and the normals on the peg; the peg leans in the plane x z."""
    d, D = scene.peg_diameter, scene.hole_diameter
    across, _, along = peg_axes(gamma).T
    K = np.array([-D / 2, 0, 0])
    depth = length_inside(scene, gamma) * np.cos(gamma) - d * np.sin(gamma)
    B = np.array([D / 2, 0, -depth])
    centre = B - d / 2 * across + scene.mass_center_height * along
    return centre, np.array([K, B]), np.array([across, [-1.0, 0, 0]])


def applied(scene, gamma, loads, friction, share=1.0, around=0.0):
    """
    Return force and moment about the mass centre, hole axes, of a peg that slides into the hole.

    Parameters
    ----------
    scene : Scene
    gamma : float
        [rad].
    loads : sequence of 2 float
        N_K, N_B [N].
    friction : float, or sequence of 2 float
        True one [-], at K and at B.
    share : float
        Of the push that would make it slide.
    around : float
        Speed of the peg's surface about its axis, over that into the hole.

    """
    centre, points, normals = contacts(scene, gamma)
    # K slides along the peg's side, B along the wall; a turn moves them to opposite sides.
    e = np.array([0.0, around, 0.0])
    ways = peg_axes(gamma)[:, 2] + e, np.array([0.0, 0.0, 1.0]) - e
    frictions = np.broadcast_to(friction, 2) / np.hypot(1.0, around)
    force, moment = np.array([0.0, 0.0, scene.peg_mass * GRAVITY]), np.zeros(3)
    for load, f, point, normal, way in zip(loads, frictions, points, normals, ways, strict=True):
        pressed = load * (normal + f * way)
        force, moment = force - pressed, moment - np.cross(point - centre, pressed)
    weight = scene.peg_mass * GRAVITY
    force[2] = weight + share * (force[2] - weight)
    return force, moment


def samples(configuration, tilts, loads, friction, share=1.0, seed=1, turning=0.0):
    """
    Yield what sensors say, 1 kHz of wrenches and 500 Hz of angles, of tilts 1 ms apart.

    Loads may be those of each tilt. A peg that is `turning` [rad/s] has to go in all the time.
    """
    draw, scene = np.random.default_rng(seed), configuration.scene
    w, j = configuration.wrench, configuration.joints
    lever = np.array(w.sensor_xyz) - [0.0, 0.0, scene.mass_center_height]
    loads, around = np.broadcast_to(loads, (len(tilts), 2)), np.zeros(len(tilts))
    if turning:
        into = np.gradient([length_inside(scene, gamma) for gamma in tilts], 1e-3)
        around = turning * scene.peg_diameter / 2 / into
    for i, gamma in enumerate(tilts):
        t_ns, phi = START_NS + i * 1_000_000, turning * i * 1e-3
        c, s = np.cos(phi), np.sin(phi)
        R = peg_axes(gamma) @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        force, moment = applied(scene, gamma, loads[i], friction, share, around[i])
        force, moment = R.T @ force, R.T @ moment
        torque = moment - np.cross(lever, force) + draw.normal(0, w.torque_stddev, 3)
        force = force + draw.normal(0, w.force_stddev, 3)
        if i % 2 == 0:
            n = draw.normal(0, j.position_stddev, 3)
            angles = (gamma + n[0], n[1] / gamma, phi - n[1] / gamma + n[2])
            yield JointSample(t_ns, ("gamma", "psi", "phi"), tuple(map(float, angles)))
        yield WrenchSample(t_ns, tuple(map(float, force)), tuple(map(float, torque)))
