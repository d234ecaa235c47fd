"""A made-up stream of wrenches and joint states: what the numbers mean matters to no test here."""

import numpy as np

from peg_on_hole_ros.messages.plain import header


def wrench(t_ns, force=(0.0, 0.0, -4.0), torque=(0.0, 0.3, 0.0)) -> dict:
    """Return a WrenchStamped."""
    return {
        "header": header(t_ns, "sensor"),
        "wrench": {"force": dict(zip("xyz", force)), "torque": dict(zip("xyz", torque))},
    }


def joints(t_ns, gamma=0.15, psi=0.0, phi=0.0) -> dict:
    """Return a JointState of the peg's own joints."""
    names, position = ["gamma", "psi", "phi"], [gamma, psi, phi]
    return {"header": header(t_ns), "name": names, "position": position}


def hanging(t_ns, gamma=0.15) -> dict:
    """Return a WrenchStamped of the default peg that hangs free at a tilt: weight and noise."""
    noise = np.random.default_rng(t_ns).normal(0.0, [0.2] * 3 + [0.005] * 3)
    up = 0.5 * 9.80665 * np.array([np.sin(gamma), 0.0, np.cos(gamma)])
    torque = np.cross([0.0, 0.0, -0.035], up)
    return wrench(t_ns, (up + noise[:3]).tolist(), (torque + noise[3:]).tolist())


def closing(count, start_ns=10_000_000_000, seed=1):
    """
    Yield (source, message): wrench at 1 kHz, joint states at 500 Hz, closing at 0.16 rad/s.

    With noise, and slip of 2 rad/s, so that every output changes from stamp to stamp.
    """
    random = np.random.default_rng(seed)
    for k in range(count):
        t, t_ns = k * 1e-3, start_ns + k * 1_000_000
        if k % 2 == 0:
            gamma, psi, phi = (0.15 - 0.1 * t, 0.2 * t, 2.0 * t) + random.normal(0, 1e-4, 3)
            yield "joints", joints(t_ns, float(gamma), float(psi), float(phi))
        force = np.array([0.0, 0.0, -4.0]) + random.normal(0, 0.2, 3)
        torque = np.array([0.0, 0.3, 0.0]) + random.normal(0, 0.005, 3)
        yield "wrench", wrench(t_ns, force.tolist(), torque.tolist())
