"""
What a robot program on soft springs met in the loop (docs/loop.md), with a truth of our own.

Two of its kinds have no truth here. The blow of an arm that lands or hops is that of the arm's
mass, and the holder has none. An edge that stands on the rim is followed down to gamma0 only.
"""

from functools import cache

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate

ERROR = 2
HOLDER = {
    "stiffness": 4e3, "rotational_stiffness": 150.0, "force_limit": 1500.0, "torque_limit": 60.0,
}  # fmt: skip
CLOSING = [-0.15, 0.0, 0.0]
LIMIT = 200.0


@cache
def moved(kind):
    """Return the truth of a kind of motion; the springs are led across the hole and along it."""
    clearance, friction, lead_in, start, phases = {
        "laid_aside": (179e-6, 0.13, 0.0, {"offset": [0.0, 0.0, 0.004]}, {
            "approach": {"kind": "free", "duration": 0.3, "offset": [0.0, 0.0, 0.0]},
            "aside": {"kind": "contact", "duration": 0.3, "offset": [-0.003, 0.0, -0.002]},
            "on": {"kind": "contact", "duration": 0.2, "offset": [-0.003, 0.0, -0.004]},
        }),
        "sticks_on_the_rim": (
            40e-6, 0.45, 0.05,
            {"angles": [0.12, 0.0, 0.0], "rates": CLOSING, "offset": [-0.001, 0.0, -0.004]},
            {
                "close": {"kind": "contact", "duration": 0.5, "rates": CLOSING},
                "on": {"kind": "contact", "duration": 0.2},
                "push": {"kind": "contact", "duration": 0.3, "offset": [0.0, 0.0, -0.006]},
            },
        ),
        "misses_K": (
            40e-6, 0.457, 0.1,
            {"angles": [0.12, 0.0, 0.0], "rates": CLOSING, "offset": [0.003, 0.0, -0.002]},
            {"close": {"kind": "parted", "duration": 0.6, "rates": CLOSING}},
        ),
        "falls_in": (
            49e-6, 0.16, 0.05,
            {"angles": [0.115, 0.0, 0.0], "rates": [-0.3, 0, 0], "offset": [-0.003, 0.0, -0.004]},
            {
                "close": {"kind": "contact", "duration": 0.2, "rates": [-0.3, 0.0, 0.0]},
                "through": {"kind": "insert", "duration": 0.1, "angles": [0.034, 0.0, 0.0],
                            "rates": [-0.3, 0.0, 0.0]},
                "fall": {"kind": "insert", "duration": 0.03, "angles": [5e-4, 0.0, 0.0],
                         "depth": 0.010, "depth_rate": 0.1},
            },
        ),
    }[kind]  # fmt: skip
    told = from_parameters({
        "scene.hole_diameter": 0.050, "scene.peg_diameter": 0.050 - clearance,
        "scene.friction": friction, "scene.friction_stddev": 0.1,
        "monitor.max_normal": [LIMIT] * 3, "wrench.bias_force_stddev": 0.01,
    })  # fmt: skip
    start = {"angles": [0.2, 0.0, 0.0], **start}
    return integrate(plan_from_tree(
        told, {"lead_in": lead_in, "holder": HOLDER, "start": start, "phases": phases}
    ))  # fmt: skip


def played(kind, tilt_off=0.0, **stated):
    """Return times [s], outputs, and the index of each in the truth; friction is stated wrong."""
    truth = moved(kind)
    of = truth.plan.configuration
    told = from_parameters({
        "scene.hole_diameter": of.scene.hole_diameter,
        "scene.peg_diameter": of.scene.peg_diameter, "scene.friction": 0.25,
        "scene.friction_stddev": 0.1, "monitor.max_normal": [LIMIT] * 3,
        "wrench.bias_force_stddev": 0.01, **stated,
    })  # fmt: skip

    def leaning(sample):
        if not isinstance(sample, JointSample):
            return sample
        gamma, *others = sample.position
        return sample._replace(position=(gamma + tilt_off, *others))

    rows = list(Pipeline(told).play(map(leaning, measure(truth, 1))))
    t_ns = np.array([row.t_ns for row in rows]) - START_NS
    return t_ns * 1e-9, rows, np.searchsorted(truth.t_ns, t_ns)


