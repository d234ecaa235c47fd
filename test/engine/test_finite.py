"""What leaves is a number, or NaN where it says "not determined", wherever the peg goes."""

import re
from collections import Counter
from itertools import product
from math import isfinite, isinf, isnan

import numpy as np
import pytest

from inputs import joints, wrench
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.messages.beside_estimates import TOPICS
from peg_on_hole_ros.messages.stream import message_stream
from tiers import at_push, nightly

MS = 1_000_000
SETTINGS = {
    "default": {},
    "without modes": {"monitor.modes": False},
    "clearance learnt": {"scene.clearance_stddev": 1e-5},
    "clearance learnt, without modes": {"scene.clearance_stddev": 1e-5, "monitor.modes": False},
    "bias learnt": {"wrench.bias_force_stddev": 1.0, "joints.hole_tilt_stddev": 0.002},
    "quasi-static": {
        "filter.method": "quasi_static",
        "monitor.modes": False,
        "wrench.adopt_found": False,
    },
    "driven by the wrench": {"filter.method": "dde_driven"},
}


def numbers(value):
    """Yield every number in a message, and of its texts the words that are none."""
    if isinstance(value, dict):
        value = value.values()
    elif isinstance(value, (str, bytes)):
        # Texts have numbers too, those of key-values and those in sentences.
        if isinstance(value, str):
            yield from map(float, re.findall(r"\b(?:nan|inf)\b", value, re.IGNORECASE))
        return
    elif not isinstance(value, (list, tuple, np.ndarray)):
        yield value
        return
    for each in value:
        yield from numbers(each)


def sound(topic, message, determined):
    """Return whether a message has numbers, and NaN only where it is to have it."""
    if topic == "monitor":
        # A value that does not exist at present.
        return not any(map(isinf, numbers(message)))
    if topic.startswith("contact/") and not determined:
        wrench = list(numbers(message["wrench"]))
        return all(map(isnan, wrench)) or not any(wrench)
    if topic == "contacts" and not determined:
        effort = message["effort"]
        known = all(map(isfinite, numbers({**message, "effort": []})))
        # In the air nothing touches.
        return known and (all(map(isnan, effort)) or not any(effort))
    return all(map(isfinite, numbers(message)))


def closed(settings, rates, least, count=700, begin=0.1, seed=0, noise=1e-4, push=-4.0):
    """
    Return the topics that messages came on, and those with a number that is none, with counts.

    The peg closes at a constant rate [rad/s] and is held at the least tilt [rad], or goes on.
    """
    random = np.random.default_rng(seed)
    stream = message_stream(from_parameters(settings))
    seen, wrong = set(), Counter()
    for k in range(count):
        t_ns = 10_000_000_000 + k * MS
        gamma = max(begin + rates[0] * k * 1e-3, least)
        if k % 2 == 0:
            off = random.normal(0.0, noise, 3) / [1.0, np.sin(gamma), np.sin(gamma)]
            angles = np.array([gamma, 0.0, rates[1] * k * 1e-3]) + off
            stream.on_joints(joints(t_ns, *angles.tolist()))
        force = np.array([0.0, 0.0, push]) + random.normal(0.0, 0.2, 3)
        torque = np.array([0.0, 0.05, 0.0]) + random.normal(0.0, 0.005, 3)
        messages = stream.on_wrench(wrench(t_ns, force.tolist(), torque.tolist()))
        for told in (message for topic, _, message in messages if topic == "monitor"):
            said = dict(zip(told["name"], told["position"]))
            determined = said["reactions_determined"] == 1.0
        for topic, _, message in messages:
            seen.add(topic)
            wrong[topic] += not sound(topic, message, determined)
    return seen, {topic: count for topic, count in wrong.items() if count}


# gamma0 = 0.06326 rad: held just below, where noise goes through it both ways; closed through it.
@pytest.mark.parametrize(
    ("name", "least"),
    at_push(
        [("default", 0.0632), ("bias learnt", 0.0632), ("quasi-static", 0.005)],
        product(SETTINGS, (0.0632, 0.005)),
    ),
)
def test_a_slow_closing_through_gamma0_leaves_numbers_on_every_topic(name, least):
    seen, wrong = closed(SETTINGS[name], (-0.1, 0.0), least)
    assert wrong == {}
    without = SETTINGS[name].get("monitor.modes") is False
    silent = {"alarms", "alarm_level"} if without else set()
    # A try may end or not.
    assert seen | {"cycle"} == set(TOPICS) - silent


@pytest.mark.parametrize("seed", [*range(5), *nightly(*range(5, 20))])
def test_whatever_a_slow_motion_does_about_gamma0(seed):
    random = np.random.default_rng(1000 + seed)
    settings = SETTINGS[random.choice(list(SETTINGS))] | {"scene.friction_stddev": 0.1}
    tilt_rate = -(10.0 ** random.uniform(-2.5, -0.3))
    turn = random.choice([0.0, 0.0, 10.0 ** random.uniform(-2.0, 0.5)])
    # Begun from above or below, so near that it gets there.
    begin = 0.06326 - tilt_rate * random.uniform(-0.1, 0.3)
    least = 0.06326 + random.choice([-1e-2, -1e-3, -1e-4, -1e-5, 1e-5])
    noise, push = 10.0 ** random.uniform(-5.0, -3.0), random.uniform(-30.0, 5.0)
    seen, wrong = closed(settings, (tilt_rate, turn), least, 500, begin, seed, noise, push)
    assert wrong == {}
    assert {"state", "contacts", "monitor"} <= seen
