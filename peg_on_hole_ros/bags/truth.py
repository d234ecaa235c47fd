"""Truth of a simulated bag."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.storage.fixed_layouts import NO_LAYOUT
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, STRING
from peg_on_hole_ros.messages.passed_time import StampRun
from peg_on_hole_ros.records import ANGLES, CONTACTS

STATE_TOPIC = "/truth/state"
CONTACTS_TOPIC = "/truth/contacts"
MODE_TOPIC = "/truth/contact_mode"
TYPES = {STATE_TOPIC: JOINT_STATE, CONTACTS_TOPIC: JOINT_STATE, MODE_TOPIC: STRING}

BOUND_STDDEVS = 1.959963984540054  # of a standard normal: 95 % lie within
# A simulator is silent on reactions where its own model does not determine them.
UNKNOWN = (float("nan"),) * 3
THREE_POINT, TWO_POINT = "three_point", "two_point"


class RecordedTruth:
    """
    What a simulated bag says about itself, at its own stamps.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (n,)
        [ns], increasing.
    values : ndarray, shape (n, 6)
        gamma, psi, phi [rad], unwrapped, and the normal reactions at K, B1, B2 [N], NaN where they
        are not known. On two points B1 and B2 are each half of B, as in an estimate.
    mode_ns : ndarray of int64, shape (m,)
        When a contact mode begins [ns].
    modes : list of str, length m

    """

    def __init__(
        self,
        t_ns: ArrayLike,
        values: ArrayLike,
        mode_ns: ArrayLike = (),
        modes: Sequence[str] = (),
    ) -> None:
        self.t_ns = np.asarray(t_ns, dtype=np.int64)
        self.values = np.array(values, dtype=float)
        self.values[:, :3] = np.unwrap(self.values[:, :3], axis=0)
        self.mode_ns = np.asarray(mode_ns, dtype=np.int64)
        self.modes = list(modes)
        # In the hole the lower edge has one contact, which a simulator may give one name of two.
        two = np.array([False, *(mode == TWO_POINT for mode in self.modes)])
        in_hole = two[np.searchsorted(self.mode_ns, self.t_ns, side="right")]
        self.values[in_hole, 4:] = self.values[in_hole, 4:].mean(axis=1, keepdims=True)

    def at(self, t_ns: int) -> np.ndarray | None:
        """Return the six values at a stamp, linear between two; None outside of what is known."""
        i = int(np.searchsorted(self.t_ns, t_ns))
        if i == len(self.t_ns) or (i == 0 and self.t_ns[0] != t_ns):
            return None
        if self.t_ns[i] == t_ns:
            return self.values[i]
        before, after = int(self.t_ns[i - 1]), int(self.t_ns[i])
        share = (t_ns - before) / (after - before)
        return self.values[i - 1] + share * (self.values[i] - self.values[i - 1])

    def mode_at(self, t_ns: int) -> str:
        """Return the contact mode that holds at a stamp; empty before the first."""
        i = int(np.searchsorted(self.mode_ns, t_ns, side="right"))
        return self.modes[i - 1] if i else ""

    def mode_changes(self, runs: Iterable[StampRun]) -> list[tuple[int, str]]:
        """Return the passed time [ns] of each change of mode along stamps, and the mode."""
        changes = []
        for run in runs:
            changes.append((run.before_ns, self.mode_at(run.first_ns)))
            for t_ns, mode in zip(self.mode_ns.tolist(), self.modes):
                if run.first_ns < t_ns <= run.last_ns:
                    changes.append((run.passed(t_ns), mode))
        return changes

    def transitions_ns(self) -> list[int]:
        """Return when three-point contact became two-point contact [ns]."""
        pairs = zip(self.modes, self.modes[1:], self.mode_ns[1:])
        return [int(t) for old, new, t in pairs if (old, new) == (THREE_POINT, TWO_POINT)]


def read_truth(
    bag: Bag, progress: Callable[[float], None] = lambda share: None
) -> RecordedTruth | None:
    """
    Return the truth in a bag, or None where it has none.

    Parameters
    ----------
    bag : Bag
    progress : callable, optional
        Called with the share that was read.

    Raises
    ------
    BagError
        Topics of truth with other types or names, or only some of them.

    """
    if not any(topic in bag.topics for topic in TYPES):
        return None
    bag.require(TYPES)
    states, normals, modes = {}, {}, _Modes()
    total = sum(bag.topics[topic].count for topic in TYPES)
    count = 0
    for batch in bag.batches(TYPES, efforts=True):
        for topic, log_ns, read in _messages(bag, batch):
            if count % 256 == 0:
                progress(count / total)
            count += 1
            if topic == MODE_TOPIC:
                modes.declared(log_ns, read)
                continue
            t_ns, names, position, effort = read
            modes.stamped(log_ns, t_ns)
            if topic == STATE_TOPIC:
                states[t_ns] = _named(bag, topic, names, position, ANGLES)
            else:
                normals[t_ns] = _named(bag, topic, names, effort, CONTACTS)
    if not states.keys() & normals.keys():
        raise BagError(f"{bag.path}: {STATE_TOPIC} and {CONTACTS_TOPIC} have no stamp in common")
    t_ns = sorted(states)
    values = [[*states[t], *normals.get(t, UNKNOWN)] for t in t_ns]
    return RecordedTruth(t_ns, values, *zip(*modes.changes()))


def _messages(bag, batch):
    """Yield topic, log time [ns], and the mode, or stamp [ns], names, positions and efforts."""
    topics = list(batch.types)
    columns = batch.topic, batch.log_ns, batch.t_ns, batch.layout, batch.values
    rows = zip(*(column.tolist() for column in columns))
    for i, (topic, log_ns, t_ns, layout, values) in enumerate(rows):
        topic = topics[topic]
        if layout != NO_LAYOUT:
            found = batch.layouts[layout]
            efforts = values[found.width : 2 * found.width] if found.efforts else []
            yield topic, log_ns, (t_ns, found.names, values[: found.width], efforts)
            continue
        message = batch.others[i]
        try:
            if topic == MODE_TOPIC:
                yield topic, log_ns, message.data
                continue
            stamp = message.header.stamp
            t_ns = stamp.sec * 1_000_000_000 + stamp.nanosec
            yield topic, log_ns, (t_ns, message.name, message.position, message.effort)
        except AttributeError as error:
            raise BagError(
                f"{bag.path}: the definition of {topic} is another's ({error})"
            ) from None


class _Modes:
    """
    Gives each contact mode, which has no stamp, that of the state it was recorded with.

    Log times may be another clock's: those of a bag that was played and recorded anew. A mode
    stands before or behind its state, so the nearer of the two about it by log time is that.
    """

    def __init__(self):
        self._found: dict[int, str] = {}
        self._before: tuple[int, int] | None = None
        self._open: list[tuple[int, str]] = []

    def declared(self, log_ns, mode):
        self._open.append((log_ns, mode))

    def stamped(self, log_ns, t_ns):
        self._settle((log_ns, t_ns))
        self._before = log_ns, t_ns

    def _settle(self, behind):
        for log_ns, mode in self._open:
            about = [of for of in (self._before, behind) if of]
            self._found[min(about, key=lambda of: abs(of[0] - log_ns))[1]] = mode
        self._open.clear()

    def changes(self):
        """Return pairs of stamp [ns] and mode, where it is another than before."""
        self._settle(None)
        found = sorted(self._found.items())
        pairs = zip([None, *(mode for _, mode in found)], found)
        return [change for before, change in pairs if change[1] != before]


def _named(bag, topic, names, values, wanted):
    by_name = dict(zip(names, values))
    if not by_name.keys() >= set(wanted):
        raise BagError(
            f"{bag.path}: {topic} has values for {', '.join(by_name) or 'nothing'}, and truth "
            f"needs {', '.join(wanted)}"
        )
    return [by_name[name] for name in wanted]
