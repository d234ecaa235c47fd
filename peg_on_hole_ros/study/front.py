"""The front of what nothing beats in cost and error, and whether the default is on it."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.study.filtering import DEFAULT, Score, Variant

# A difference in cost or error that counts.
WORTH = 1.1
# Costs and errors that are this close are the same: chance in timing, and of a few seeds.
SAME = 1.03
# A variant whose 95 % bounds hold less does not compete: it says what is not so.
LEAST_COVERAGE = 0.9


def front(cost, error) -> list[int]:
    """Return the places on the Pareto front by rising cost: none is both dearer and worse."""
    kept, least = [], np.inf
    for k in np.lexsort((error, cost)):
        if error[k] < least:
            kept.append(int(k))
            least = error[k]
    return kept


class Standing(NamedTuple):
    """
    Where the default stands in one motion.

    Attributes
    ----------
    case : str
    on_front : bool
        Nothing that competes beats it.
    by : str
        What beats it, the one with the least error; empty if nothing does.
    cost, error : float
        Of that over the default's: 0.5 is half.
    competing : tuple of str
        Names of all that compete, the default among them.

    """

    case: str
    on_front: bool
    by: str
    cost: float
    error: float
    competing: tuple[str, ...]


def beats(cost: float, error: float) -> bool:
    """
    Return whether something of this cost and error, over another's, beats the other.

    It does if it is better by more than WORTH in one, and no worse than SAME in the other.
    """
    return (cost < 1 / WORTH and error <= SAME) or (error < 1 / WORTH and cost <= SAME)


def standings(scores: list[Score], chosen: list[Variant], besides: float = 0.0):
    """
    Return where the default stands in the reactions of each motion.

    Who competes: what gives reactions at every wrench, knows no more than the default, loses no
    run, and has LEAST_COVERAGE; if the default has not, coverage does not count.

    Parameters
    ----------
    scores : list of Score
    chosen : list of Variant
    besides : float
        What a millisecond of motion costs beside the filter, whichever it is [us].

    Returns
    -------
    list of Standing

    """
    apart = {variant.name for variant in chosen if variant.told or variant.every > 1}
    found = []
    for case in dict.fromkeys(score.case for score in scores):
        own = {score.name: score for score in scores if score.case == case}
        default = own.pop(DEFAULT)
        least = LEAST_COVERAGE if default.coverage >= LEAST_COVERAGE else 0.0
        others = [
            score
            for name, score in own.items()
            if name not in apart and not score.lost and score.coverage >= least
        ]
        better = [
            (error, cost, score.name)
            for score in others
            if beats(
                cost := (score.microseconds + besides) / (default.microseconds + besides),
                error := score.reaction_error / default.reaction_error,
            )
        ]
        error, cost, by = min(better, default=(1.0, 1.0, ""))
        names = (DEFAULT, *(score.name for score in others))
        found.append(Standing(case, not better, by, cost, error, names))
    return found


class Overall(NamedTuple):
    """
    One variant over all motions.

    Attributes
    ----------
    name : str
    state_ratio, state_low, state_high, reaction_ratio, reaction_low, reaction_high : float
        Median over the motions of the root mean square over the bound, and between what half of
        the motions are; NaN where no motion has one.
    coverage : float
        Median of the motions.
    lost : float
        Share of all runs.
    microseconds : float
        For a millisecond of motion, median of the motions.

    """

    name: str
    state_ratio: float
    state_low: float
    state_high: float
    reaction_ratio: float
    reaction_low: float
    reaction_high: float
    coverage: float
    lost: float
    microseconds: float


def overall(scores: list[Score]) -> list[Overall]:
    """Return each variant over all motions."""
    found = []
    for name in dict.fromkeys(score.name for score in scores):
        own = [score for score in scores if score.name == name]
        found.append(
            Overall(
                name,
                *_quartiles([score.state_ratio for score in own]),
                *_quartiles([score.reaction_ratio for score in own]),
                _quartiles([score.coverage for score in own])[0],
                float(np.mean([score.lost for score in own])),
                float(np.median([score.microseconds for score in own])),
            )
        )
    return found


def _quartiles(values):
    values = [value for value in values if np.isfinite(value)]
    if not values:
        return (float("nan"),) * 3
    return tuple(float(value) for value in np.quantile(values, (0.5, 0.25, 0.75)))