def levels(rows, alarm):
    return np.array([row.alarms[alarm].level for row in rows])


def modes(rows):
    return np.array([row.contact_mode for row in rows])


def determined(rows):
    return np.array([row.monitor.get("reactions_determined", 0.0) for row in rows])


def test_a_peg_that_is_laid_aside_on_the_rim_is_on_three_contacts_and_no_alarm():
    """Friction locks forces between K and B that no wrench shows: none is determined at rest."""
    t, rows, at = played("laid_aside")
    truth = moved("laid_aside")
    assert truth.normal.max() < LIMIT and truth.normal[-1].min() > 20.0
    # It carries 8 N 90 ms after it touches: the springs are led there from 0 N.
    assert set(modes(rows)[t > 0.4]) == {"three_point"}
    assert not any(row.transition for row in rows)
    assert {alarm.level for row in rows for alarm in row.alarms} == {0}
    assert determined(rows).max() == 0.0


def test_a_closing_that_ends_stuck_on_the_rim_is_alarmed_while_it_still_slides():
    """Friction is 0.45, and stated as 0.25 +- 0.1."""
    t, rows, at = played("sticks_on_the_rim")
    truth = moved("sticks_on_the_rim")
    rate = np.abs(truth.rates[at, 0])
    stops = t[(rate < 0.01) & (t > 0.1)][0]
    assert truth.q[-1, 0] > truth.plan.configuration.scene.gamma0
    jamming = levels(rows, 0)
    # An arm that stops within 30 ms stops in time.
    assert t[jamming == ERROR][0] < stops - 0.03
    assert (jamming[t > t[jamming == ERROR][0]] == ERROR).all()
    assert set(modes(rows)[t > 0.05]) == {"three_point"}
    assert not any(row.transition for row in rows)


def test_an_edge_that_stands_on_the_rim_while_K_is_open_is_no_three_contacts():
    t, rows, at = played("misses_K")
    assert moved("misses_K").normal[:, 0].max() == 0.0
    assert set(modes(rows)[t > 0.05]) == {"unknown"}
    assert not any(row.transition for row in rows)
    assert determined(rows).max() == 0.0
    # Nothing is learnt from what is no contact that the equations have.
    assert rows[-1].friction_stddev > 0.09


def test_nor_is_it_in_the_hole_where_the_direction_of_the_hole_is_uncertain():
    _, rows, _ = played("misses_K", tilt_off=-0.008, **{"joints.hole_tilt_stddev": 0.0043})
    assert "two_point" not in modes(rows)
    assert not any(row.transition for row in rows)


@pytest.mark.xfail(strict=True, reason="a peg that K does not touch is told that it wedges")
def test_nor_does_it_wedge():
    _, rows, _ = played("misses_K")
    assert levels(rows, 0).max() < ERROR


def test_a_peg_that_falls_into_the_hole_is_told_at_once_and_its_load_before():
    t, rows, at = played("falls_in")
    truth = moved("falls_in")
    below = truth.t_ns[truth.q[:, 0] < truth.plan.configuration.scene.gamma0][0] * 1e-9
    over = truth.t_ns[truth.normal.max(axis=1) > LIMIT][0] * 1e-9
    # K is pressed on over 50 ms while B opens.
    assert t[levels(rows, 2) == ERROR][0] < over - 0.03
    flagged = t[[row.transition for row in rows]][0]
    assert abs(flagged - below) < 0.01
    inside = modes(rows)[t > below + 0.02]
    assert set(inside) == {"two_point"}
