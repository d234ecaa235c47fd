"""How many of the next messages can be taken in one go: those that come in order, or nearly so."""

import numpy as np

from peg_on_hole_ros.records import Arrivals

_NEVER = np.iinfo(np.int64).min


def count_in_order(
    arrivals: Arrivals,
    places: slice,
    now_ns: int,
    last_joint_ns: int | None,
    waiting: int,
    most_waiting: int,
    max_gap_ns: int,
    reach: tuple[int, int] = (0, _NEVER),
) -> int:
    """
    Return how many messages from a place on are readable and neither repeated nor far ahead.

    None of them is late but for orientations within reach.

    Parameters
    ----------
    arrivals : Arrivals
    places : slice
        Those that are looked at.
    now_ns : int
        Stamp that the estimate has come to [ns].
    last_joint_ns : int or None
        The newest stamp of an orientation so far [ns].
    waiting : int
        Orientations that wait for the wrench of their time.
    most_waiting : int
        How many of them may wait.
    max_gap_ns : int
        A wrench that comes later after the one before comes after a silence [ns].
    reach : tuple of int
        How late an orientation may be [ns], and the stamp that it has to be of after [ns].

    """
    of_wrench, t_ns = arrivals.of_wrench[places], arrivals.t_ns[places]
    fine = arrivals.sound[places].copy()
    before = _newest_before(np.where(of_wrench, t_ns, _NEVER), now_ns)
    fine &= (t_ns > before) | ~of_wrench
    fine &= (t_ns - before <= max_gap_ns) | ~of_wrench
    # An orientation of a wrench's own stamp may come behind it.
    newest = _newest_before(
        np.where(of_wrench, _NEVER, t_ns), _NEVER if last_joint_ns is None else last_joint_ns
    )
    late_ns, oldest_ns = reach
    in_time = (t_ns >= before) | ((before - t_ns <= late_ns) & (t_ns > oldest_ns))
    fine &= of_wrench | (in_time & (t_ns > newest))
    ahead = ~of_wrench & (t_ns > before)
    # As if no wrench took any of them.
    fine &= waiting + np.cumsum(ahead) <= most_waiting
    wrong = np.flatnonzero(~fine)
    return int(wrong[0]) if len(wrong) else len(fine)


def _newest_before(t_ns, first_ns):
    """Return the greatest before each place, which for the first one is given."""
    newest = np.maximum.accumulate(np.concatenate([[first_ns], t_ns]))
    return newest[:-1]
