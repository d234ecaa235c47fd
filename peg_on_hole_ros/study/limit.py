"""What the default's arithmetic costs by itself: its steps in one compiled loop, as in C."""

from collections.abc import Callable

import numpy as np

from peg_on_hole_ros.estimator import step
from peg_on_hole_ros.estimator.held_peg import ContactSet, Correction, HeldPeg
from peg_on_hole_ros.estimator.mixture import combine, predict
from peg_on_hole_ros.estimator.noise import follow_noise
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import FRICTION, OPEN, new_scratch, new_state, places
from peg_on_hole_ros.mechanics.kernel import compiled, scene_scalars
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.study.runs import run

_START, _PREDICT, _CORRECT, _WEIGH = range(4)
# What a step is called with, side by side: q and R, or a time, or a wrench and its contacts.
_WIDTH = 12
_CARRY = {ContactSet.THREE: 3.0, ContactSet.NONE: 0.0, ContactSet.UNKNOWN: -1.0}


class Noted(HeldPeg):
    """
    The default estimator, noting what it is called with.

    Attributes
    ----------
    calls : list of list of float
        What was called, and with what.

    """

    def __init__(self, scene, options, noise, offsets=None):
        super().__init__(scene, options, noise, offsets, default_settings())
        if self._n != OPEN:
            raise ValueError("nothing but friction is left open here")
        self.calls: list[list[float]] = []

    def start(self, q, R):
        """Start from an orientation; see `HeldPeg`."""
        self._note(_START, *np.ravel(q), *np.ravel(R))
        super().start(q, R)

    def predict(self, dt: float):
        """Move the estimate on by dt [s]."""
        self._note(_PREDICT, dt)
        super().predict(dt)

    def correct(self, q, R):
        """Correct with an orientation; see `HeldPeg`."""
        found = super().correct(q, R)
        if found[0] is Correction.USED:
            self._note(_CORRECT, *np.ravel(q), *np.ravel(R))
        return found

    def weigh(self, u, contacts: ContactSet):
        """Take a wrench on the peg; see `HeldPeg`."""
        self._note(_WEIGH, *u, _CARRY[contacts])
        super().weigh(u, contacts)

    def _note(self, what, *given):
        self.calls.append([float(what), *given] + [0.0] * (_WIDTH - len(given)))


class Alone:
    """
    The steps that an estimator has taken, to be taken anew in one compiled loop.

    Parameters
    ----------
    noted : Noted

    Attributes
    ----------
    state : State
        Where the last run has come to.

    """

    def __init__(self, noted: Noted):
        scene, options, o = noted.scene, noted.options, noted.constants
        at, n = places(())
        several = scene.friction_stddev > 0.0 and options.friction == "estimated"
        sizes = n, o.frictions if several else 1, len(o.level)
        _, self.state = new_state(*sizes)
        walk, learnt = np.zeros(n), np.ones(n + 3)
        walk[FRICTION] = options.friction_noise**2 if scene.friction_stddev else 0.0
        learnt[FRICTION] = options.friction == "estimated"
        begin = options.initial_rate_stddev, scene.friction, scene.friction_stddev
        self._given = (
            self.state, new_scratch(*sizes), o, scene_scalars(scene), at, n, walk, learnt,
            noted.wrench_noise, np.zeros((6, 6)), begin, np.array(noted.calls),
        )  # fmt: skip

    def run(self) -> None:
        """Take all the steps from the start."""
        self.state.noise[:] = 1.0
        _all_steps(*self._given)


@compiled
def _all_steps(s, scratch, o, p, at, n, walk, learnt, noise, bias_map, begin, calls):
    nothing = np.zeros(0)
    for k in range(len(calls)):
        what, given = calls[k, 0], calls[k, 1:]
        q, R = given[:3], given[3:12].reshape(3, 3)
        if what == _START:
            step.start(s, scratch, o, at, n, q, s.noise[0] * R, *begin, nothing, nothing)
        elif what == _PREDICT:
            predict(s, scratch, o, walk, n, given[0])
            step.pass_time(s, given[0])
            combine(s, n)
        elif what == _CORRECT:
            step.expect(s, scratch, at, q, R)
            follow_noise(s, o, q, R)
            step.orient(s, scratch, o, at, n, learnt, q, R)
            combine(s, n)
        else:
            step.weigh(s, scratch, o, p, at, n, learnt, given[:6], noise, bias_map, int(given[6]))


def arithmetic(configuration: Configuration, samples, clock: Callable[[], float]) -> float:
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
    alone = Alone(made[-1])
    # Compiled, and its memory at hand.
    alone.run()
    begun = clock()
    alone.run()
    return clock() - begun
