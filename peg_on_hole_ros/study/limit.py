"""What the default's arithmetic costs by itself: its steps in one compiled loop, as in C."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import Configuration, FilterOptions
from peg_on_hole_ros.estimator import held
from peg_on_hole_ros.estimator.held_peg import ContactSet, Correction, HeldPeg
from peg_on_hole_ros.estimator.offsets import Offsets
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.runs import run

_START, _LET_GO, _PREDICT, _CORRECT, _WEIGH = range(5)
# What a step is called with, side by side: q and R, or a time, or a wrench and its contacts.
_WIDTH = 12


class Noted(HeldPeg):
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
        offsets: Offsets | None = None,
    ) -> None:
        self.arguments = scene, options, np.array(noise), offsets, default_settings()
        self.calls: list[list[float]] = []
        self._within = False
        super().__init__(*self.arguments)

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start from an orientation; see `HeldPeg`."""
        self._note(_START, *np.ravel(q), *np.ravel(R))
        super().start(q, R)

    def let_go(self) -> None:
        """Let go of the motion; see `HeldPeg`."""
        self._note(_LET_GO)
        super().let_go()

    def predict(self, dt: float) -> None:
        """Move the estimate on by dt [s]."""
        self._note(_PREDICT, dt)
        super().predict(dt)

    def correct(self, q: np.ndarray, R: np.ndarray) -> tuple[Correction, float]:
        """Correct with an orientation; see `HeldPeg`."""
        self._note(_CORRECT, *np.ravel(q), *np.ravel(R))
        # What it starts or lets go of is part of it.
        self._within = True
        found = super().correct(q, R)
        self._within = False
        return found

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Take a wrench on the peg; see `HeldPeg`."""
        self._note(_WEIGH, *u, contacts)
        super().weigh(u, contacts)

    def _note(self, what, *given):
        if not self._within:
            self.calls.append([float(what), *given] + [0.0] * (_WIDTH - len(given)))


def taken_anew(noted: Noted, clock: Callable[[], float]) -> tuple[HeldPeg, float]:
    """Take all its steps in one compiled loop; return where it came to, and the time [s]."""
    peg, calls = HeldPeg(*noted.arguments), np.array(noted.calls)
    gates = peg.gates
    begun = clock()
    _all_steps(peg.held, gates, calls)
    return peg, clock() - begun


@compiled
def _all_steps(h, gates, calls):
    for k in range(len(calls)):
        what, given = calls[k, 0], calls[k, 1:]
        q, R = given[:3], given[3:12].reshape(3, 3)
        if what == _START:
            held.start(h, gates, q, R)
        elif what == _LET_GO:
            held.let_go(h)
        elif what == _PREDICT:
            held.move_on(h, given[0])
        elif what == _CORRECT:
            held.correct(h, gates, q, R)
        else:
            held.weigh(h, given[:6], int(given[6]))


def arithmetic(
    configuration: Configuration, samples: Sequence, clock: Callable[[], float]
) -> float:
    """
    Return how long the default's arithmetic takes over samples, without anything around it [s].

    Parameters
    ----------
    configuration : Configuration
    samples : sequence
        Joint and wrench samples.
    clock : callable
        Returns a time [s].

    """
    made = []

    def make(*given):
        made.append(Noted(*given))
        return made[-1]

    run(configuration, samples, clock, make)
    # Compiled, and its memory at hand.
    taken_anew(made[-1], clock)
    return taken_anew(made[-1], clock)[1]
