"""The sentence beside an alarm: followed in simulation it holds, and not followed it does not."""

import re
from functools import cache

import numpy as np
import pytest

from estimates import changed
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.options import Configuration, MonitorOptions, WrenchInput
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.beside_estimates import WRENCH
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.monitor.still_possible import possible
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.replay.run import (
    check_bag,
    replay_bag,
    sources_of,
    stored_configuration,
)
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.truth import integrate
from simulated import ROOT, contact_plan
from tiers import nightly

PRESS = np.array([-0.0005, 0.0, -0.001])
# No end by the holder, so that what is not followed can be seen to the end.
HOLDER = {"force_limit": 2e3, "torque_limit": 200.0}
ENCODE = Encoder(WRENCH)
CLOSING = [-0.16, 0.0, 0.0]
SAID = re.compile(
    r"at \d+ N of push: (?:push with at most (?P<share>\d+)%, )?(?:turn at (?P<turn>[\d.]+) rad/s"
    r"|(?P<on>continue this motion) and do not push harder), so that the load at K stays under "
    r"(?P<load>\d+) N$"
)


def configuration(limit, friction=0.2):
    scene = Scene(friction=friction, friction_stddev=0.05)
    wrench = WrenchInput(sensor_xyz=(0.0, 0.0, 0.07))
    return Configuration(scene, wrench, monitor=MonitorOptions(max_normal=(limit,) * 3))


def simulated(configuration, phases, rates=CLOSING):
    made = contact_plan(
        [0.16, 0.0, 0.0], rates, PRESS.tolist(), 0.0, configuration,
        {name: {"kind": "contact", **phase} for name, phase in phases.items()},
        holder=HOLDER, lead_in=0.1,
    )  # fmt: skip
    return integrate(made)


def alarms(truth, configuration):
    """Yield time [s] and alarms of every message of them."""
    stream = message_stream(configuration)
    for sample in measure(truth, 1):
        if not isinstance(sample, WrenchSample):
            stream.take_joints(sample)
            continue
        columns = stream.take_wrench(sample)
        for topic, _, fields in columns.messages(0) if columns else ():
            if topic == "alarms":
                yield (sample.t_ns - START_NS) * 1e-9, fields["status"]


def first_sentence(truth, configuration):
    """Return when the first is said, and what; the alarm itself has gone out before it."""
    raised = None
    for t, status in alarms(truth, configuration):
        messages = [alarm["message"] for alarm in status if alarm["level"] > 0]
        if raised is None and messages:
            raised = t
        said = [message for message in messages if " N of push: " in message]
        if said:
            # Two stamps, or the ERROR that came between them.
            assert raised is not None and 0.0005 < t - raised < 0.01
            return t, said[0].partition("; ")[2]
    raise AssertionError("no sentence")


@cache
def closed(limit):
    """A peg that wedges at 0.065 rad if nothing is done, and what the alarm says of it."""
    at = configuration(limit)
    truth = simulated(at, {"close": {"duration": 0.8, "rates": CLOSING}})
    return truth, *first_sentence(truth, at)


def followed(limit, t, turn, share=1.0):
    """Simulate the same until a time, and what is said from there on."""
    # The recording begins with the lead-in over.
    closing, turning = [-0.16, 0.0, 0.0], [-0.16, 0.0, turn]
    offset = (share * PRESS).tolist()
    return simulated(
        configuration(limit),
        {
            "close": {"duration": t + 0.1, "rates": closing},
            "begin": {"duration": max(0.15 * turn, 0.02), "rates": turning, "offset": offset},
            "turn": {"duration": 1.0, "rates": turning, "offset": offset},
        },
    )


@pytest.mark.parametrize("limit", [60.0, *nightly(200.0)])
def test_followed_the_load_stays_under_what_is_said_and_not_followed_it_does_not(limit):
    """A wedge ahead at a limit of 200 N; at 60 N the load comes first, and asks for less push."""
    truth, t, text = closed(limit)
    said = SAID.match(text)
    assert said, text
    turn, load = float(said["turn"]), float(said["load"])
    assert 0 < turn <= 2.0 and 0 < load <= limit
    share = int(said["share"]) / 100 if said["share"] else 1.0
    assert (share < 1.0) == (limit == 60.0)
    then = followed(limit, t, turn, share)
    after = then.t_ns * 1e-9 > t + 0.05
    assert then.ended_by == "transition" and after.sum() > 50
    assert np.all(then.normal[after].max(axis=0) < load)
    assert truth.ended_by == "jammed" and truth.normal.max() > max(limit, 1.5 * load)


