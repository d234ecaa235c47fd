"""
Simulate closings through gamma0 in MuJoCo: another engine's contact for the scenes.

    pip install mujoco numpy
    python -m benchmarks.engines.mujoco_closings OUT.npz [--scenes 16]

made the traces that `python -m benchmarks scenes --mismatch` reads (MuJoCo 4.0.0); a scene takes
one to three minutes on a core. Engine, rim, holder and contacts are those of `mujoco_peg.py`:
nothing of this package is used. Contacts give, some 2 MN/m for each of the boxes that touch, and
nothing guides the peg in the hole. What is kept is what sensors and labels need: the pose at the
end of every millisecond, the mean wrench of the holder in it, and the mean normal forces.
"""

import argparse
from pathlib import Path

import mujoco_peg as engine
import numpy as np

SEED = 5_500
FIELDS = ("clearance", "friction", "mass", "closing", "slide", "slip", "press", "before")


def drawn(number):
    """Return what a scene draws, by name."""
    rng = np.random.default_rng([SEED, number])
    return {
        "clearance": float(np.exp(rng.uniform(np.log(2e-4), np.log(2e-3)))),
        "friction": rng.uniform(0.1, 0.3),
        "mass": rng.uniform(0.4, 1.0),
        "closing": float(np.exp(rng.uniform(np.log(0.1), np.log(0.4)))),
        "slide": rng.uniform(-0.3, 0.3),
        "slip": rng.choice((-1.0, 1.0)) * rng.uniform(1.0, 3.0),
        "press": rng.uniform(0.5e-3, 1.5e-3),
        # From the begin to where the commanded tilt is gamma0 [s].
        "before": rng.uniform(0.3, 0.4),
    }


def trace(number):
    """Return setting and rows of a scene, less the first 0.1 s, in which the press builds up."""
    setting = drawn(number)
    engine.d = engine.D - setting["clearance"]
    engine.FRICTION, engine.MASS = setting["friction"], setting["mass"]
    engine.PRESS = np.array([0.0, 0.0, -setting["press"]])
    gamma0 = np.arccos(engine.d / engine.D)
    start = gamma0 + setting["closing"] * setting["before"]
    rates = setting["closing"], setting["slide"], setting["slip"]
    table = engine.simulate(start, *rates, setting["before"] + 0.1)[100:]
    half = 0.5 * engine.WINDOW * engine.STEP
    q = table[:, 1:4] + half * table[:, 4:7]
    return setting, np.column_stack([q, table[:, 7:13], table[:, 19:22]])


def main():
    """Simulate what is missing, and write all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[1])
    parser.add_argument("out", type=Path)
    parser.add_argument("--scenes", type=int, default=16)
    args = parser.parse_args()
    stored = dict(np.load(args.out)) if args.out.exists() else {}
    args.out.parent.mkdir(parents=True, exist_ok=True)
    for number in range(args.scenes):
        if f"q_{number}" in stored:
            continue
        setting, rows = trace(number)
        stored[f"setting_{number}"] = np.array([setting[name] for name in FIELDS])
        # Angles need their digits; forces are good to 1e-6 as they are.
        stored[f"q_{number}"] = rows[:, :3]
        stored[f"rest_{number}"] = rows[:, 3:].astype(np.float32)
        np.savez_compressed(args.out, **stored)
        gamma0 = np.arccos(1 - setting["clearance"] / engine.D)
        print(f"{number}: gamma - gamma0 {rows[0, 0] - gamma0:.4f} to {rows[-1, 0] - gamma0:.4f}, "
              f"mean N {rows[:, 9:].mean(axis=0).round(1)}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
