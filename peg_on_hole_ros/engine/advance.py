"""Wrenches with their orientations, one after the other, and back for late ones; compiled."""

import numpy as np

from peg_on_hole_ros.engine import steps
from peg_on_hole_ros.engine.kept import Kept, go_back, keep
from peg_on_hole_ros.estimator import held
from peg_on_hole_ros.mechanics.kernel import compiled


@compiled
def advance(
    memory: np.ndarray,
    words: np.ndarray,
    rules: np.ndarray,
    t_ns: np.ndarray,
    wrenches: np.ndarray,
    ends: np.ndarray,
    placed: np.ndarray,
    stamps: np.ndarray,
    orientations: np.ndarray,
    lateness: float,
    kept: Kept,
    first: int,
    last: int,
    taken: int,
    went: np.ndarray,
    rows: np.ndarray,
) -> int:
    """
    Take wrenches one after the other, each with the orientations since the one before.

    Where orientations come late, the estimate goes back to before the first of them, and takes
    again what followed it.

    Parameters
    ----------
    memory : ndarray of ENGINE, shape (1,)
        Changed. An array, as Python hands over a record in sixteen microseconds.
    words : ndarray of int64
        The same memory.
    rules : ndarray of RULES, shape (1,)
    t_ns : ndarray of int64, shape (n,)
        Stamps of the wrenches, in order; without any, orientations are taken alone [ns].
    wrenches : ndarray, shape (n, 6)
        As received [N], [N m].
    ends : ndarray of int64, shape (n,)
        How many of the orientations have arrived before each wrench; -1 is left where there is
        no row.
    placed : ndarray of int64, shape (n,)
        How many of them belong before each wrench by their stamps.
    stamps : ndarray of int64, shape (k,)
        Of the orientations, in order [ns].
    orientations : ndarray, shape (k, ORIENTATION)
    lateness : float
        How long before the stamp that the estimate has come to those alone were measured [s].
    kept : Kept
        Where states are kept; without room none is, and no orientation may be late.
    first, last : int
        Wrenches that are taken; without any, what is late before the first one is put right.
    taken : int
        Orientations that the estimate has.
    went : ndarray of int64, shape (2,)
        Counted up: how often it went back, and how many wrenches it took again.
    rows : ndarray, shape (last - first, SIZE)
        See `monitor.output_row`; filled in as far as is returned, and at least one.

    Returns
    -------
    int
        How many rows there are: none for a wrench while the motion is lost.

    """
    e, r = memory[0], rules[0]
    if not len(t_ns):
        for k in range(len(stamps)):
            steps.correct(e, r, stamps[k], orientations[k], lateness)
    count, places = 0, len(kept.beside)
    for i in range(first, max(last, first + 1) if places else last):
        late = min(ends[i], placed[i - 1]) if places and i else taken
        if late > taken:
            # Where the first late one belongs.
            back = i - 1
            while back and placed[back - 1] > taken:
                back -= 1
            went[0] += 1
            went[1] += i - back
            go_back(kept, back % places, words, e.held.state)
            begin = placed[back - 1] if back else 0
            for k in range(back, i):
                keep(kept, k % places, words, e.held.state)
                end = min(late, placed[k])
                _take_wrench(
                    e, r, t_ns[k], wrenches[k], stamps[begin:end], orientations[begin:end],
                    rows[count],
                )  # fmt: skip
                begin = end
            taken = late
        if i == last:
            break
        if places:
            keep(kept, i % places, words, e.held.state)
        end = min(ends[i], placed[i])
        if _take_wrench(
            e, r, t_ns[i], wrenches[i], stamps[taken:end], orientations[taken:end],
            rows[count],
        ):  # fmt: skip
            count += 1
        else:
            ends[i] = -1
        taken = end
    return count


@compiled
def _take_wrench(e, rules, t_ns, wrench, stamps, orientations, row):
    """Take one wrench; return whether there is anything to be told of it."""
    silent = steps.begin_unit(e, rules, t_ns)
    for k in range(len(stamps)):
        steps.advance(e, rules, stamps[k])
        steps.correct(e, rules, stamps[k], orientations[k], 0.0)
    steps.advance(e, rules, t_ns)
    if not steps.told(e, rules):
        return False
    contacts = steps.reduce(e, t_ns, wrench, silent)
    held.weigh(e.held, e.u, contacts)
    steps.judge(e, rules, t_ns, contacts, row)
    return True