@pytest.mark.nightly
@pytest.mark.parametrize("turns", [(0.3,), (0.05, 2.0)])
def test_what_no_turning_helps_is_said_to_be_lifted(turns):
    """A limit that even a tenth of the push passes; three turns are tried, none of them helps."""
    limit = 6.0
    _, t, text = closed(limit)
    expected = r"at \d+ N of push: no turning up to 2 rad/s keeps the limits, overload at K .*lift"
    assert re.match(expected, text), text
    for turn in turns:
        assert followed(limit, t, turn).normal.max() > limit


@pytest.mark.nightly
def test_a_push_that_grows_is_to_grow_no_more():
    """The motion is harmless at the push that there is: it is the push that raises the alarm."""
    limit, turning, growing = 300.0, [-0.05, 0.0, 0.1], [-0.0015, 0.0, -0.008]
    at = configuration(limit)
    steady = {"duration": 0.2, "rates": turning, "offset": PRESS.tolist()}
    more = {"duration": 0.6, "rates": turning, "offset": growing}
    truth = simulated(at, {"steady": steady, "more": more}, turning)
    t, text = first_sentence(truth, at)
    said = SAID.match(text.replace("at B2", "at K").replace("at B1", "at K"))
    assert said and said["on"], text
    assert truth.normal.max() > 2 * limit
    # The push as it is when it is said, and no more of it.
    k = int(np.searchsorted(truth.t_ns * 1e-9, t))
    pushed = -truth.contact_force[k].sum(axis=0)
    c, s = np.cos(truth.q[k, 1]), np.sin(truth.q[k, 1])
    held = (np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ pushed / 2e4).tolist()
    hold = {"duration": 1.5, "rates": turning, "offset": held}
    raised = {**more, "duration": 0.1, "offset": held}
    then = simulated(at, {"steady": steady, "more": raised, "hold": hold}, turning)
    assert then.ended_by in ("transition", "end")
    assert then.normal.max() < float(said["load"])


@pytest.mark.parametrize("mode", ["open", "two_point", "unknown"])
def test_nothing_is_advised_to_a_peg_that_is_not_on_three_contacts(mode):
    truth, t, _ = closed(60.0)
    at = configuration(60.0)
    samples = [each for each in measure(truth, 1) if each.t_ns - START_NS < t * 1e9]
    outputs = list(Pipeline(at).play(samples))[-1]
    assert outputs.contact_mode == "three_point" and possible(outputs, at)
    assert possible(changed(outputs, contact_mode=mode), at) == ""
    below = outputs.state.copy()
    below[0] = at.scene.gamma0
    assert possible(changed(outputs, state=below), at) == ""


def test_a_node_says_what_a_replay_says():
    """Bytes one after the other, as a node takes them, and a bag of many at once."""
    bag = Bag(ROOT / "bags" / "closing_without_slip.mcap")
    configuration = stored_configuration(bag)
    sources, names = sources_of(configuration), configuration.joints.names
    stream, live, replayed = message_stream(configuration), [], Heard()
    for item in bag.items(check_bag(bag, configuration), names):
        if sources[item.topic] == "joints":
            stream.take_joints(item.sample)
            continue
        wrench = {"force": xyz(item.sample.force), "torque": xyz(item.sample.torque)}
        fields = {"header": header(item.sample.t_ns), "wrench": wrench}
        published = stream.take_wrench_bytes(ENCODE(fields), lambda _, fields=fields: fields)
        live += [fields for topic, _, fields in published.beside if topic == "alarms"]
    replay_bag(bag, configuration, 10.0, [replayed])
    assert live == replayed.alarms
    said = {alarm["message"] for fields in live for alarm in fields["status"]}
    assert any(" N of push: " in message for message in said)


class Heard:
    """A sink of alarms."""

    def __init__(self):
        self.alarms = []

    def take(self, columns):
        for _, messages in columns.beside:
            self.alarms += [fields for topic, _, fields in messages if topic == "alarms"]
