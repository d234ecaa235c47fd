"""The noise of a wrench: each member has the interface, and the registry multiplies factors."""

from importlib import import_module
from typing import get_type_hints

import numpy as np
import pytest

from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.measurements.freshness import Oriented
from peg_on_hole_ros.measurements.wrench_noise import registry
from peg_on_hole_ros.measurements.wrench_noise.received import Received
from peg_on_hole_ros.measurements.wrench_noise.registry import WrenchNoise
from peg_on_hole_ros.typed_record import new

MEMBERS = {
    name: import_module(f"peg_on_hole_ros.measurements.wrench_noise.{name}")
    for name in get_type_hints(WrenchNoise)
}
STDDEV = np.array([0.2] * 3 + [0.005] * 3)
SETTINGS = default_settings()


def followed(wrenches, tilt_rate=0.0):
    """Return what is found of wrenches at 1 kHz of a peg in the air that turns so fast [rad/s]."""
    noise, oriented = new(WrenchNoise), new(Oriented)
    registry.forget(noise)
    oriented.variance = 1e-8
    for k, wrench in enumerate(wrenches):
        oriented.q[0] = 0.1 + tilt_rate * 1e-3 * k
        registry.follow(noise, Received(k * 10**6, wrench, STDDEV**2, True, oriented, SETTINGS))
    return noise


def drawn(count, times=1.0, each=1):
    """Return wrenches with so many times the stated noise, each of them sent so many times."""
    values = np.random.default_rng(7).normal(size=(count, 6)) * STDDEV * times
    return np.repeat(values, each, axis=0)


def off(noise):
    return {name for name, member in MEMBERS.items() if member.is_off(getattr(noise, name))}


@pytest.mark.parametrize("name", MEMBERS)
def test_each_member_takes_a_wrench_as_stated_until_it_shows_otherwise(name):
    noise = new(WrenchNoise)
    state, member = getattr(noise, name), MEMBERS[name]
    member.forget(state)
    received = Received(0, drawn(1)[0], STDDEV**2, True, new(Oriented), SETTINGS)
    for _ in range(2):
        assert member.factor(state) == 1.0 and not member.is_off(state)
        assert member.causes(state, STDDEV**2) == []
        member.follow(state, received)
    assert registry.factor(followed(drawn(300))) == 1.0


def test_factors_are_multiplied_and_every_cause_is_reported():
    noise = followed(drawn(300, times=3.0, each=4))
    factors = {name: member.factor(getattr(noise, name)) for name, member in MEMBERS.items()}
    assert factors["repeated"] == 4.0 and factors["rough"] == pytest.approx(9.0, rel=0.4)
    assert registry.factor(noise) == np.prod(list(factors.values()))
    causes = registry.causes(noise, STDDEV**2)
    assert [cause.partition(":")[0] for cause in causes] == [
        "wrench", "wrench.force_stddev", "wrench.torque_stddev",
    ]  # fmt: skip
    registry.forget(noise)
    # How often values come outlasts a motion, and so do the causes.
    assert registry.factor(noise) == 4.0 and registry.causes(noise, STDDEV**2) == causes
    registry.begin(noise)
    assert len(registry.causes(noise, STDDEV**2)) == 1


def test_a_wrench_that_repeats_the_one_before_is_followed_once():
    once, often = followed(drawn(300, times=3.0)), followed(drawn(300, times=3.0, each=4))
    assert MEMBERS["rough"].factor(once.rough) == MEMBERS["rough"].factor(often.rough)


def test_a_wrench_that_one_member_rejects_is_off():
    still = np.repeat(drawn(1), 200, axis=0)
    assert off(followed(still)) == set()
    turned = followed(still, tilt_rate=0.5)
    assert off(turned) == {"repeated"} and registry.is_off(turned)
    cut_off = drawn(300)
    cut_off[250:, 2] = 1.0
    ended = followed(cut_off)
    assert off(ended) == {"saturated"} and registry.is_off(ended)
    wild = followed(drawn(300, times=1000.0))
    assert off(wild) == {"rough"} and registry.is_off(wild)
    # What stands still is reported by `diagnosis.suspected.standing_wrench`.
    for noise in (ended, wild):
        assert len(registry.causes(noise, STDDEV**2)) > 0
