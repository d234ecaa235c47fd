"""
Bounds of pegs that no setting was chosen on, over whole cycles.

Friction is drawn and learnt. Which share of the reactions that are called determined lies within
95 % bounds, of K, B1 and B2 the least (limit 90 %), and which share of the samples that slide is
called determined.
"""

from pathlib import Path

from benchmarks.harness.errors import REACTIONS, SETTLE_NS, coverage, run_seeds
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate

FIRST_SEED = 650_000
SLIDES = 1e-4  # [m/s]
_UR = {
    "scene": Scene(
        hole_diameter=0.010, peg_diameter=0.00998, peg_height=0.030, peg_mass=0.020, friction=0.12
    ),
    "wrench": WrenchInput(sensor_xyz=(0.002, -0.003, 0.180), force_stddev=0.3, torque_stddev=0.01),
    "joints": JointInput(position_stddev=5e-5),
    "rates": 500,
    "holder": (5e3, 200.0),
    "press": -0.002,
}
_SIXTEEN = {
    "scene": Scene(
        hole_diameter=0.016, peg_diameter=0.01597, peg_height=0.040, peg_mass=0.15, friction=0.22
    ),
    "wrench": WrenchInput(sensor_xyz=(0.001, 0.0, 0.090), force_stddev=0.2, torque_stddev=0.005),
    "joints": JointInput(position_stddev=1e-4),
    "rates": 1000,
    "holder": (1e4, 300.0),
    "press": -0.0025,
}
_THIRTY = {
    "scene": Scene(
        hole_diameter=0.030, peg_diameter=0.02992, peg_height=0.045, peg_mass=0.4, friction=0.3
    ),
    "wrench": WrenchInput(sensor_xyz=(0.0, 0.002, 0.120), force_stddev=0.5, torque_stddev=0.01),
    "joints": JointInput(position_stddev=1e-4),
    "rates": 1000,
    "holder": (2e4, 1e3),
    "press": -0.002,
}
_HUNDRED = {
    "scene": Scene(
        hole_diameter=0.100, peg_diameter=0.0998, peg_height=0.14, peg_mass=4.0, friction=0.15
    ),
    "wrench": WrenchInput(sensor_xyz=(0.0, 0.0, 0.20), force_stddev=1.0, torque_stddev=0.05),
    "joints": JointInput(position_stddev=5e-5),
    "rates": 500,
    "holder": (5e4, 8e3),
    "press": -0.001,
}
# Of each the tilt at touch-down [rad], and the rates of what follows with how long it lasts [s].
PEGS = {
    "10 mm, 180 mm lever, 500 Hz, with spin": (
        _UR, 0.24, [((0.0, 0.0, 1.5), 0.3), ((-0.12, 0.0, 1.5), 1.0)]
    ),
    "10 mm, 180 mm lever, 500 Hz, without spin": (
        _UR, 0.20, [((-0.06, 0.0, 0.0), 0.3), ((-0.06, 0.0, 0.0), 1.5)]
    ),
    "16 mm, reversals": (
        _SIXTEEN, 0.22, [
            ((-0.02, 0.4, 1.0), 0.3), ((-0.12, -0.6, 2.0), 0.4), ((0.06, 0.6, -2.0), 0.4),
            ((-0.15, -0.6, 2.0), 0.4), ((0.02, 0.3, -2.0), 0.4), ((-0.15, 0.0, 2.0), 0.5),
        ],
    ),
    "30 mm, 120 mm lever, precession": (
        _THIRTY, 0.20, [
            ((0.0, 0.5, 0.5), 0.3), ((-0.08, 0.8, -0.5), 0.8), ((0.05, -0.8, 1.0), 0.8),
        ],
    ),
    "100 mm, 500 Hz, closing": (
        _HUNDRED, 0.20, [
            ((0.0, 0.0, 1.0), 0.3), ((-0.10, 0.0, 1.0), 0.8), ((-0.02, 0.4, -1.0), 0.8),
        ],
    ),
}  # fmt: skip


def cycle(name):
    """Return the truth of one of PEGS: it comes from the air, touches down and slides."""
    peg, tilt, slides = PEGS[name]
    configuration = Configuration(scene=peg["scene"], wrench=peg["wrench"], joints=peg["joints"])
    first = slides[0][0]
    phases = {
        "approach": {
            "kind": "free", "duration": 0.8, "angles": [tilt, 0.3, 0.2], "rates": list(first),
            "offset": [0.0, 0.0, 0.0],
        }
    }  # fmt: skip
    for k, (rates, duration) in enumerate(slides):
        phases[f"slide_{k}"] = {"kind": "contact", "duration": duration, "rates": list(rates)}
    phases["slide_0"]["offset"] = [-0.0005, 0.0, peg["press"]]
    tree = {
        "wrench_rate": peg["rates"], "joint_rate": 500, "settle": 0.06,
        "holder": {
            "stiffness": peg["holder"][0], "rotational_stiffness": peg["holder"][1],
            "damping_ratio": 0.7, "force_limit": 1000.0, "torque_limit": 100.0,
        },
        "start": {"angles": [tilt + 0.01, 0.3, 0.0], "offset": [0.0, 0.0, 0.005]},
        "phases": phases,
    }  # fmt: skip
    return integrate(plan_from_tree(configuration, tree))


def score_member(peg: Member, folder: Path) -> dict:
    """Return the least share of determined reactions within bounds, and that of determined."""
    truth = cycle(peg.name)
    told = (truth.mode == "three_point") & truth.known & (truth.t_ns >= SETTLE_NS)
    runs = run_seeds(truth, range(FIRST_SEED, FIRST_SEED + peg.seeds))
    chosen = runs.determined & told
    error, stddev = (each[chosen][:, REACTIONS] for each in (runs.error, runs.stddev))
    slides = told & (truth.slip_speed.min(axis=1) > SLIDES)
    return {
        "covered": float(coverage(error, stddev).covered.min()),
        "determined": float(runs.determined[:, slides].mean()),
    }


def report(found, options) -> Report:
    """Return a row for each peg."""
    head = "peg", "determined and covered (limit 90 %)", "determined while it slides"
    rows = [(peg, percent(row["covered"]), percent(row["determined"])) for peg, row in found]
    return Report(table(head, rows))


FAMILY = Family(
    lambda options: [Member(name, name, options.seeds) for name in PEGS],
    score_member, report, seeds=4,
)  # fmt: skip
