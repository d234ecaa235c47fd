"""What may be wrong of a cell, one thing at a time: settings, and what is sent."""

import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.own_cells.cells import Cell
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of

Change = Callable[[Cell], Cell]


class Wrong(NamedTuple):
    """
    One thing that is wrong.

    Attributes
    ----------
    change : callable
        Returns the cell with it.
    named : str
        A regular expression of what names it.
    value : callable
        Returns the number that the line with it has to tell, of the right cell; None: none.
    within : float
        How far off that may be.
    exits : tuple of int
        Exit codes that are right.
    must : bool
        Whether reactions have to be withheld where it is not named.

    """

    change: Change
    named: str
    value: Callable[[Cell], float] | None = None
    within: float = 0.0
    exits: tuple[int, ...] = (0,)
    must: bool = True


def stated(**values) -> Change:
    """Return the change of settings, by group__name; None takes one out, a callable changes it."""

    def change(cell):
        parameters = dict(cell.parameters)
        for key, value in values.items():
            key = key.replace("__", ".")
            if value is None:
                parameters.pop(key, None)
            else:
                parameters[key] = value(parameters[key]) if callable(value) else value
        return cell._replace(parameters=parameters)

    return change


def _turned(rpy, by, first=False):
    R, turn = rotation_from_rpy(rpy), rotation_from_rpy(by)
    return list(rpy_of(turn @ R if first else R @ turn))


def _sign(cell):
    acts = {"peg": "robot", "robot": "peg"}[str(cell.parameters["wrench.acts_on"])]
    return stated(wrench__acts_on=acts)(cell)


def _axes(cell):
    axes = "base" if cell.parameters["wrench.axes"] == "sensor" else "sensor"
    return stated(wrench__axes=axes)(cell)


def _tool_behind(cell):
    return stated(joints__tip_frame="l6")(cell)


def _clearance(times):
    def change(cell):
        D, d = (float(cell.parameters[f"scene.{of}_diameter"]) for of in ("hole", "peg"))
        return stated(scene__peg_diameter=D - times * (D - d))(cell)

    return change


def clearance_of(cell: Cell) -> float:
    """Return the clearance [mm]."""
    D, d = (float(cell.parameters[f"scene.{of}_diameter"]) for of in ("hole", "peg"))
    return 1e3 * (D - d)


def _exchanged_diameters(cell):
    D, d = (cell.parameters[f"scene.{of}_diameter"] for of in ("hole", "peg"))
    return stated(scene__hole_diameter=d, scene__peg_diameter=D)(cell)


def _wrenches(force: float, torque: float) -> Change:
    factors = np.repeat([force, torque], 3)
    return lambda cell: cell._replace(wrench=cell.wrench * factors)


def _jump(cell):
    after = cell.truth.t_ns > 3_300_000_000
    off = np.outer(after, [0.0, 0.0, 8.0, 0.0, 0.0, 0.0])
    return cell._replace(wrench=cell.wrench + off)


def _joints(change) -> Change:
    return lambda cell: cell._replace(joints=change(cell.joints.copy()))


def _exchanged_joints(q):
    return q[:, [0, 2, 1, 3, 4, 5]]


def _zero_off(q):
    return q + np.array([0.0, 0.0, 0.0, 0.0, 0.035, 0.0])


def _late(seconds: float) -> Change:
    return lambda cell: cell._replace(late=seconds)


def _peg_mass(factor):
    return stated(scene__peg_mass=lambda mass: factor * mass)


_PEG = r"peg_rpy|hole_rpy"
_MASS = r"peg_mass|payload"
_LATE = r"joints\.delay: (-?[0-9.]+)"
_CLEARANCE = r"hole_diameter - peg_diameter.*?([0-9.]+) mm"

