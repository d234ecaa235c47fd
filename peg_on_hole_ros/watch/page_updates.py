"""What a page gets twenty times a second: lines with peaks, modes, alarms, causes, one moment."""

from collections import deque
from math import isfinite
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.storage.fixed_layouts import NO_LAYOUT, Layouts
from peg_on_hole_ros.bags.storage.message_rows import MessageRows
from peg_on_hole_ros.config.node_parts import NODE
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.decode import JOINTS_TYPE
from peg_on_hole_ros.plots.turns import turn_stddev
from peg_on_hole_ros.records import ALARM_LEVELS, ANGLES, CONTACTS
from peg_on_hole_ros.report.drawing import moving
from peg_on_hole_ros.report.words import parts_of

# Read whole; of the other topics the last message serves.
WHOLE = ("state", "contacts", "monitor")
RISKS = ("jamming_risk", "transition_probability")
DIAGNOSTICS_TOPIC = "/diagnostics"
# Kept for a page that is opened, or comes back [s].
HISTORY = 30.0
_MOST_KEPT = 2000
# Stamps that fall by more begin anew [ns].
_NEW_STAMPS_NS = 1_000_000


class PageUpdates:
    """
    Makes frames of what has arrived; time is that of the stamps since the first.

    Parameters
    ----------
    name : str
        Full name of the node, as in /cell/peg_on_hole: `/diagnostics` has those of others too.

    Attributes
    ----------
    kept : deque of dict
        The frames of the last `HISTORY` seconds.

    """

    def __init__(self, name: str = f"/{NODE}") -> None:
        self._prefix = f"{name.strip('/')}: "
        self.kept: deque[dict] = deque(maxlen=_MOST_KEPT)
        self._readers = {topic: Reader() for topic in WHOLE}
        # The newest of each.
        self._tables: dict[str, Table] = {}
        self._begun_ns: int | None = None
        self._last_ns = 0
        self._mode: str | None = None
        self._levels: dict[str, int] = {}

    def frame(self, arrived: dict[str, list], latest: dict[str, object], scene: Scene) -> dict:
        """
        Return a frame, ready for JSON; without `t` where no estimate has arrived.

        Parameters
        ----------
        arrived : dict of str to list
            Of the topics in WHOLE all messages since the last frame, serialised; of
            `contact_mode`, `alarms` and `/diagnostics` all, as messages.
        latest : dict of str to message
            Of the other topics the last one.
        scene : Scene
            As the node has it.

        """
        read = ((topic, self._readers[topic].table(arrived[topic])) for topic in WHOLE)
        tables = {topic: table for topic, table in read if table is not None}
        frame: dict = {}
        state = tables.get("state")
        if state is not None:
            if self._begun_ns is None or state.t_ns[-1] < self._last_ns - _NEW_STAMPS_NS:
                self.kept.clear()
                self._tables.clear()
                self._begun_ns, frame["anew"] = int(state.t_ns[0]), True
            self._last_ns = int(state.t_ns[-1])
        told = bool(tables) and self._begun_ns is not None
        if told:
            # Of one wrench the others may arrive after its state, in a frame of their own.
            self._tables |= tables
            frame |= {"t": self._passed(self._last_ns), "lines": self._lines(tables)}
        self._declare(frame, arrived)
        if told:
            frame["moment"] = self._moment_of(self._tables, latest, scene)
            self._keep(frame)
        return frame

    def _passed(self, t_ns):
        return round((t_ns - self._begun_ns) * 1e-9, 4)

    def _lines(self, tables):
        lines = {}
        for topic, names, of in (
            ("state", ANGLES[:1], lambda table: table.positions),
            ("contacts", CONTACTS, lambda table: table.efforts),
            ("monitor", RISKS, lambda table: table.positions),
        ):
            table = tables.get(topic)
            if table is None:
                continue
            t = (table.t_ns - self._begun_ns) * 1e-9
            lines |= {name: peaks(t, of(table)[name]) for name in names if name in of(table)}
        return lines

    def _declare(self, frame, arrived):
        t = frame.get("t", self._passed(self._last_ns) if self._begun_ns else 0.0)
        for message in arrived["contact_mode"]:
            self._mode = message.data
            frame.setdefault("modes", []).append([t, message.data])
        if frame.get("anew") and "modes" not in frame and self._mode:
            frame["modes"] = [[t, self._mode]]
        for message in arrived["alarms"]:
            listed = []
            for status in message.status:
                level = _number_of(status.level)
                entry = {"name": status.name, "level": _level(level), "said": status.message}
                listed.append(entry)
                if level > self._levels.get(status.name, 0):
                    rise = {"t": t, "name": status.name, "level": _level(level)}
                    frame.setdefault("rises", []).append(rise)
                self._levels[status.name] = level
            frame["alarms"] = listed
        for message in arrived.get(DIAGNOSTICS_TOPIC, ()):
            own = [each for each in message.status if each.name.startswith(self._prefix)]
            if own:
                frame["causes"] = self._causes(own)

    def _causes(self, statuses):
        """Return what is wrong by `/diagnostics`, in its parts, errors first."""
        found = []
        for status in sorted(statuses, key=lambda each: -_number_of(each.level)):
            if not (level := _number_of(status.level)):
                continue
            cause = parts_of(status.message)
            found.append(
                {
                    "about": status.name.removeprefix(self._prefix),
                    "level": _level(level),
                    "headline": cause.what,
                    "lines": [part for part in cause[1:] if part],
                }
            )
        return found

    def _moment_of(self, tables, latest, scene):
        moment = {"t": np.array([self._passed(self._last_ns)])}
        state, contacts, monitor = (tables.get(topic) for topic in WHOLE)
        angles = {name: state.positions.get(name, np.array([np.nan]))[-1:] for name in ANGLES}
        moment |= angles
        pose = latest.get("pose")
        place = pose.pose.pose.position if pose else None
        told = {axis: getattr(place, axis) if place else np.nan for axis in "xyz"}
        turns = latest.get("state_stddev")
        spread_of_turns = dict(zip(turns.name, turns.position)) if turns else {}
        for name in ANGLES[1:]:
            told[f"{name}_stddev"] = turn_stddev(spread_of_turns.get(name, np.nan))
        spread = latest.get("contacts_stddev")
        stddev = dict(zip(spread.name, spread.effort)) if spread else {}
        for name in CONTACTS:
            message = latest.get(f"contact/{name.lower()}")
            force = message.wrench.force if message else None
            for axis in "xyz":
                value = getattr(force, axis) if force else np.nan
                told[f"{axis.upper()}_{name}"] = value
            told[f"{name}_stddev"] = stddev.get(name, np.nan)
            told[name] = contacts.efforts[name][-1] if _has(contacts, name) else np.nan
            told[f"{name}_closed"] = (
                contacts.positions[name][-1] if _has(contacts, name) else np.nan
            )
        for name in ("friction", "jamming_risk"):
            has = monitor is not None and name in monitor.positions
            told[name] = monitor.positions[name][-1] if has else np.nan
        moment |= {name: np.array([value], float) for name, value in told.items()}
        return {name: _number(column[0]) for name, column in moving(moment, scene).items()}

    def _keep(self, frame):
        self.kept.append(frame)
        while frame["t"] - self.kept[0]["t"] > HISTORY:
            gone = self.kept.popleft()
            # The mode that holds from before the first frame on.
            if gone.get("modes") and "modes" not in self.kept[0]:
                self.kept[0]["modes"] = [[gone["t"], gone["modes"][-1][1]]]


