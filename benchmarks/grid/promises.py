"""
Bounds of other pegs, and a friction that is stated wrong beside another checkout's.

    python -m benchmarks.grid.promises [--part pegs friction] [--seeds 4] [--against CHECKOUT]

`pegs`: whole cycles of pegs that no setting was chosen on, friction drawn and learnt; which share
of the reactions that are called determined lies within 95 % bounds, of K, B1 and B2 the least, and
which share of the samples that slide is called determined. `friction`: motions of
`wrong_settings`, friction stated a half and one and a half of what it is; when it comes within 5 %
to stay, over the other checkout's time (a run that never does counts as its duration), and the
share of the runs in which it is off by more than four of its deviations at any time after 50 ms.
"""

import argparse
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.grid.cells import truth_of, with_noise
from benchmarks.grid.player import Elsewhere, play
from benchmarks.grid.score import INTERVAL, REACTIONS, SETTLE_NS, changed_parameters, run_seeds
from benchmarks.grid.wrong_settings import FRICTION, LEARNT, STATED, with_scene
from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate

FIRST_SEED = 650_000
NEAR, SURE = 0.05, 4.0
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


def of_peg(name, seeds):
    """Return the least share of determined reactions within bounds, and that of determined."""
    truth = cycle(name)
    told = (truth.mode == "three_point") & truth.known & (truth.t_ns >= SETTLE_NS)
    runs = run_seeds(truth, seeds)
    inside = np.abs(runs.error) <= INTERVAL * runs.stddev
    covered = inside[runs.determined & told][:, REACTIONS]
    slides = told & (truth.slip_speed.min(axis=1) > SLIDES)
    share = covered.mean(axis=0).min() if len(covered) else np.nan
    return float(share), float(runs.determined[:, slides].mean())


def found_at(truth, told, seed, player):
    """Return when friction is near to stay [s], and whether it was surely wrong after 50 ms."""
    right = truth.plan.configuration.scene.friction
    parameters = changed_parameters(told.plan.configuration)
    samples = list(map(tuple, measure(truth, seed)))
    found = player(parameters, samples, START_NS + SETTLE_NS)
    value, stddev = found["friction"].T
    off, t = np.abs(value - right), (found["t_ns"] - START_NS) * 1e-9
    far = np.flatnonzero(~(off <= NEAR * right))
    begun = t >= SETTLE_NS * 1e-9
    first = t[0] if not far.size else t[min(far[-1] + 1, len(t) - 1)]
    return float(first), bool((off > SURE * stddev)[begun].any())


def of_friction(seeds, players):
    """Return of each player the times and which runs were surely wrong, arrays over runs."""
    found = [[] for _ in players]
    for motion in FRICTION:
        truth = with_noise(truth_of(motion)[0], "nominal", LEARNT)
        right = truth.plan.configuration.scene.friction
        for start, seed in product(STATED, seeds):
            # The truth is within two stated deviations.
            told = with_scene(
                truth, friction=start * right, friction_stddev=max(LEARNT, 0.25 * right)
            )
            for rows, player in zip(found, players):
                rows.append(found_at(truth, told, seed, player))
    return [np.array(rows).T for rows in found]


def main(arguments=None):
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--part", nargs="+", choices=("pegs", "friction"))
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--against", type=Path, help="another checkout")
    options = parser.parse_args(arguments)
    seeds, parts = range(FIRST_SEED, FIRST_SEED + options.seeds), options.part
    if parts is None or "pegs" in parts:
        print("| peg | determined and covered (limit 90 %) | determined while it slides |")
        print("|---|---|---|")
        for name in PEGS:
            covered, determined = of_peg(name, seeds)
            print(f"| {name} | {100 * covered:.0f} % | {100 * determined:.0f} % |", flush=True)
    if parts is None or "friction" in parts:
        players = [play] + ([Elsewhere(options.against).play] if options.against else [])
        found = of_friction(seeds, players)
        print("| friction a half, one and a half | this | other | limit |\n|---|---|---|---|")
        times = [f"{np.median(t):.3f}" for t, _ in found] + [""] * (2 - len(found))
        sure = [f"{100 * s.mean():.1f} %" for _, s in found] + [""] * (2 - len(found))
        print(f"| median time until within 5 % [s] | {' | '.join(times)} | |")
        if options.against:
            ratio = np.exp(np.mean(np.log(found[0][0] / found[1][0])))
            print(f"| geometric mean of the times' ratio | {ratio:.2f} | 1 | 1.5 |")
        print(f"| runs off by more than 4 deviations | {' | '.join(sure)} | 1 % |")


if __name__ == "__main__":
    main()
