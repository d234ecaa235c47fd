"""Read estimates back from a bag of outputs, one row for each stamp."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.edges.bags.reader import Bag
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.records import ANGLES, CONTACTS

PREFIX = "/peg_on_hole/"  # of a replay, and of a node that is not renamed
JOINT_STATE = "sensor_msgs/msg/JointState"
_STAMPED = {
    "state": JOINT_STATE,
    "state_stddev": JOINT_STATE,
    "contacts": JOINT_STATE,
    "contacts_stddev": JOINT_STATE,
    "monitor": JOINT_STATE,
}
_LATCHED = {"transition": "std_msgs/msg/Bool", "contact_mode": "std_msgs/msg/String"}
# Stamps whose parts a recorder may have mixed, or lost: none is waited for longer than this.
_MOST_PENDING = 1000

# Name, unit and whether it is an angle that wraps; the order of a row's values.
QUANTITIES = (
    *((name, "rad", name != "gamma") for name in ANGLES),
    *((f"d{name}/dt", "rad/s", False) for name in ANGLES),
    *((f"N_{name}", "N", False) for name in CONTACTS),
    *((f"slip_{name}", "m/s", False) for name in CONTACTS),
)


class Estimate(NamedTuple):
    """
    One stamp of an output.

    Attributes
    ----------
    t_ns : int
        [ns]
    values, stddev : ndarray, shape (12,)
        In the order of QUANTITIES.
    monitor : dict of str to float
    mode : str
        Contact mode that holds; empty before the first.
    transition : bool or None

    """

    t_ns: int
    values: np.ndarray
    stddev: np.ndarray
    monitor: dict[str, float]
    mode: str
    transition: bool | None


def estimates(bag: Bag, name: str | None = None) -> Iterator[Estimate]:
    """
    Yield estimates in order of the bag, by the stamps of their messages.

    A recorder may mix the topics of neighbouring stamps; stamps that lack a part are left out.

    Parameters
    ----------
    bag : Bag
    name : str, optional
        Of the node with its namespace, such as `/cell/peg_on_hole`; without, the only one there.

    Raises
    ------
    BagError
        The bag holds no output of this package, none of this name, or of several without a name;
        or a stamp has not the values of QUANTITIES.

    """
    prefix = _prefix(bag, name)
    try:
        bag.require({prefix + suffix: ros_type for suffix, ros_type in _STAMPED.items()})
    except BagError as error:
        raise BagError(f"no output of replay or node: {error}") from None
    pending: dict[int, dict] = {}
    complete: list[tuple[int, dict]] = []
    mode, transition = "", None
    for topic, _, message in bag.messages([prefix + part for part in (*_STAMPED, *_LATCHED)]):
        part = topic.removeprefix(prefix)
        if part in _LATCHED:
            mode, transition = _latched(part, message.data, mode, transition)
            continue
        t_ns = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        if t_ns not in pending:
            # What is published on change follows its estimate, so an estimate waits for the next.
            yield from (_estimate(bag, *item, mode, transition) for item in complete)
            complete.clear()
            pending[t_ns] = {}
            if len(pending) > _MOST_PENDING:
                del pending[next(iter(pending))]
        pending[t_ns][part] = message
        if len(pending[t_ns]) == len(_STAMPED):
            complete.append((t_ns, pending.pop(t_ns)))
    yield from (_estimate(bag, *item, mode, transition) for item in complete)


def _prefix(bag, name):
    """Return what all topics of an output begin with, from the pairs of state and monitor."""
    pairs = ((t.removesuffix("state"), t) for t in sorted(bag.topics) if t.endswith("/state"))
    found = [
        prefix
        for prefix, topic in pairs
        if _has_joint_states(bag, topic) and _has_joint_states(bag, prefix + "monitor")
    ]
    if not found:
        return PREFIX  # for the error that says what is missing
    listed = " and ".join(prefix.rstrip("/") for prefix in found)
    if name is None:
        if len(found) > 1:
            raise BagError(f"{bag.path} has outputs under {listed}: choose one with --prefix")
        return found[0]
    prefix = f"/{name.strip('/')}/"
    if prefix not in found:
        raise BagError(f"{bag.path} has outputs under {listed}, not under {prefix.rstrip('/')}")
    return prefix


def _has_joint_states(bag, topic):
    info = bag.topics.get(topic)
    return info is not None and info.count > 0 and info.types == [JOINT_STATE]


def _latched(part, data, mode, transition):
    return (data, transition) if part == "contact_mode" else (mode, data)


def _estimate(bag, t_ns, parts, mode, transition):
    state, state_stddev = parts["state"], parts["state_stddev"]
    contacts, contacts_stddev = parts["contacts"], parts["contacts_stddev"]
    values = [*state.position, *state.velocity, *contacts.effort, *contacts.velocity]
    stddev = [
        *state_stddev.position,
        *state_stddev.velocity,
        *contacts_stddev.effort,
        *contacts_stddev.velocity,
    ]
    monitor = dict(zip(parts["monitor"].name, parts["monitor"].position))
    return Estimate(
        t_ns,
        _row(bag, t_ns, "state and contacts", values),
        _row(bag, t_ns, "state_stddev and contacts_stddev", stddev),
        monitor,
        mode,
        transition,
    )


def _row(bag, t_ns, topics, values):
    """Return one row; messages of the right types may still be another program's."""
    if len(values) != len(QUANTITIES):
        raise BagError(
            f"{bag.path} is no output of replay or node: {topics} of the stamp "
            f"{t_ns * 1e-9:.9f} s have {len(values)} values, not {len(QUANTITIES)}"
        )
    return np.array(values)
