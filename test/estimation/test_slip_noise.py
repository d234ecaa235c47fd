"""Noise of one wrench against slip says which steps the filter will believe."""

import pytest

from peg_on_hole_ros.edges.contact_steps import ContactSteps
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.identification.slip_noise import SlipNoiseOf
from peg_on_hole_ros.estimation.measurement import PegJoints
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.simulation.measure import measure
from pegs import closing


@pytest.mark.parametrize(
    ("name", "rate", "believed"),
    [
        ("10 mm", 1000, False),
        ("50 mm", 250, False),
        ("50 mm", 1000, True),
        ("150 mm", 250, True),
    ],
)
def test_noise_against_slip_says_what_the_filter_believes(name, rate, believed):
    truth = closing(name, rate, min(rate, 500))
    configuration, steps = truth.plan.configuration, ContactSteps()
    pipeline = Pipeline(configuration, make=steps.watched(make_filter))
    orientation, motion = PegJoints(configuration.joints), SlipNoiseOf(configuration)
    for sample in measure(truth, 3):
        pipeline.on_sample(sample)
        if isinstance(sample, WrenchSample):
            motion.wrench(sample)
        else:
            motion.angles(orientation(sample))
    found = motion.result(1.0 / rate)
    assert found.windows >= 8
    assert (2 * found.hidden < found.windows) == believed
    assert (2 * steps.bridged < steps.count) == believed
