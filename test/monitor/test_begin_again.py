"""What a motion that begins anew leaves of what was told before."""

from itertools import islice

from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import measure
from simulated import truth


def test_a_clock_that_jumps_back_lowers_the_flag():
    motion = truth("working_cycle")
    line = Pipeline(motion.plan.configuration)
    assert any(outputs.transition for outputs in line.play(measure(motion, 1)))
    flags = [outputs.transition for outputs in line.play(islice(measure(motion, 2), 600))]
    assert len(flags) > 300 and line.counts["clock_jumped_back"] == 1
    assert not any(flags)
