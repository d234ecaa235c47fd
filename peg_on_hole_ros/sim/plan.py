"""What is to be simulated, from a tree of parameters: holder, rates of the sensors, phases."""

import difflib
from dataclasses import dataclass
from math import isfinite

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.command import quintic
from peg_on_hole_ros.sim.plan_checks import check_motion, check_together

# Of steel on steel, about [N/m]: 100 N press 1 um in.
CONTACT_STIFFNESS = 1e8
PHASE_KINDS = {
    "free": "the holder guides the peg, nothing touches",
    "contact": "the peg moves on three contacts, the holder gives way",
    "lift_off": "as contact, until the contacts open; then as free",
    "two_point": "as contact, through the transition; then guided in the hole on two contacts",
    "parted": "as contact, until a contact opens; then on those left, which give a little",
    "insert": "into the hole and down it, on any contacts; the holder gives way",
}


@dataclass(frozen=True)
class Holder:
    """Compliance of the holder and what its robot stands."""

    stiffness: float = 2.0e4
    rotational_stiffness: float = 2.0e3
    damping_ratio: float = 0.7
    force_limit: float = 200.0
    torque_limit: float = 20.0


@dataclass(frozen=True)
class PlanPhase:
    """
    One named stretch of the holder's program.

    Attributes
    ----------
    name, kind : str
        The kind is one of `PHASE_KINDS`.
    duration : float
        [s]
    angles : tuple of 3 float or None
        gamma, psi, phi commanded at its end [rad]; None: where constant change between the rates
        at begin and end leads.
    rates : tuple of 3 float
        Commanded at its end [rad/s].
    offset : tuple of 3 float or None
        Of the commanded pose from the touching pose along h, e, z at its end [m]: up to be free,
        down to press; None: as before.
    load : tuple of 2 float or None
        two_point: normal reactions at K and at the wall at its end [N]; None: as before.
    friction : float or None
        Coulomb coefficient of all contacts from its begin on; None: as before, at first the
        scene's.
    depth : float or None
        insert: depth of the lower end's centre below the rim, commanded at its end [m]; None:
        where constant change between the rates at begin and end leads.
    depth_rate : float
        insert: commanded at its end [m/s].
    place : tuple of 2 float or None
        insert: x, y of the lower end's centre in hole axes, commanded at its end [m]; None: as
        before.

    """

    name: str
    kind: str
    duration: float
    angles: tuple[float, float, float] | None = None
    rates: tuple[float, float, float] = (0.0, 0.0, 0.0)
    offset: tuple[float, float, float] | None = None
    load: tuple[float, float] | None = None
    friction: float | None = None
    depth: float | None = None
    depth_rate: float = 0.0
    place: tuple[float, float] | None = None


@dataclass(frozen=True)
class Plan:
    """
    Everything that fixes a simulated truth and its measurement.

    Attributes
    ----------
    configuration : Configuration
        Of the estimator; scene, sensor pose, sign and noise are taken from it.
    holder : Holder
    start : PlanPhase
        Its angles, rates and offset are those at the beginning.
    phases : tuple of PlanPhase
    origin : str
        What the bag is, in words, for its metadata.
    seed : int
        Of the noise.
    wrench_rate, joint_rate : int
        [Hz]; the wrench's is a multiple of the joints'.
    lead_in : float
        Simulated before the recording begins [s].
    settle : float
        Time over which a guided motion takes over from a free one [s].
    slip_velocity_scale : float
        Of the regularised friction law [m/s].
    contact_stiffness : float
        Of one contact of an inserted or parted peg [N/m].
    rtol : float
        Relative tolerance of the integrator; the absolute is a hundredth of it.

    """

    configuration: Configuration
    holder: Holder
    start: PlanPhase
    phases: tuple[PlanPhase, ...]
    origin: str = ""
    seed: int = 1
    wrench_rate: int = 1000
    joint_rate: int = 500
    lead_in: float = 0.0
    settle: float = 0.03
    slip_velocity_scale: float = 1e-5
    contact_stiffness: float = CONTACT_STIFFNESS
    rtol: float = 1e-8


# name: (low, high, unit); what is not here is checked by its own rule.
_RANGES = {
    "stiffness": (1e2, 1e7, "N/m"),
    "rotational_stiffness": (1e-1, 1e6, "N m/rad"),
    "damping_ratio": (0.05, 5.0, ""),
    "force_limit": (1e-3, 1e5, "N"),
    "torque_limit": (1e-4, 1e4, "N m"),
    "lead_in": (0.0, 100.0, "s"),
    "settle": (1e-3, 1.0, "s"),
    "slip_velocity_scale": (1e-6, 1e-3, "m/s"),
    "rtol": (1e-12, 1e-5, ""),
    "contact_stiffness": (1e6, 1e11, "N/m"),
    "duration": (1e-3, 1000.0, "s"),
    "angles": (-1e3, 1e3, "rad"),
    "rates": (-100.0, 100.0, "rad/s"),
    "offset": (-0.1, 0.5, "m"),
    "load": (0.0, 1e5, "N"),
    "friction": (0.0, 2.0, ""),
    "depth": (-0.1, 10.0, "m"),
    "depth_rate": (-1.0, 1.0, "m/s"),
    "place": (-0.1, 0.1, "m"),
}
_REMEDY_BY_UNIT = {
    "rad": "angles are in radians: 10 degrees are 0.1745",
    "rad/s": "rates are in radians a second: 10 degrees a second are 0.1745",
    "s": "times are in seconds: 10 ms are 0.01",
    "m": "lengths are in metres: 1 mm is 0.001",
    "m/s": "speeds are in metres a second: 1 mm/s is 0.001",
}
_START = ("angles", "rates", "offset")
_LENGTHS = {"angles": 3, "rates": 3, "offset": 3, "load": 2, "place": 2}
_NUMBERS = ("duration", "friction", "depth", "depth_rate")
_TOP = ("origin", "seed", "wrench_rate", "joint_rate", "lead_in", "settle", "slip_velocity_scale")
_TOP += ("rtol", "contact_stiffness", "holder", "start", "phases")


