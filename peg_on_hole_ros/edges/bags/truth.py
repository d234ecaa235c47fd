"""Truth of a simulated bag, and how far estimates are from it."""

from collections.abc import Callable
from math import pi, sqrt

import numpy as np

from peg_on_hole_ros.edges.bags.reader import Bag
from peg_on_hole_ros.edges.messages.output import JOINT_STATE, STRING, Message
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.records import ANGLES, CONTACTS

STATE_TOPIC = "/truth/state"
CONTACTS_TOPIC = "/truth/contacts"
MODE_TOPIC = "/truth/contact_mode"
TYPES = {STATE_TOPIC: JOINT_STATE, CONTACTS_TOPIC: JOINT_STATE, MODE_TOPIC: STRING}

NAMES = (*ANGLES, *CONTACTS)
BOUND = 1.959963984540054  # of a standard normal: 95 % lie within
# A simulator is silent on reactions where its own model does not determine them.
UNKNOWN = (float("nan"),) * 3
THREE_POINT, TWO_POINT = "three_point", "two_point"


class Truth:
    """
    What a simulated bag says about itself, at its own stamps.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (n,)
        [ns], increasing.
    values : ndarray, shape (n, 6)
        gamma, psi, phi [rad], unwrapped, and the normal reactions at K, B1, B2 [N], NaN where they
        are not known.
    mode_ns : ndarray of int64, shape (m,)
        When a contact mode begins [ns].
    modes : list of str, length m

    """

    def __init__(self, t_ns, values, mode_ns, modes):
        self.t_ns = np.asarray(t_ns, dtype=np.int64)
        self.values = np.array(values, dtype=float)
        self.values[:, :3] = np.unwrap(self.values[:, :3], axis=0)
        self.mode_ns = np.asarray(mode_ns, dtype=np.int64)
        self.modes = list(modes)

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

    def transitions_ns(self) -> list[int]:
        """Return when three-point contact became two-point contact [ns]."""
        pairs = zip(self.modes, self.modes[1:], self.mode_ns[1:])
        return [int(t) for old, new, t in pairs if (old, new) == (THREE_POINT, TWO_POINT)]


def read_truth(bag: Bag, progress: Callable[[float], None] = lambda share: None) -> Truth | None:
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
    for count, (topic, log_ns, message) in enumerate(bag.messages(TYPES)):
        if count % 256 == 0:
            progress(count / total)
        if topic == MODE_TOPIC:
            modes.declared(log_ns, message.data)
            continue
        stamp = message.header.stamp
        t_ns = stamp.sec * 1_000_000_000 + stamp.nanosec
        modes.stamped(log_ns, t_ns)
        if topic == STATE_TOPIC:
            states[t_ns] = _named(bag, topic, message.name, message.position, ANGLES)
        else:
            normals[t_ns] = _named(bag, topic, message.name, message.effort, CONTACTS)
    if not states.keys() & normals.keys():
        raise BagError(f"{bag.path}: {STATE_TOPIC} and {CONTACTS_TOPIC} have no stamp in common")
    t_ns = sorted(states)
    values = [[*states[t], *normals.get(t, UNKNOWN)] for t in t_ns]
    return Truth(t_ns, values, *zip(*modes.changes()))


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


