"""Read estimates back from a bag of outputs, one row for each stamp."""

from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.messages.beside_estimates import (
    DECLARED,
    JOINT_STATE,
    PREFIX,
    SMOOTHED,
    TOPICS,
    UNSTAMPED,
)
from peg_on_hole_ros.messages.published import LAYOUTS
from peg_on_hole_ros.monitor.output_row import OUTPUTS
from peg_on_hole_ros.records import ANGLES, CONTACTS

# What an estimate is made of, and what else bears a stamp.
_STAMPED = tuple(each.name for each in LAYOUTS.values() if each.ros_type == JOINT_STATE)
_ORDERED = "state"
_REST = {
    name: ros_type
    for name, ros_type in (TOPICS | SMOOTHED).items()
    if name not in (*_STAMPED, *UNSTAMPED)
}
# Stamps whose parts a recorder may have mixed, or lost: none is waited for longer than this.
_MOST_PENDING = 1000

# The outputs that are values of an estimate, each with its standard deviation, and what their
# numbers are called, by field of the message.
_READ = {
    "state": (ANGLES, tuple(f"d{name}/dt" for name in ANGLES)),
    "normal": (tuple(f"N_{name}" for name in CONTACTS),),
    "slip_speed": (tuple(f"slip_{name}" for name in CONTACTS),),
}
# Name, unit and whether it is an angle that wraps; the order of a row's values.
QUANTITIES = tuple(
    (name, unit, name in ANGLES and name != "gamma")
    for output, fields in _READ.items()
    for names, unit in zip(fields, OUTPUTS[output].unit.split(", "), strict=True)
    for name in names
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
    messages : dict of str to (bytes, object)
        Topic under the node's name to the message as it was recorded, and decoded.

    """

    t_ns: int
    values: np.ndarray
    stddev: np.ndarray
    monitor: dict[str, float]
    mode: str
    transition: bool | None
    messages: dict[str, tuple[bytes, Any]]


class Output:
    """
    Estimates in the order in which they were published.

    A recorder may mix the topics of neighbouring stamps, not the messages of one topic; stamps
    that lack a part of the estimate are left out, and counted.

    Parameters
    ----------
    bag : Bag
    name : str, optional
        Of the node with its namespace, such as `/cell/peg_on_hole`; without, the only one there.
    rest : bool
        Whether to read what is no part of the estimate, too: wrenches, pose, alarms, markers.

    Attributes
    ----------
    topics : list of str
        All that bear a stamp and are there, under the node's name.
    incomplete : int
        Stamps left out up to now.

    Raises
    ------
    BagError
        The bag holds no output of this package, none of this name, or of several without a name;
        or, later, a stamp has not the values of QUANTITIES.

    """

    def __init__(self, bag: Bag, name: str | None = None, rest: bool = False) -> None:
        self._bag = bag
        self._prefix = _prefix(bag, name)
        try:
            bag.require({self._prefix + part: JOINT_STATE for part in _STAMPED})
        except BagError as error:
            raise BagError(f"no output of replay or node: {error}") from None
        found = [part for part in _REST if _has(bag, self._prefix + part, _REST[part])]
        self.topics = [*_STAMPED, *(found if rest else ())]
        self.incomplete = 0

    def __iter__(self) -> Iterator[Estimate]:
        """Yield every estimate."""
        open_: dict[int, _Stamp] = {}
        begun: deque[_Stamp] = deque()
        waiting: deque[_Stamp] = deque()
        fresh: list[_Stamp] = []
        mode, transition = "", None
        self.incomplete = 0
        names = [self._prefix + part for part in (*self.topics, *DECLARED)]
        for (topic, _, message), payload in self._bag.with_payloads(names):
            part = topic.removeprefix(self._prefix)
            if part in DECLARED:
                mode, transition = _latched(part, message.data, mode, transition)
                continue
            t_ns = _stamp_of(message)
            if t_ns is None:
                continue
            one = open_.get(t_ns)
            # Where stamps repeat, a second message of a topic begins the stamp anew.
            if one is None or part in one.messages:
                # What is published on change follows its estimate, so one waits for the next.
                _declare(fresh, mode, transition)
                one = open_[t_ns] = _Stamp(t_ns)
                begun.append(one)
                if len(begun) > _MOST_PENDING:
                    yield from self._until(begun.popleft(), waiting, open_)
            one.messages[part] = payload, message
            if part == _ORDERED:
                waiting.append(one)
            if part in _STAMPED and one.complete():
                fresh.append(one)
        _declare(fresh, mode, transition)
        for one in begun:
            yield from self._until(one, waiting, open_)

    def _until(self, last, waiting, open_):
        """Give all that wait up to one of them, for which nothing more is waited."""
        while not last.ended:
            one = waiting.popleft() if _ORDERED in last.messages else last
            one.ended = True
            if open_.get(one.t_ns) is one:
                del open_[one.t_ns]
            if one.complete():
                yield _estimate(self._bag, one)
            else:
                self.incomplete += 1


class _Stamp:
    """What has come of one stamp."""

    def __init__(self, t_ns):
        self.t_ns = t_ns
        self.messages: dict[str, tuple[bytes, Any]] = {}
        self.mode, self.transition = "", None
        self.ended = False

    def complete(self):
        return all(part in self.messages for part in _STAMPED)


def _declare(fresh, mode, transition):
    for one in fresh:
        one.mode, one.transition = mode, transition
    fresh.clear()


def _stamp_of(message):
    """Return the stamp of a message [ns]; of markers each has it, so None where there are none."""
    bearers = getattr(message, "markers", [message])
    if not bearers:
        return None
    stamp = bearers[0].header.stamp
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def estimates(bag: Bag, name: str | None = None) -> Iterator[Estimate]:
    """Yield the estimates of an `Output`, without the rest."""
    return iter(Output(bag, name))


def same_message(a: tuple[bytes, Any] | None, b: tuple[bytes, Any] | None) -> bool:
    """Return whether two of an estimate's messages are the same in every bit of every field."""
    if a is None or b is None:
        return a is b
    # Where bytes differ it may be rubbish that fills a gap between fields, as ROS leaves it.
    return a[0] == b[0] or _exact(a[1]) == _exact(b[1])


def _exact(value):
    """Return a decoded message as text that keeps every bit."""
    if hasattr(value, "__slots__"):
        fields = (f"{name}: {_exact(getattr(value, name))}" for name in value.__slots__)
        return f"({', '.join(fields)})"
    return f"[{', '.join(map(_exact, value))}]" if isinstance(value, list) else repr(value)


def _prefix(bag, name):
    """Return what all topics of an output begin with, from the pairs of state and monitor."""
    pairs = ((t.removesuffix("state"), t) for t in sorted(bag.topics) if t.endswith("/state"))
    found = [
        prefix
        for prefix, topic in pairs
        if _has(bag, topic, JOINT_STATE) and _has(bag, prefix + "monitor", JOINT_STATE)
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


def _has(bag, topic, ros_type):
    info = bag.topics.get(topic)
    return info is not None and info.count > 0 and info.types == [ros_type]


def _latched(part, data, mode, transition):
    return (data, transition) if part == "contact_mode" else (mode, data)


def _estimate(bag, one):
    t_ns = one.t_ns
    told = one.messages["monitor"][1]
    return Estimate(
        t_ns,
        _row(bag, one, ""),
        _row(bag, one, "_stddev"),
        dict(zip(told.name, told.position)),
        one.mode,
        one.transition,
        one.messages,
    )


def _row(bag, one, end):
    """Return one row; messages of the right types may still be another program's."""
    outputs = [OUTPUTS[name + end] for name in _READ]
    values = []
    for output in outputs:
        for field in output.field.split():
            values += getattr(one.messages[output.topic][1], field)
    if len(values) != len(QUANTITIES):
        topics = " and ".join(dict.fromkeys(output.topic for output in outputs))
        raise BagError(
            f"{bag.path} is no output of replay or node: {topics} of the stamp "
            f"{one.t_ns * 1e-9:.9f} s have {len(values)} values, not {len(QUANTITIES)}"
        )
    return np.array(values)
