"""Drawn insertions: that they are what their labels say, and that another engine agrees."""

import numpy as np
import pytest

from benchmarks.harness.player import Record
from benchmarks.insertion import engine as insertion_engine
from benchmarks.insertion import programs as insertion_programs
from benchmarks.insertion.estimates import engine_estimates, estimates_of
from benchmarks.insertion.labels import PUSHED, labels_of
from benchmarks.insertion.scenes import FAMILIES, Case, cases, plan_of
from peg_on_hole_ros.sim.truth import integrate
from tiers import nightly

pytestmark = pytest.mark.xdist_group("simulation")


def test_cases_are_three_hundred_and_drawn_again_the_same():
    chosen = cases()
    assert len(chosen) == 300 == len(set(map(str, chosen)))
    assert {case.family for case in chosen} == set(FAMILIES)
    again = Case("freed", 3)
    assert plan_of(again) == plan_of(again) != plan_of(again._replace(set="tuning"))


@pytest.mark.parametrize("number", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_a_normal_insertion_is_never_stuck(number):
    truth = integrate(plan_of(Case("normal", number)))
    labels = labels_of(truth)
    assert labels.events == () and not labels.stuck.any()
    assert truth.place[-1, 2] > truth.plan.configuration.scene.hole_diameter
    assert labels.transition == pytest.approx(truth.events[0][0] * 1e-9, abs=2e-3)


@pytest.mark.parametrize("family, cause", [("wedged", "wedged"), *nightly(("jammed", "jammed"))])
def test_a_stuck_peg_is_pushed_and_rests(family, cause):
    truth = integrate(plan_of(Case(family, 0)))
    labels = labels_of(truth)
    assert [event.cause for event in labels.events] == [cause]
    rows = np.flatnonzero(labels.stuck)
    assert len(rows) > 200 and labels.push[rows].min() > PUSHED
    assert np.ptp(truth.place[rows, 2]) < 5e-5 * len(rows) * 1e-3
    assert not labels.events[0].freed


@pytest.mark.nightly
def test_a_freed_peg_goes_on():
    truth = integrate(plan_of(Case("freed", 1)))
    events = labels_of(truth).events
    assert events and events[0].freed
    stuck_at = np.interp(events[0].end, truth.t_ns * 1e-9, truth.place[:, 2])
    assert truth.place[-1, 2] > stuck_at + 1e-3


# Largest of tilt [rad]; of the loads, rms and mean of the difference over the mean load.
AGREE = (5e-5, 0.06, 0.01)
OTHERS = {
    # From gamma0 on up to 50 boxes touch at once, and the edge comes and goes.
    "goes_in": (4e-4, 0.08, 0.01),
    # Contacts give by 1 um for 100 N, those of a patch of boxes by less, 11 mm apart.
    "wedges": (3e-4, 0.02, 0.015),
    # Of a line it touches in one place at a time.
    "along_one_wall": (5e-5, 0.12, 0.01),
}


@pytest.mark.parametrize("name", insertion_programs.PROGRAMS)
def test_another_engine_agrees(name):
    """Its contacts vibrate while they slide: means are compared closely, rms values loosely."""
    found = insertion_engine.differences(name, insertion_programs.plan_of(name))
    tilt, rms, mean = OTHERS.get(name, AGREE)
    assert found["tilt"] < tilt and found["depth"] < 4e-5
    for what in ("rim", "edge"):
        assert abs(found[f"{what}_mean"]) < mean
        assert found[what] < rms


def test_what_a_wedge_locks_in_another_engine_locks_in_as_well():
    """Let go of and pushed by 12 N it stays; friction without a spring keeps more, and creeps."""
    plan = insertion_programs.plan_of("wedges")
    theirs = insertion_engine.engine_rows("wedges", plan.configuration.scene)
    (kept, change, moved), own = map(
        insertion_engine.locked_in, (theirs, insertion_engine.own_rows(plan))
    )
    assert 0.95 < kept < 1.05 and 0.85 < own[0] < kept
    assert -0.02 < change < 0.0 and abs(own[1]) < 0.005
    assert moved < 1e-6 and own[2] < 1e-6


@pytest.mark.parametrize(("name", "noise"), [("slides", 1.0), ("slides", 4.0), ("goes_in", 4.0)])
def test_reactions_of_another_engine_s_insertion_are_known(name, noise):
    """
    It slides on two points, turning; one goes through the transition before.

    Where the edge comes and goes, loads jump by 2.5 N from one 2 ms to the next: that is stated
    as noise of the wrench, for both alike.
    """
    found, record = engine_estimates(name, noise)
    assert len(found.error) > 130 and (record.mode == "two_point").sum() > 130
    assert (found.rms < 0.10).all()
    assert (found.covered >= 0.80).all()


def test_errors_count_where_the_peg_slides_and_is_told_to():
    n = 1000
    t, slides = np.arange(n) * 1e-3, np.arange(n) < 900
    normal, friction = np.full((n, 2), 20.0), np.full(n, 0.2)
    mode = np.where(np.arange(n) < 100, "open", "two_point")
    told = np.tile([21.0, 8.0, 8.0], (n, 1))
    monitor = {"friction": np.full(n, 0.23), "friction_stddev": np.full(n, 0.01)}
    record = Record(
        t * 1e9, np.zeros((n, 6)), np.zeros((n, 6, 6)), told, np.full((n, 3), 1.5), mode, t > 0,
        {}, monitor,
    )  # fmt: skip
    found = estimates_of(record, t, slides, normal, friction)
    assert len(found.error) == 800 and len(found.friction) == 400
    assert found.rms == pytest.approx([0.05, 0.2])
    # N_B is known to twice what each of its halves is.
    assert found.covered.tolist() == [1.0, 1.0] and found.stddev[0].tolist() == [1.5, 3.0]
    assert found.friction == pytest.approx(np.full(400, 0.15))
    assert found.deviations == pytest.approx(np.full(400, 3.0))
