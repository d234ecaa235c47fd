"""
Make the bags of robot cells, or the URDFs of their arms.

    pip install mujoco
    python -m benchmarks.robot_cells bags ur_like franka_like iiwa_like
    python -m benchmarks.robot_cells urdf

made `bags/cell_*.mcap` (MuJoCo 4.0.0, a minute each) and `config/cell_*.urdf`. Truth is the
engine's: pose and rates of the peg in the hole, and the normal forces at rim and edge.
"""

import argparse
from functools import partial
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.robot_cells import sensing
from benchmarks.robot_cells.arms import ARMS, urdf
from benchmarks.robot_cells.rows import GAMMA0, Rows
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, STRING, WRENCH, joint_state
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.records import ANGLES, CONTACTS

START_NS = 1_767_225_600_000_000_000
# Above it a contact carries load, and a mode that lasts shorter is none [N], [ms].
LOADED, SHORTEST = 0.3, 15


class Cell(NamedTuple):
    """
    A robot cell whose bag is shipped.

    Attributes
    ----------
    driver : Driver
        How the robot sends.
    period : float
        Of its controller [s].
    describes : bool
        Whether it sends its URDF.
    parts : dict
        What differs from `cell.Setting`.

    """

    driver: sensing.Driver
    period: float
    describes: bool
    parts: dict[str, float] = {}


# Loads do not rattle with a third of the damping.
CHAMFERED = {"damping": 2e3, "hole_chamfer": 3e-4, "peg_chamfer": 5e-4}
CELLS = {
    "ur_like": Cell(sensing.UR_LIKE, 2e-3, False),
    "ur_like_base": Cell(sensing.UR_LIKE_BASE, 2e-3, False),
    "franka_like": Cell(sensing.FRANKA_LIKE, 1e-3, True),
    "iiwa_like": Cell(sensing.IIWA_LIKE, 1e-3, False),
    "iiwa_like_chamfers": Cell(sensing.IIWA_LIKE, 1e-3, False, CHAMFERED),
}


def arm_of(name: str) -> str:
    """Return the name of a cell's arm."""
    return name.removesuffix("_base").removesuffix("_chamfers")


def modes(rows, gamma0: float) -> np.ndarray:
    """Return the contact mode of each row, as the engine's loads tell it."""
    loaded = rows.normal > LOADED
    above, some = rows.q[:, 0] > gamma0, loaded.any(axis=1)
    found = np.where(some, "unknown", "open").astype(object)
    found[loaded.all(axis=1) & above] = "three_point"
    found[loaded[:, 0] & loaded[:, 1:].any(axis=1) & ~above] = "two_point"
    begin = 0
    for k in range(1, len(found) + 1):
        if k == len(found) or found[k] != found[begin]:
            if k - begin < SHORTEST and begin:
                found[begin:k] = found[begin - 1]
            begin = k
    return found


def write(path: Path, rows, name: str, configuration=None, driver=None, thin: int = 1) -> None:
    """
    Write the bag of a cell; what is not given is that of the shipped one.

    `thin`: of the messages, each so manieth is written; all truth is that of its stamps.
    """
    arm, driver = ARMS[arm_of(name)], driver or CELLS[name].driver
    sent, mode = sensing.sent(rows, arm, driver), modes(rows, GAMMA0)
    # Over the time of a message, as its wrench is.
    loads = np.stack([rows.normal[sent.rows - k] for k in range(driver.every)]).mean(axis=0)
    told = None
    configuration = configuration or load(f"config/cell_{name}.yaml")[0]
    with BagWriter(path, configuration, latched=["/robot_description"]) as bag:
        if CELLS[name].describes:
            bag.write("/robot_description", STRING, {"data": urdf(arm)}, START_NS)
        messages = zip(sent.rows, sent.wrench, sent.joints, loads)
        for k, wrench, joints, carried in islice(messages, 0, None, thin):
            t_ns = START_NS + round(rows.t[k] * 1e9)
            state = joint_state(t_ns, arm.joints, joints.round(9), frame="base_link")
            bag.write("/joint_states", JOINT_STATE, state, t_ns)
            # As a sensor has them, not all the digits of a double.
            sides = {"force": xyz(wrench[:3].round(4)), "torque": xyz(wrench[3:].round(6))}
            fields = {"header": header(t_ns, driver.frame), "wrench": sides}
            bag.write("/wrench", WRENCH, fields, t_ns)
            truth = joint_state(t_ns, ANGLES, rows.q[k].round(9), rows.rates[k].round(6))
            bag.write("/truth/state", JOINT_STATE, truth, t_ns)
            if mode[k] in ("three_point", "open"):
                normal = carried.round(4) if mode[k] == "three_point" else np.zeros(3)
                closed = np.full(3, float(mode[k] == "three_point"))
                contacts = joint_state(t_ns, CONTACTS, closed, (), normal)
                bag.write("/truth/contacts", JOINT_STATE, contacts, t_ns)
            if mode[k] != told:
                told = mode[k]
                bag.write("/truth/contact_mode", STRING, {"data": told}, t_ns)


def _rows(folder, name, run):
    """Return the engine's rows, from a file where it is there."""
    path = None if folder is None else folder / f"{name}.npz"
    if path is not None and path.exists():
        return Rows(**np.load(path))
    rows = run()
    if path is not None:
        np.savez(path, **rows._asdict())
    return rows


def main():
    """Make what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[1])
    parser.add_argument("what", choices=("bags", "urdf"))
    parser.add_argument("names", nargs="*", choices=[*ARMS, []])
    parser.add_argument("--out", type=Path, default=Path())
    parser.add_argument("--rows", type=Path, help="folder for what the engine gave, or has given")
    arguments = parser.parse_args()
    for name in arguments.names or ARMS:
        arm = ARMS[name]
        if arguments.what == "urdf":
            path = arguments.out / "config" / f"cell_{name}.urdf"
            path.write_text(urdf(arm), encoding="utf-8")
            continue
        from benchmarks.robot_cells.cell import Setting, run

        given = {}
        for each in (cell for cell in CELLS if arm_of(cell) == name):
            parts, period = CELLS[each].parts, CELLS[each].period
            of = each if parts else name
            if of not in given:
                simulate = partial(run, arm, period, setting=Setting(**parts))
                given[of] = _rows(arguments.rows, of, simulate)
            path = arguments.out / "bags" / f"cell_{each}.mcap"
            write(path, given[of], each)
            print(f"{path}: {path.stat().st_size / 1e6:.2f} MB", flush=True)


if __name__ == "__main__":
    main()
