"""Recordings that a cell is calibrated with, and what comes of each, as figures."""

from functools import cache

import numpy as np

from benchmarks.calibration import drawn, truth_of
from benchmarks.harness.errors import INTERVAL
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.identification.calibration import calibrate
from peg_on_hole_ros.identification.outliers import outliers
from peg_on_hole_ros.identification.payload import find_payload
from peg_on_hole_ros.identification.presses import find_axes
from peg_on_hole_ros.identification.quantities import CALIBRATED_QUANTITIES, natural
from peg_on_hole_ros.identification.recording import Recording
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import WrenchSample

SEED, MOTION = 1, "turns both ways"
# A spike of the force [N], in one wrench of so many.
SPIKE, SPIKES_EVERY = 30.0, 97
STDDEV = np.array([0.2] * 3 + [0.005] * 3)
ANGLE_STDDEV = 1e-5
# Of what hangs at the sensor: masses [kg], and where, from the sensor [m].
PEG, PEG_AT = 0.5, np.array([0.0, 0.0, -0.035])
PAYLOAD, PAYLOAD_AT = 0.8, np.array([0.01, -0.02, 0.03])
ZERO = np.array([1.5, -2.0, 3.0, 0.04, -0.03, 0.02])
GRAVITY = np.array([0.0, 0.0, -9.80665])
POSES = ([0.05, 0.0, 0.0], [0.5, 0.0, 0.3], [0.5, 1.6, 0.3], [0.6, -1.5, 1.0])
# The presses' directions, a little off, and their strength [N].
PUSHES = np.array([[0.3, 0.0, 1.0], [1.0, 0.2, -0.2], [-0.2, 1.0, 0.1]])
STRENGTH = 25.0


@cache
def _calibrated():
    record, start, true = drawn(truth_of(MOTION), SEED)
    record.wrench[::SPIKES_EVERY, 0] += SPIKE
    return (
        record,
        start,
        [natural(of, x) for of, x in zip(CALIBRATED_QUANTITIES, true, strict=True)],
    )


def calibration() -> dict:
    """Return what a calibration from a wrong start finds, spikes left out as by the command."""
    record, start, true = _calibrated()
    sound = ~outliers(record.wrench_t, record.wrench)
    left = record._replace(wrench_t=record.wrench_t[sound], wrench=record.wrench[sound])
    found = calibrate(left, start)
    pairs = list(zip(found.estimates, true, strict=True))
    half = np.array([max(each.high - each.best, 1e-12) / INTERVAL for each in found.estimates])
    off = np.array([each.best - value for each, value in pairs]) / half
    return {
        "spikes left out": int((~sound).sum()),
        "intervals that hold": float(np.mean([e.low <= x <= e.high for e, x in pairs])),
        "error over stated": float(np.sqrt(np.mean(off**2))),
        "stated deviation": float(np.exp(np.mean(np.log(half)))),
        "NIS": float(found.nis),
        "joint states": found.innovations,
        "turned both ways": bool(found.both_ways),
        "seen": ", ".join(
            of.name for of, e in zip(CALIBRATED_QUANTITIES, found.estimates) if e.seen
        ),
        "found": ", ".join(f"{each.best:.17g}" for each in found.estimates),
    }


def still_poses() -> dict:
    """Return what payload and zero come to, of a peg that is held at four tilts."""
    random, t, q, wrench = np.random.default_rng(SEED), [], [], []
    for k, pose in enumerate(POSES):
        before = np.array(POSES[max(k - 1, 0)])
        for i in range(1000):
            here = before + min(i / 400, 1.0) * (np.array(pose) - before)
            held = -peg_axes(here).T @ GRAVITY
            torque = np.cross(PEG_AT, PEG * held) + np.cross(PAYLOAD_AT, PAYLOAD * held)
            t.append((1000 * k + i) * 1e-3)
            q.append(here + random.normal(0.0, ANGLE_STDDEV, 3))
            wrench.append(np.r_[(PEG + PAYLOAD) * held, torque] + ZERO)
    rows = np.array(wrench) + random.normal(0.0, STDDEV, (len(t), 6))
    covariance = np.broadcast_to(ANGLE_STDDEV**2 * np.eye(3), (len(t) // 2, 3, 3))
    stamps = np.array(t)
    record = Recording(stamps, rows, stamps[::2], np.array(q)[::2], covariance)
    found = find_payload(record, Configuration())
    return {
        "poses": found.poses,
        "mass error [g]": 1e3 * (found.mass - PAYLOAD),
        "mass known to [g]": 1e3 * found.mass_stddev,
        "zero error [N]": float(np.abs(found.bias[:3] - ZERO[:3]).max()),
        "left [N]": found.left,
        "missing": "; ".join(found.missing),
        "found": ", ".join(f"{x:.17g}" for x in (found.mass, *found.com, *found.bias)),
    }


def presses() -> dict:
    """Return what axes and sign come to, of a peg that a hand presses three times."""
    random, samples = np.random.default_rng(SEED), []
    for push in PUSHES / np.linalg.norm(PUSHES, axis=1)[:, None]:
        for i in range(2500):
            hand = STRENGTH * np.sin(np.pi * min(max((i - 700) / 1000, 0.0), 1.0)) * push
            read = PEG * GRAVITY - hand + ZERO[:3] + random.normal(0.0, 0.5, 3)
            samples.append(WrenchSample(len(samples) * 1_000_000, tuple(read), (0.0,) * 3))
    found = find_axes(samples)
    return {
        "acts_on": found.acts_on,
        "turned [degrees]": found.turned,
        "missed [degrees]": found.missed,
        "force [N]": float(found.forces.mean()),
        "found": ", ".join(f"{x:.17g}" for x in (*found.rpy, *found.found, *found.forces)),
    }