def _has(contacts, name):
    return contacts is not None and name in contacts.efforts


def _number_of(level):
    return level[0] if isinstance(level, bytes) else level


def _level(number):
    return ALARM_LEVELS[min(number, len(ALARM_LEVELS) - 1)]


def _number(value):
    return float(f"{value:.6g}") if isfinite(value) else None


class Table(NamedTuple):
    """
    Joint states of one topic, with the names of the last.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    positions, efforts : dict of str to ndarray, shape (n,)
        By name; without efforts empty.

    """

    t_ns: np.ndarray
    positions: dict[str, np.ndarray]
    efforts: dict[str, np.ndarray]


class Reader:
    """Reads the joint states of one topic."""

    def __init__(self) -> None:
        self._layouts = Layouts(efforts=True)

    def table(self, payloads: list[bytes]) -> Table | None:
        """Return messages of the last one's layout as columns; None where it has none."""
        if not payloads:
            return None
        ends = np.cumsum([len(payload) for payload in payloads])
        starts = ends - [len(payload) for payload in payloads]
        none = np.zeros(len(payloads), np.int64)
        rows = MessageRows(b"".join(payloads), none, none, starts, ends)
        found = self._layouts.columns(JOINTS_TYPE, rows)
        which = found.layout == found.layout[-1]
        if found.layout[-1] == NO_LAYOUT:
            return None
        layout = self._layouts.all[int(found.layout[-1])]
        values = found.values[which]
        effort = values[:, layout.width :] if layout.efforts else values[:, :0]
        return Table(
            found.t_ns[which],
            dict(zip(layout.names, values.T)),
            dict(zip(layout.names, effort.T)),
        )


def peaks(t: np.ndarray, values: np.ndarray) -> list[list[float | None]]:
    """
    Return the points of a line that are worth drawing: least, greatest and last, in order.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times [s].
    values : ndarray, shape (n,)
        NaN where there is none: a last one stays, as a gap, with None in its place.

    """
    kept = {len(values) - 1}
    known = np.flatnonzero(np.isfinite(values))
    if len(known):
        kept |= {int(known[values[known].argmin()]), int(known[values[known].argmax()])}
    return [
        [round(float(t[i]), 4), float(f"{values[i]:.6g}") if np.isfinite(values[i]) else None]
        for i in sorted(kept)
    ]
