"""Before the contacts tell frictions apart, one friction hypothesis stands for all."""

import numpy as np
import pytest

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.mechanics.scene import Scene

NOISE = np.diag([0.04] * 3 + [2.5e-5] * 3)
R = 1e-8 * np.eye(3)
WRENCH = np.array([8.0, 1.0, -30.0, 0.1, 0.4, 0.0])


def in_the_air(friction=0.2, stddev=0.05, **options):
    scene = Scene(friction=friction, friction_stddev=stddev)
    peg = ContactFilter(scene, FilterOptions(**options), NOISE)
    peg.start(np.array([0.2, 0.3, 0.1]), R)
    for _ in range(30):
        peg.predict(0.002)
        peg.correct(np.array([0.2, 0.3, 0.1]), R)
    return peg


def test_in_the_air_one_is_followed_and_in_contact_all():
    peg = in_the_air()
    assert peg.hypotheses == 1
    peg.weigh(WRENCH, ContactSet.NONE)
    assert peg.hypotheses == 1
    # Merged at once where they are alike, but never one.
    peg.weigh(WRENCH, ContactSet.THREE)
    assert 1 < peg.hypotheses <= Settings.friction_hypotheses


@pytest.mark.parametrize(("friction", "stddev"), [(0.2, 0.05), (0.05, 0.05), (0.02, 0.3)])
def test_it_has_the_mean_and_spread_of_all(friction, stddev):
    """Evenly spread frictions by their densities, each half a spacing wide, none below zero."""
    off = np.linspace(-Settings.reach, Settings.reach, Settings.friction_hypotheses)
    f = friction + off * stddev
    weight = np.where(f > 0.0, np.exp(-0.5 * off**2), 0.0)
    f, weight = np.maximum(f, 0.0), weight / weight.sum()
    mean = weight @ f
    wide = (0.5 * (off[1] - off[0]) * stddev) ** 2
    peg = in_the_air(friction, stddev, friction_noise=0.0)
    told, spread = peg.friction
    assert told == pytest.approx(mean, rel=1e-12)
    assert spread**2 == pytest.approx(weight @ (f - mean) ** 2 + wide, rel=1e-12)


def test_what_was_walked_in_the_air_is_in_each():
    """Friction that may wander has wandered by the touch, whoever stood for it."""
    still, walked = in_the_air(friction_noise=0.0), in_the_air(friction_noise=0.01)
    for peg in (still, walked):
        peg.weigh(WRENCH, ContactSet.NONE)
    grown = walked.friction[1] ** 2 - still.friction[1] ** 2
    # 0.06 s of 0.01 per root second.
    assert grown == pytest.approx(0.06 * 1e-4, rel=1e-6)
    for peg in (still, walked):
        peg.weigh(WRENCH, ContactSet.THREE)
    own, wider = (
        peg.mixture.P[:, FRICTION, FRICTION][peg.mixture.weight > 0.0].min()
        for peg in (still, walked)
    )
    # One wrench tells little of friction: most of it is left in each.
    assert 0.3 * grown < wider - own < 1.001 * grown


def test_a_restart_gathers_anew():
    peg = in_the_air()
    peg.weigh(WRENCH, ContactSet.THREE)
    peg.end_estimate()
    peg.start(np.array([0.2, 0.3, 0.1]), R)
    assert peg.hypotheses == 1
