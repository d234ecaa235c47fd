"""Closings that another engine simulated, as scenes: same sensors, same scores."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from benchmarks.harness.draw import Draw
from benchmarks.harness.events import SceneLabels, score_run
from benchmarks.harness.truths import play
from benchmarks.scenes.draw import told_wrongly
from benchmarks.scenes.setting import D
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.mechanics.scene import Scene

# Made by `mujoco_closings.py`.
TRACES = Path(__file__).parents[1] / "engines" / "data" / "mujoco_closings.npz"
FIELDS = ("clearance", "friction", "mass", "closing", "slide", "slip", "press", "before")
GRAVITY = 9.81
# A contact that carries less [N] is open: the mean over a millisecond has no other bound.
TOUCHES = 0.05
SEED = 6_200
VARIANTS = ("engine", "engine_mismatch")


def numbers() -> list[int]:
    """Return the scenes that there are."""
    if not TRACES.exists():
        return []
    with np.load(TRACES) as stored:
        return sorted(int(name[2:]) for name in stored.files if name.startswith("q_"))


def truth_of(number: int):
    """Return motion and loads of a scene, with what the sensors need of a plan."""
    with np.load(TRACES) as stored:
        values, q, rest = (stored[f"{name}_{number}"] for name in ("setting", "q", "rest"))
    setting = dict(zip(FIELDS, values.tolist(), strict=True))
    scene = Scene(
        hole_diameter=D,
        peg_diameter=D - setting["clearance"],
        friction=setting["friction"],
        peg_mass=setting["mass"],
        gravity=(0.0, 0.0, -GRAVITY),
    )
    plan = SimpleNamespace(
        configuration=Configuration(scene=scene), seed=0, wrench_rate=1000, joint_rate=500
    )
    return SimpleNamespace(
        plan=plan,
        t_ns=np.arange(len(q)) * 1_000_000,
        q=q,
        force=rest[:, :3].astype(float),
        moment=rest[:, 3:6].astype(float),
        normal=rest[:, 6:].astype(float),
    )


def labels_of(truth) -> SceneLabels:
    """
    Return what truly happened, by tilt and contact forces.

    Contacts that give press the peg in by some micrometres: below gamma0 of the stated diameters
    it counts as in the hole, whatever the rim gives.

    """
    closed = truth.normal > TOUCHES
    gamma = truth.q[:, 0] - truth.plan.configuration.scene.gamma0
    kind = np.where(closed.all(axis=1), "three_point", "lost").astype("U11")
    kind[~closed.any(axis=1)] = "open"
    kind[(gamma < 0) & closed.any(axis=1)] = "two_point"
    t = truth.t_ns * 1e-9
    passed = np.flatnonzero((gamma[1:] < 0) & (gamma[:-1] >= 0))
    transition = None
    if passed.size:
        k = passed[0]
        transition = float(t[k] + gamma[k] / (gamma[k] - gamma[k + 1]) * (t[k + 1] - t[k]))
    return SceneLabels(t, kind, gamma < 0, transition, ())


def score(number: int, variant: str) -> dict:
    """Return the figures of one scene, as of the others."""
    truth = truth_of(number)
    configuration = truth.plan.configuration
    if variant == "engine_mismatch":
        configuration = told_wrongly(configuration, Draw([SEED, number, 2]))
    record = play(truth, configuration, [[SEED, number, 1]])
    return score_run(labels_of(truth), record)