def plan_from_tree(configuration: Configuration, tree: dict) -> Plan:
    """
    Return the plan of a parameters file's `simulation` part.

    Parameters
    ----------
    configuration : Configuration
    tree : dict
        Nested, as read; the phases in their order.

    Raises
    ------
    PegOnHoleError
        Unknown name, value out of range, or phases that do not fit together.

    """
    _known(tree, _TOP, "simulation")
    values = {}
    for name in ("lead_in", "settle", "slip_velocity_scale", "rtol", "contact_stiffness"):
        if name in tree:
            values[name] = _number(name, tree[name], f"simulation.{name}")
    for name, low, high in (
        ("seed", 0, 2**32 - 1),
        ("wrench_rate", 1, 10000),
        ("joint_rate", 1, 10000),
    ):
        if name in tree:
            value = tree[name]
            if type(value) is not int or not low <= value <= high:
                raise PegOnHoleError(
                    f"simulation.{name} = {value!r} is not an integer within {low} to {high}"
                )
            values[name] = value
    holder = tree.get("holder", {})
    _known(holder, Holder.__dataclass_fields__, "simulation.holder")
    holder = Holder(**{k: _number(k, v, f"simulation.holder.{k}") for k, v in holder.items()})
    start = tree.get("start", {})
    _known(start, _START, "simulation.start")
    start = _phase("start", {"kind": "free", "duration": 1.0, **start}, "simulation.start")
    if start.angles is None:
        raise PegOnHoleError(
            "simulation.start.angles is missing: gamma, psi, phi at the begin [rad]"
        )
    phases = tree.get("phases", {})
    if not isinstance(phases, dict) or not phases:
        raise PegOnHoleError(
            f"simulation.phases = {phases!r} is no group of phases: it has the name of at least "
            "one, with its kind and duration below it"
        )
    phases = tuple(_phase(k, v, f"simulation.phases.{k}") for k, v in phases.items())
    plan = Plan(
        configuration, holder, start, phases, origin=str(tree.get("origin", "")).strip(), **values
    )
    check_together(plan)
    check_motion(plan, *holder_program(plan))
    return plan


def _known(tree, names, where):
    if not isinstance(tree, dict):
        raise PegOnHoleError(f"{where} = {tree!r} is a value, but it is a group of names")
    for name in tree:
        if name not in names:
            near = difflib.get_close_matches(str(name), list(names), n=3, cutoff=0.5) or names
            raise PegOnHoleError(
                f"unknown parameter '{where}.{name}'; the nearest are: {', '.join(near)}"
            )


def _number(name, value, where):
    low, high, unit = _RANGES[name]
    unit = f" {unit}" if unit else ""
    if type(value) not in (int, float) or not isfinite(value) or not low <= value <= high:
        shown = f"{value!r}{unit}" if type(value) in (int, float) else repr(value)
        remedy = _REMEDY_BY_UNIT.get(unit.strip())
        raise PegOnHoleError(
            f"{where} = {shown} is not a number within {low:g} to {high:g}{unit}"
            + (f"; {remedy}" if remedy else "")
        )
    return float(value)


def _phase(name, tree, where):
    _known(tree, ("kind", *_NUMBERS, *_LENGTHS), where)
    kind = tree.get("kind")
    if not isinstance(kind, str) or kind not in PHASE_KINDS:
        raise PegOnHoleError(f"{where}.kind = {kind!r} is not one of {', '.join(PHASE_KINDS)}")
    if "duration" not in tree:
        raise PegOnHoleError(f"{where}.duration is missing [s]")
    values = {k: _number(k, tree[k], f"{where}.{k}") for k in _NUMBERS if k in tree}
    for key, length in _LENGTHS.items():
        if key in tree:
            value = tree[key]
            if not isinstance(value, list) or len(value) != length:
                raise PegOnHoleError(f"{where}.{key} = {value!r} is not {length} numbers")
            values[key] = tuple(
                _number(key, item, f"{where}.{key}[{i}]") for i, item in enumerate(value)
            )
    return PlanPhase(name, kind, **values)


def holder_program(plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the commanded motion as knots [s] and quintics, for `command.evaluate`.

    Returns
    -------
    knots : ndarray, shape (n + 1,)
    coefficients : ndarray, shape (n, 6, 6)

    """
    now = np.zeros((3, 6))
    now[0] = *plan.start.angles, *(plan.start.offset or (0.0, 0.0, 0.0))  # type: ignore[misc]
    now[1, :3] = plan.start.rates
    knots, pieces = [0.0], []
    for phase in plan.phases:
        end = np.zeros((3, 6))
        end[1, :3] = phase.rates
        mean = (now[1, :3] + end[1, :3]) / 2
        end[0, :3] = now[0, :3] + mean * phase.duration if phase.angles is None else phase.angles
        end[0, 3:] = now[0, 3:] if phase.offset is None else phase.offset
        pieces.append(quintic(now, end, phase.duration))
        knots.append(knots[-1] + phase.duration)
        now = end
    return np.array(knots), np.array(pieces)
