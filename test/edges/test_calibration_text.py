"""What a calibration says of what it did not see: true of the recording, and no more asked for."""

import re
from dataclasses import replace

import pytest

from peg_on_hole_ros.configuration import from_parameters, to_parameters
from peg_on_hole_ros.edges.calibration_text import NEAR, heading, not_seen, parameters
from peg_on_hole_ros.estimation.identification.calibration import Calibration, Estimate
from peg_on_hole_ros.options import Configuration

UNSEEN = Estimate("clearance", "m", 1e-4, 1e-4, 7e-5, 1.5e-4, 1e-4, False, "")


def said(least_tilt, both_ways):
    found = Calibration(
        Configuration(), (UNSEEN,), 3.0, 3.0, 0.0, 0.0, 300, 0.6, least_tilt, 1.15, both_ways
    )
    (line,) = not_seen(found)
    return line


@pytest.mark.parametrize("least_tilt", [1.04, 1.1143, 3.0])
def test_a_clearance_that_one_way_does_not_tell_asks_for_turns_both_ways(least_tilt):
    assert said(least_tilt, False) == (
        "clearance (D - d): told from friction, tilt and biases best while the peg turns both "
        "ways about its axis, which it did not: record turns both ways below 2 times gamma0"
    )


@pytest.mark.parametrize("least_tilt", [1.04, 1.996, 2.0, 2.004, 2.006, 3.0])
def test_a_clearance_is_never_told_to_need_what_the_recording_has(least_tilt):
    line = said(least_tilt, True)
    shown = float(re.search(r"([\d.]+) times", line)[1])
    assert shown == pytest.approx(least_tilt, abs=0.005)
    far = f"no nearer to gamma0 than {shown:.2f} times; record such turns below 2 times gamma0"
    near = f"came to {shown:.2f} times gamma0; record such turns for longer"
    assert line.endswith(far if shown > NEAR else near)


@pytest.mark.parametrize("method", ["extended", "square_root", "unscented", "iterated"])
def test_a_bias_found_gives_a_configuration_that_the_filter_takes(method):
    start = Configuration()
    start = replace(start, filter=replace(start.filter, method=method))
    now = replace(start, wrench=replace(start.wrench, bias_force=(2.0, 0.0, 0.0)))
    # Known to 0.5 N, of a noise of 0.2 N.
    bias = Estimate("bias_force_x", "N", 0.0, 2.0, 1.02, 2.98, 2.0, True, "")
    found = Calibration(now, (bias,), 9.0, 3.0, 0.0, 0.0, 300, 0.6, 1.2, 1.15, True)
    values = to_parameters(start) | parameters(found, to_parameters(start))
    assert from_parameters(values).wrench.bias_force == (2.0, 0.0, 0.0)
    told = "carries no uncertain bias" in heading(found, "a.mcap", "the defaults")
    if method == "extended":
        assert values["wrench.bias_force_stddev"] == pytest.approx(0.5) and not told
    else:
        assert values["wrench.bias_force_stddev"] == 0.0 and told
