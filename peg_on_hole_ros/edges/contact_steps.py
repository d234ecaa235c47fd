"""How many of a filter's steps on three contacts it does not believe, and what that means."""

from collections import Counter
from collections.abc import Callable
from math import ceil, log10

from peg_on_hole_ros.configuration import uncertain_offsets
from peg_on_hole_ros.estimation.filters.outcomes import NO_STEP, Prediction
from peg_on_hole_ros.estimation.identification.slip_noise import BELIEVED, SlipNoise
from peg_on_hole_ros.options import Configuration

# Not for noise.
_UNSOLVED = ("step_without_solution", "step_runs_away")
_LIMITED = "step_limited"
# No usual sensor sends more [Hz].
_MOST_RATE = 10_000.0
_INSTEAD = (
    "friction, angles and rates come from the balance of forces, and wrong settings show less "
    "(docs/steps.md, docs/integration.md)"
)
_BRIDGED = (*NO_STEP, Prediction.SLOW, Prediction.DOUBTED, Prediction.RUNAWAY)


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


def told(content: dict[str, int], events: dict[str, int], configuration: Configuration) -> str:
    """
    Return what to know where more than half of the steps were not believed, or nothing.

    Parameters
    ----------
    content : dict of str to int
        As `ContactSteps.content` gives it.
    events : dict of str to int
        What a replay has counted.
    configuration : Configuration
        That it had.

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
    if 2 * events.get(_LIMITED, 0) > bridged:
        return (
            f"{begun}mostly as no step was found within filter.max_evaluations: usual for a "
            "wrench at 100 Hz and less; else units (N, N m), wrench.acts_on, sensor_xyz, torques "
            "or scene are wrong (docs/steps.md, docs/integration.md)"
        )
    stated = _stated(configuration)
    if stated:
        return (
            f"{begun}likely as what is stated to be uncertain hides how contacts slip "
            f"({', '.join(stated)}): state less, after a tare, a measurement or `peg-on-hole "
            "calibrate`; else as noise or rest does (usual for a slow wrench, a small peg, a peg "
            f"at rest), or a setting is wrong: {_INSTEAD}"
        )
    return (
        f"{begun}as noise or rest leaves slip no direction (usual for a slow wrench, a small peg, "
        f"a peg at rest; else a setting is wrong): {_INSTEAD}"
    )


def _stated(configuration):
    """Return what the configuration says is uncertain, and that moves the slip of a step."""
    spreads = uncertain_offsets(configuration)
    if configuration.scene.clearance_stddev:
        spreads.append(("scene.clearance_stddev", configuration.scene.clearance_stddev))
    return [f"{name} = {value:g}" for name, value in spreads]


def foreseen_content(found: SlipNoise, period: float) -> dict:
    """
    Return what `inspect --json` has of the steps that a replay will not believe.

    Parameters
    ----------
    found : SlipNoise
    period : float
        Between wrenches [s].

    """
    enough = BELIEVED / (found.ratio * period) if found.ratio else float("inf")
    step = 10.0 ** (ceil(log10(enough)) - 2) if enough <= _MOST_RATE else None
    return {
        "windows": found.windows,
        "not_believed": found.hidden,
        "wrench_rate": 1.0 / period,
        "slip": found.slip,
        "slip_noise": found.noise,
        "enough_rate": ceil(enough / step) * step if step else None,
    }


def foreseen(content: dict) -> str:
    """Return what to know where most steps will not be believed, or nothing."""
    windows, hidden, enough = (content[k] for k in ("windows", "not_believed", "enough_rate"))
    if 2 * hidden <= windows:
        return ""
    remedy = (
        f"record the wrench at {enough:g} Hz or more, or turn the peg faster"
        if enough
        else f"{_MOST_RATE:g} Hz would not do either: turn the peg faster"
    )
    return (
        f"contact steps: in {hidden} of {windows} stretches of motion a replay will not believe "
        f"most of them: contacts slip by {1e3 * content['slip']:.3g} mm/s, and noise of one "
        f"wrench at {content['wrench_rate']:.4g} Hz moves them by "
        f"{1e3 * content['slip_noise']:.3g} mm/s, which has to be less than an eighth of that. "
        "Friction, angles and rates then come from the balance of forces, and wrong settings "
        f"show less (docs/steps.md, docs/integration.md); at this noise and motion {remedy}"
    )
