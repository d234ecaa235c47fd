"""Without any orientation what the peg is doing is a guess, and is not told as known."""

from dataclasses import replace

import pytest

from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.simulation.measure import START_NS, measure
from peg_on_hole_ros.study import scenes

CUT, BACK = 0.15, 0.35


@pytest.fixture(scope="module")
def truth():
    case = next(case for case in scenes.CASES if case.name == "reversals")
    return scenes.truth_of(case, Configuration())


def played(truth, max_joint_gap, late=False):
    """Return counts and outputs of a run whose joint states are silent for a while."""
    configuration = truth.plan.configuration
    options = replace(configuration.filter, max_joint_gap=max_joint_gap)
    pipeline = Pipeline(replace(configuration, filter=options))

    def silent(sample):
        t = (sample.t_ns - START_NS) * 1e-9
        return isinstance(sample, JointSample) and CUT < t < BACK

    samples = [each for each in measure(truth, 5) if not silent(each)]
    if late:
        # One wrench of the silence comes 10 ms late.
        place = next(
            k for k, each in enumerate(samples) if (each.t_ns - START_NS) * 1e-9 > CUT + 0.08
        )
        samples.insert(place + 10, samples.pop(place))
    outputs = list(pipeline.play(samples))
    return pipeline.counts, {round((o.t_ns - START_NS) * 1e-6): o for o in outputs}


@pytest.mark.parametrize("late", [False, True])
def test_mode_is_unknown_while_orientations_are_silent_and_told_again_after(truth, late):
    counts, outputs = played(truth, 0.05, late)
    assert counts["joints_gap"] == 1
    modes = {k: each.contact_mode for k, each in outputs.items()}
    assert modes[145] == modes[195] == "three_point"
    assert {modes[k] for k in range(202, 350) if k in modes} == {"unknown"}
    # As after a start, in which a mode takes some 20 ms.
    assert {modes[k] for k in range(400, 440)} == {"three_point"}


def test_a_silence_that_is_allowed_changes_nothing(truth):
    counts, outputs = played(truth, 0.5)
    assert counts["joints_gap"] == 0 and outputs[195].contact_mode == "three_point"
