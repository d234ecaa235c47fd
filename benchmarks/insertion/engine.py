"""
Insertions of the simulation against MuJoCo's, under the same holder and program.

The traces of `data/mujoco_insertions.npz` (see `mujoco_traces.py`) are simulated again here; how
far apart both are is told of tilt, depth, loads on rim and edge.
"""

from pathlib import Path

import numpy as np

from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.tables import table
from benchmarks.insertion import programs
from benchmarks.insertion.programs import PROGRAMS, plan_of
from peg_on_hole_ros.measurements.angles import angles_of
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.truth import integrate

TRACES = Path(__file__).parent / "data" / "mujoco_insertions.npz"
# The engine's peg taps on its contacts at the begin, until this [s].
AFTER = 0.05
# A wedge is squeezed until this; what then stays locked in hangs on the contacts [s].
LET_GO, LOCKED = 0.1, 0.2


def engine_rows(name: str, scene: Scene) -> dict[str, np.ndarray]:
    """
    Return a trace: t [s], tilt [rad], q (n, 3) [rad], depth [m], force and moment, rim, edge [N].

    Force and moment (n, 3) act at the mass centre, in the hole's axes [N], [N m].

    """
    with np.load(TRACES) as stored:
        pose, load = stored[f"pose_{name}"], stored[f"load_{name}"].astype(float)
    R = pose[:, 3:].reshape(-1, 3, 3)
    return {
        "t": 0.002 * np.arange(1, len(pose) + 1),
        "tilt": np.arctan2(np.hypot(R[:, 0, 2], R[:, 1, 2]), R[:, 2, 2]),
        "q": np.array([angles_of(each) for each in R]),
        "depth": scene.mass_center_height * R[:, 2, 2] - pose[:, 2],
        "force": load[:, :3],
        "moment": load[:, 3:6],
        "rim": load[:, 6],
        "edge": load[:, 7],
    }


def own_rows(plan) -> dict[str, np.ndarray]:
    """Return the same of the simulation: loads are means over the 2 ms before."""
    truth = integrate(plan)

    def mean(values):
        return (values[0:-2:2] / 2 + values[1:-1:2] + values[2::2] / 2) / 2

    return {
        "t": truth.t_ns[2::2] * 1e-9,
        "tilt": truth.q[2::2, 0],
        "depth": truth.place[2::2, 2],
        "force": mean(truth.force),
        "rim": mean(truth.normal[:, 0]),
        "edge": mean(truth.normal[:, 1:].sum(axis=1)),
    }


def differences(name: str, plan) -> dict[str, float]:
    """
    Return how far both are apart after AFTER, those that wedge until LET_GO.

    Largest of tilt [rad] and depth [m]; root mean square of rim and edge, and the mean of their
    difference, over their mean.

    """
    theirs, own = engine_rows(name, plan.configuration.scene), own_rows(plan)
    rows = theirs["t"] > AFTER
    if name == "wedges":
        rows &= theirs["t"] <= LET_GO
    found = {
        what: float(np.abs(theirs[what] - own[what])[rows].max()) for what in ("tilt", "depth")
    }
    for what in ("rim", "edge"):
        off = theirs[what][rows] - own[what][rows]
        mean = own[what][rows].mean()
        found[what] = float(np.sqrt((off**2).mean()) / mean)
        found[f"{what}_mean"] = float(off.mean() / mean)
    return found


def locked_in(rows: dict[str, np.ndarray]) -> tuple[float, float, float]:
    """
    Return what a wedge keeps.

    Returns
    -------
    share, change, moved : float
        The load of rim and edge after LOCKED over that before LET_GO; by how much of it that
        changes to the end; how far the peg goes meanwhile, pushed [m].

    """
    t, load = rows["t"], rows["rim"] + rows["edge"]
    squeezed, kept = load[t <= LET_GO].max(), load[t > LOCKED]
    depth = rows["depth"][t > LOCKED]
    return kept[0] / squeezed, kept[-1] / kept[0] - 1, np.ptp(depth)


def score_member(insertion: Member, folder: Path) -> dict:
    """Return how far both are apart, and of a wedge what each locks in."""
    plan = plan_of(insertion.name)
    found = differences(insertion.name, plan)
    if insertion.name == "wedges":
        theirs = engine_rows("wedges", plan.configuration.scene)
        both = {"MuJoCo": theirs, "own": own_rows(plan)}
        found["locked"] = {who: list(map(float, locked_in(rows))) for who, rows in both.items()}
    return found


def report(found, options) -> Report:
    """Return a row for each insertion, and what a wedge keeps."""
    rows, lines = [], []
    for insertion, row in found:
        loads = (f"{row[what]:.1%} rms, {row[f'{what}_mean']:+.1%}" for what in ("rim", "edge"))
        rows.append((insertion, f"{row['tilt'] * 1e6:.0f}", f"{row['depth'] * 1e6:.0f}", *loads))
        lines += [
            f"{who} locks {share:.1%} in, which changes by {change:+.1%}: {moved * 1e6:.1f} um"
            for who, (share, change, moved) in row.get("locked", {}).items()
        ]
    head = "insertion", "tilt [urad]", "depth [um]", "load on the rim", "on the edge"
    return Report("\n".join([table(head, rows), "", *lines]).rstrip())


FAMILY = Family(
    lambda options: [Member(name, name) for name in PROGRAMS],
    score_member, report, sources=(TRACES, programs),
)  # fmt: skip
