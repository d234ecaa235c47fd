"""Every number of the table of parameters at the edges of its range: refused, or it runs."""

from math import inf, nextafter

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import BY_NAME, from_parameters, node_options
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.records import ANGLES
from small_bags import joints, wrench
from tiers import nightly

MS = 1_000_000
NUMBERS = sorted(n for n, row in BY_NAME.items() if row.type[:6] in ("double", "intege"))


def edges(name):
    """Return the ends of a range, and the next to each, inside."""
    row = BY_NAME[name]
    if row.type == "integer":
        return [row.low, row.low + 1, row.high - 1, row.high]
    least, most = float(row.low), float(row.high)
    tiny = [5e-324, 1e-300] if least == 0.0 else [nextafter(least, inf)]
    return [least, *tiny, nextafter(most, -inf), most]


def plays(changed):
    """Play contact and free air through a stream; return how many wrenches gave an estimate."""
    parameters = {"scene.friction_stddev": 0.05} | changed
    try:
        configuration = from_parameters(parameters)
        rate = node_options(parameters).markers_rate
    except PegOnHoleError as error:
        # Another parameter that has its default contradicts it.
        assert str(error)
        return None
    stream, given = message_stream(configuration, rate), 0
    # Of a delay at its edge nothing is known of a wrench for so long.
    for k in range(40 + round(abs(configuration.joints.delay) * 1e3)):
        t_ns = 10**9 + k * MS
        stream.on_joints(joints(t_ns, (0.3 - 1e-4 * k, 1e-3 * k, 2e-3 * k)))
        told = stream.on_wrench(wrench(t_ns, (0.1 * k, 0.0, -10.0 if k < 30 else 4.9)))
        given += bool(told)
        for topic, _, fields in told:
            if topic == "state":
                assert np.isfinite(fields["position"]).all()
                assert fields["name"] == list(ANGLES)
    return given


def value_of(name, edge):
    row = BY_NAME[name]
    return [edge] * len(row.default) if row.type.endswith("[]") else edge


# Those that divide, or are rounded to whole numbers of something.
AT_PUSH = ["filter.late_window", "markers_rate", "monitor.mode_dwell", "scene.gravity"]


@pytest.mark.parametrize("name", [*AT_PUSH, *nightly(*(n for n in NUMBERS if n not in AT_PUSH))])
def test_a_number_at_its_edges_is_refused_or_runs(name):
    given = [plays({name: value_of(name, edge)}) for edge in edges(name)]
    assert all(each is None or each > 0 for each in given)


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_beyond_its_edges_is_refused_with_its_range(name):
    row = BY_NAME[name]
    for edge, away in ((row.low, -inf), (row.high, inf)):
        whole = row.type == "integer"
        beyond = edge + (1 if away > 0 else -1) if whole else nextafter(float(edge), away)
        for value in (beyond, *(() if whole else (away, float("nan")))):
            with pytest.raises(PegOnHoleError, match=name.replace(".", r"\.")):
                from_parameters({name: value_of(name, value)})
