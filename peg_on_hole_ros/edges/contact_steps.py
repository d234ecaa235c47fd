"""How many of a filter's steps on three contacts it did not believe, and what that means."""

from collections import Counter
from collections.abc import Callable

from peg_on_hole_ros.estimation.filters.outcomes import NO_STEP, Prediction

# Not for noise.
_UNSOLVED = ("step_without_solution", "step_runs_away")
_BRIDGED = (*NO_STEP, Prediction.SLOW, Prediction.RUNAWAY)


class ContactSteps:
    """Counts predictions on three contacts, anew where a late message has them repeated."""

    def __init__(self):
        self._results: Counter[Prediction] = Counter()

    @property
    def count(self) -> int:
        """All predictions on three contacts."""
        return self._results.total() - self._results[Prediction.FREE]

    @property
    def bridged(self) -> int:
        """Those of them that were predicted at constant rates for want of a step to believe."""
        return sum(self._results[result] for result in _BRIDGED)

    def watched(self, make: Callable) -> Callable:
        """Return what makes the same filter, whose predictions are counted here."""

        def made(*arguments):
            made_filter = make(*arguments)
            predict = made_filter.predict

            def counted(dt, in_contact):
                result = predict(dt, in_contact)
                self._results[result] += 1
                return result

            made_filter.predict = counted
            return made_filter

        return made

    def content(self) -> dict[str, int]:
        """Return what `--summary` has of it."""
        return {"count": self.count, "not_believed": self.bridged}


def told(content: dict[str, int], events: dict[str, int]) -> str:
    """
    Return what to know where more than half of the steps were not believed, or nothing.

    Parameters
    ----------
    content : dict of str to int
        As `ContactSteps.content` gives it.
    events : dict of str to int
        What a replay has counted.

    """
    bridged, count = content["not_believed"], content["count"]
    if 2 * bridged <= count:
        return ""
    begun = f"contact steps: {bridged} of {count} not believed, "
    if 2 * sum(events.get(name, 0) for name in _UNSOLVED) > bridged:
        return (
            f"{begun}mostly as the contact equations have no solution, or one that runs away: a "
            "wedged peg, or units (N, N m), wrench.acts_on, sensor_xyz or scene that are wrong "
            "(docs/steps.md, docs/integration.md)"
        )
    return (
        f"{begun}as noise or rest leaves slip no direction (usual for a slow wrench, a small peg, "
        "a peg at rest; else a setting is wrong): friction, angles and rates come from the "
        "balance of forces, and wrong settings show less (docs/steps.md, docs/integration.md)"
    )