WRONG: dict[str, Wrong] = {
    "sign": Wrong(_sign, r"acts_on"),
    "axes": Wrong(_axes, r"wrench\.axes"),
    "tip_frame": Wrong(_tool_behind, r"tip_frame|peg_xyz"),
    "peg_rpy_of_another_tool": Wrong(
        stated(joints__peg_rpy=lambda rpy: _turned(rpy, (0.0, np.pi / 2, 0.0))), r"peg_rpy",
        exits=(0, 3),
    ),
    "peg_rpy_half_a_turn": Wrong(
        stated(joints__peg_rpy=lambda rpy: _turned(rpy, (np.pi, 0.0, 0.0))), _PEG, exits=(3,)
    ),
    "peg_rpy_3_degrees": Wrong(
        stated(joints__peg_rpy=lambda rpy: _turned(rpy, (0.04, 0.034, 0.0))), _PEG
    ),
    "gravity_compensated": Wrong(stated(wrench__gravity="compensated"), r"wrench\.gravity"),
    "diameters_exchanged": Wrong(_exchanged_diameters, r"exchanged", exits=(2,)),
    "diameters_in_mm": Wrong(
        stated(scene__hole_diameter=lambda x: 1e3 * x, scene__peg_diameter=lambda x: 1e3 * x),
        r"units", exits=(2,),
    ),
    "clearance_2.5_times": Wrong(_clearance(2.5), _CLEARANCE, clearance_of, 0.02),
    "hole_axis_reversed": Wrong(
        stated(joints__hole_rpy=lambda rpy: _turned(rpy, (np.pi, 0.0, 0.0))), _PEG, exits=(3,)
    ),
    "hole_rpy_forgotten": Wrong(stated(joints__hole_rpy=[0.0, 0.0, 0.0]), r"hole_rpy"),
    "hole_rpy_one_sign": Wrong(
        stated(joints__hole_rpy=lambda rpy: [-rpy[0], rpy[1], rpy[2]]), r"hole_rpy"
    ),
    "hole_rpy_4_degrees": Wrong(
        stated(joints__hole_rpy=lambda rpy: _turned(rpy, (0.05, 0.05, 0.0))), r"hole_rpy"
    ),
    "gravity_forgotten": Wrong(stated(scene__gravity=None), r"scene\.gravity", must=False),
    "peg_mass_times_10": Wrong(_peg_mass(10.0), _MASS),
    "peg_mass_a_tenth": Wrong(_peg_mass(0.1), _MASS),
    "payload_forgotten": Wrong(stated(wrench__payload_mass=None, wrench__payload_com=None), _MASS),
    "payload_twice": Wrong(stated(wrench__payload_mass=lambda mass: 2.0 * mass), _MASS),
    "sensor_height_0": Wrong(stated(wrench__sensor_xyz=[0.0, 0.0, 0.0]), r"sensor_xyz"),
    "sensor_height_half": Wrong(
        stated(wrench__sensor_xyz=lambda xyz: [xyz[0], xyz[1], 0.5 * xyz[2]]), r"sensor_xyz"
    ),
    "friction_0.5": Wrong(stated(scene__friction=0.5), r"scene\.friction", must=False),
    "force_stddev_tenth": Wrong(
        stated(wrench__force_stddev=lambda x: 0.1 * x), r"force_stddev", must=False
    ),
    "kilonewtons": Wrong(_wrenches(1e-3, 1e-3), r"kN"),
    "torque_in_newton_millimetres": Wrong(_wrenches(1.0, 1e3), r"N mm"),
    "joints_exchanged": Wrong(
        # Joints with parallel axes: no angle changes by it.
        _joints(_exchanged_joints), r"joints\.names|place", exits=(0, 3), must=False
    ),
    "joints_in_degrees": Wrong(_joints(np.degrees), r"degrees", exits=(3,)),
    "joint_5_zero_2_degrees": Wrong(_joints(_zero_off), r"zero of a joint|peg_rpy|hole_rpy"),
    "joints_10_ms_late": Wrong(_late(0.010), _LATE, lambda cell: 0.010, 0.003),
    "joints_20_ms_late": Wrong(_late(0.020), _LATE, lambda cell: 0.020, 0.004),
    "joints_30_ms_late": Wrong(_late(0.030), _LATE, lambda cell: 0.030, 0.005),
    "joint_clock_5_s": Wrong(_late(5.0), r"clocks", exits=(3,)),
    "zero_jumps_8_N": Wrong(_jump, r"zero"),
}  # fmt: skip


def names(wrong: Wrong, cell: Cell, line: str) -> bool:
    """Return whether a line names what is wrong, with the number that it has to have."""
    found = re.search(wrong.named, line)
    if found is None or wrong.value is None:
        return found is not None
    told = found.group(1) if found.groups() else None
    return told is not None and abs(float(told) - wrong.value(cell)) <= wrong.within
