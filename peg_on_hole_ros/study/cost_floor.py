"""What a method's compiled step costs by itself: all steps in one compiled loop, as in C."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import Configuration, FilterOptions
from peg_on_hole_ros.estimator import filter_steps
from peg_on_hole_ros.estimator.contact_filter import ContactFilter, Correction
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import Settings, default_settings
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.runs import run

_START, _END_MOTION, _PREDICT, _CORRECT, _WEIGH = range(5)
# What a step is called with, side by side: q and R, or a time, or a wrench and its contacts.
_WIDTH = 12


class Noted(ContactFilter):
    """
    The default estimator, noting what it is called with.

    Attributes
    ----------
    arguments : tuple
        What it was made of.
    calls : list of list of float
        What was called, and with what.

    """

    def __init__(
        self,
        scene: Scene,
        options: FilterOptions,
        noise: np.ndarray,
        offsets: OffsetUncertainty | None = None,
    ) -> None:
        self.arguments = scene, options, np.array(noise), offsets, default_settings()
        self.calls: list[list[float]] = []
        self._within = False
        super().__init__(*self.arguments)

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start from an orientation; see `ContactFilter`."""
        self._note(_START, *np.ravel(q), *np.ravel(R))
        super().start(q, R)

    def end_estimate(self) -> None:
        """End the motion; see `ContactFilter`."""
        self._note(_END_MOTION)
        super().end_estimate()

    def predict(self, dt: float) -> None:
        """Move the estimate on by dt [s]."""
        self._note(_PREDICT, dt)
        super().predict(dt)

    def correct(self, q: np.ndarray, R: np.ndarray) -> tuple[Correction, float]:
        """Correct with an orientation; see `ContactFilter`."""
        self._note(_CORRECT, *np.ravel(q), *np.ravel(R))
        # What it starts or lets go of is part of it.
        self._within = True
        found = super().correct(q, R)
        self._within = False
        return found

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Take a wrench on the peg; see `ContactFilter`."""
        self._note(_WEIGH, *u, int(contacts))
        super().weigh(u, contacts)

    def _note(self, what, *given):
        if not self._within:
            self.calls.append([float(what), *given] + [0.0] * (_WIDTH - len(given)))


def noted(configuration: Configuration, samples: Sequence, clock: Callable[[], float]) -> Noted:
    """Run the default estimator over joint and wrench samples, and return it with its calls."""
    made = []

    def make(*given):
        made.append(Noted(*given))
        return made[-1]

    run(configuration, samples, clock, make)
    return made[-1]


def taken_anew(
    noted: Noted, settings: Settings, clock: Callable[[], float]
) -> tuple[ContactFilter, float]:
    """
    Take all steps anew in one compiled loop; return where it came to, and the time a wrench [s].

    Parameters
    ----------
    noted : Noted
    settings : Settings
        Of the estimator that is to take them.
    clock : callable
        Returns a time [s].

    """
    peg, calls = ContactFilter(*noted.arguments[:4], settings), np.array(noted.calls)
    gates = peg.gates
    begun = clock()
    _all_steps(peg.memory, gates, calls)
    seconds = clock() - begun
    return peg, seconds / max(int(np.count_nonzero(calls[:, 0] == _WEIGH)), 1)


class CostPiece(NamedTuple):
    """What the steps of a wrench cost in a piece of a motion: its begin [s], and [us]."""

    t: float
    step: float


def cost_along(
    noted: Noted, settings: Settings, clock: Callable[[], float], piece: float, turns: int
) -> list[CostPiece]:
    """
    Take all steps anew, piece by piece; return what a wrench costs in each, median of turns.

    Parameters
    ----------
    noted : Noted
    settings : Settings
    clock : callable
        Returns a time [s].
    piece : float
        [s]
    turns : int

    """
    calls = np.array(noted.calls)
    t = np.cumsum(np.where(calls[:, 0] == _PREDICT, calls[:, 1], 0.0))
    # What is left over at the end is no piece.
    edges = np.searchsorted(t, np.arange(0.0, t[-1], piece))
    spans = [(begin, end) for begin, end in zip(edges, edges[1:]) if begin < end]
    spent = np.empty((turns, len(spans)))
    for turn in range(turns):
        peg = ContactFilter(*noted.arguments[:4], settings)
        for k, (begin, end) in enumerate(spans):
            begun = clock()
            _all_steps(peg.memory, peg.gates, calls[begin:end])
            spent[turn, k] = clock() - begun
    wrenches = [max(int((calls[begin:end, 0] == _PREDICT).sum()), 1) for begin, end in spans]
    return [
        CostPiece(float(t[begin]), float(1e6 * seconds / count))
        for (begin, _), seconds, count in zip(spans, np.median(spent, axis=0), wrenches)
    ]


@compiled
def _all_steps(memory, gates, calls):
    for k in range(len(calls)):
        what, given = calls[k, 0], calls[k, 1:]
        q, R = given[:3], given[3:12].reshape(3, 3)
        if what == _START:
            filter_steps.start(memory, gates, q, R)
        elif what == _END_MOTION:
            filter_steps.end_estimate(memory)
        elif what == _PREDICT:
            filter_steps.predict(memory, given[0])
        elif what == _CORRECT:
            filter_steps.correct(memory, gates, q, R)
        else:
            filter_steps.correct_by_wrench(memory, given[:6], int(given[6]))
