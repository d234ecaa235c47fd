"""A component that stays at the end of its range: told, and nothing is made of such wrenches."""

from itertools import product

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from recorded_faults import BAGS, samples, spoilt
from tiers import nightly


def clipped(force, torque):
    return lambda f, t, q: (np.clip(f, -force, force), np.clip(t, -torque, torque))


def rounded(force, torque):
    return lambda f, t, q: (np.round(f / force) * force, np.round(t / torque) * torque)


def played(path, change, begin=0.0, end=np.inf):
    line, outputs = Pipeline(from_parameters({})), []
    for sample in spoilt(samples(path, begin, end), change):
        told = line.on_sample(sample)
        if told is not None:
            outputs.append(told)
    return line, outputs


def determined(outputs):
    return [output.monitor["reactions_determined"] == 1.0 for output in outputs]


@pytest.mark.parametrize("path", BAGS[:2], ids=lambda path: path.stem)
def test_it_is_named_with_its_value_and_no_reaction_is_told(path):
    whole, plain = played(path, lambda f, t, q: (f, t))
    assert whole.counts["wrench_saturated"] == 0 and np.mean(determined(plain)) > 0.8
    line, outputs = played(path, clipped(20.0, 1.0))
    told = [cause for cause in line.causes if "while the others go on" in cause]
    assert len(told) == 1 and told[0].startswith("wrench: the ")
    assert " stays at 1 N m " in told[0] or " stays at -1 N m " in told[0]
    count = line.counts["wrench_saturated"]
    assert count > 300 and line.counts["setting_adopted"] == 0
    # The first 20 wrenches might be true.
    assert np.sum(determined(outputs)) <= len(outputs) - count


def test_a_wrench_that_comes_off_its_end_is_used_again():
    """The sample's peg is lifted off at 6.9 s, and set again at 8.7 s."""
    line, outputs = played(BAGS[2], clipped(20.0, 1.0), 5.0, 9.0)
    assert line.counts["wrench_saturated"] > 200
    modes = [output.contact_mode for output in outputs]
    assert "unknown" in modes and "open" in modes[modes.index("unknown") :]


STEPS = [(0.1, 0.01), (0.1, 0.1), (1.0, 0.05)]


@pytest.mark.parametrize(
    ("path", "steps", "end"),
    [
        *product(BAGS[:2], STEPS, (np.inf,)),
        (BAGS[2], STEPS[2], 2.5),
        *nightly(*product(BAGS[2:], STEPS, (np.inf,))),
    ],
)
def test_a_sensor_that_rounds_has_no_end(path, steps, end):
    line, _ = played(path, rounded(*steps), end=end)
    assert line.counts["wrench_saturated"] == 0