class Score:
    """
    Compares estimates with truth one stamp after the other; takes a replay's output as it comes.

    Angles count wherever there is truth. Reactions count where truth is three-point contact with
    known reactions and the estimate declares it: elsewhere three reactions do not exist.

    Parameters
    ----------
    truth : Truth

    """

    def __init__(self, truth: Truth):
        self.truth = truth
        self.count = np.zeros(6, int)
        self._square = np.zeros(6)
        self._stddev = np.zeros(6)
        self._inside = np.zeros(6, int)
        self._mean = np.zeros(6)
        self._mode = ""
        self._flag: bool | None = None
        self._flag_right = self._flag_count = 0
        self.rises_ns: list[int] = []

    def add(self, t_ns: int, messages: list[Message]) -> None:
        """Take the messages of one stamp [ns]."""
        fields = {suffix: message for suffix, _, message in messages}
        if "contact_mode" in fields:
            self._mode = fields["contact_mode"]["data"]
        flag = fields["transition"]["data"] if "transition" in fields else self._flag
        state, contacts = fields["state"]["position"], fields["contacts"]["effort"]
        spread = [*fields["state_stddev"]["position"], *fields["contacts_stddev"]["effort"]]
        self.row(t_ns, np.array([*state, *contacts]), np.array(spread), self._mode, flag)

    def row(self, t_ns: int, values, stddev, mode: str, flag: bool | None) -> None:
        """
        Take one estimate.

        Parameters
        ----------
        t_ns : int
            [ns]
        values, stddev : ndarray, shape (6,)
            gamma, psi, phi [rad], N_K, N_B1, N_B2 [N].
        mode : str
            Contact mode as declared.
        flag : bool or None
            Transition as declared.

        """
        if flag and self._flag is False:
            self.rises_ns.append(t_ns)
        self._flag = flag
        truth = self.truth.at(t_ns)
        if truth is None:
            return
        true_mode = self.truth.mode_at(t_ns)
        error = values - truth
        error[:3] -= 2 * pi * np.round(error[:3] / (2 * pi))
        counted = np.ones(6, bool)
        counted[3:] = true_mode == mode == THREE_POINT and np.isfinite(truth[3:]).all()
        self.count += counted
        self._square += np.where(counted, error**2, 0.0)
        self._stddev += np.where(counted, stddev, 0.0)
        self._mean += np.where(counted, truth, 0.0)
        self._inside += counted & (np.abs(error) <= BOUND * stddev)
        if flag is not None and true_mode in (THREE_POINT, TWO_POINT):
            self._flag_count += 1
            self._flag_right += flag == (true_mode == TWO_POINT)

    def rmse(self) -> dict[str, float | None]:
        """Return the RMS error by name [rad], [N]; None where nothing could be compared."""
        return self._each(lambda i: sqrt(self._square[i] / self.count[i]))

    def stddev(self) -> dict[str, float | None]:
        """Return the mean predicted standard deviation by name [rad], [N]."""
        return self._each(lambda i: self._stddev[i] / self.count[i])

    def mean(self) -> dict[str, float | None]:
        """Return the mean of the truth where it was compared [rad], [N]."""
        return self._each(lambda i: self._mean[i] / self.count[i])

    def coverage95(self) -> dict[str, float | None]:
        """Return the share of truth inside the 95 % bounds by name."""
        return self._each(lambda i: self._inside[i] / self.count[i])

    def flag_agreement(self) -> float | None:
        """Return the share of three- and two-point contact in which the flag is right."""
        return self._flag_right / self._flag_count if self._flag_count else None

    def flag_delays(self) -> list[float | None]:
        """
        Return how long after each true transition the flag rose [s]; negative: before it.

        None where it did not rise nearer to this transition than to another.
        """
        true_ns = self.truth.transitions_ns()
        delays: list[float | None] = []
        for t in true_ns:
            nearest = [
                rise for rise in self.rises_ns if min(true_ns, key=lambda s: abs(s - rise)) == t
            ]
            delays.append(min(((r - t) * 1e-9 for r in nearest), key=abs) if nearest else None)
        return delays

    def _each(self, of: Callable[[int], float]) -> dict[str, float | None]:
        return {name: float(of(i)) if self.count[i] else None for i, name in enumerate(NAMES)}


def score_table(score: Score) -> list[tuple[str, ...]]:
    """Return heading and rows of the comparison as texts."""
    rows = [("", "unit", "RMS error", "mean stddev", "inside 95 % bounds", "samples")]
    columns = score.rmse(), score.stddev(), score.coverage95()
    for i, name in enumerate(NAMES):
        label, unit = (name, "rad") if i < 3 else (f"N_{name}", "N")
        rmse, stddev, coverage = (column[name] for column in columns)
        if rmse is None:
            rows.append((label, unit, "-", "-", "-", "0"))
        else:
            rows.append(
                (
                    label,
                    unit,
                    f"{rmse:.3g}",
                    f"{stddev:.3g}",
                    f"{coverage:.1%}",
                    str(score.count[i]),
                )
            )
    return rows


def flag_lines(score: Score) -> list[str]:
    """Return what there is to say about the transition flag, a line each."""
    agreement = score.flag_agreement()
    lines = []
    if agreement is not None:
        lines.append(f"transition flag right in {agreement:.2%} of three- and two-point contact")
    start = int(score.truth.t_ns[0])
    for t, delay in zip(score.truth.transitions_ns(), score.flag_delays()):
        when = f"true transition at {(t - start) * 1e-9:.3f} s: "
        if delay is None:
            lines.append(when + "not flagged")
        else:
            side = "after" if delay >= 0 else "before"
            lines.append(when + f"flagged {abs(delay) * 1e3:.0f} ms {side} it")
    extra = len(score.rises_ns) - sum(delay is not None for delay in score.flag_delays())
    if extra:
        lines.append(f"the flag rose {extra} more time{'s' if extra > 1 else ''}")
    if not score.truth.transitions_ns():
        lines.append("there is no transition in the truth")
    return lines
