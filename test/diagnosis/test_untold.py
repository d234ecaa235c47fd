"""What a motion does not tell is said with its cost: that of putting the offset in."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.diagnosis.tuned import UNOBSERVABLE_TEST
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import UNOBSERVABLE_SETTINGS, WrenchSample
from peg_on_hole_ros.replay.run import stored_configuration
from recorded_faults import BAGS, samples

JAM, SLIP, CYCLE = BAGS
WRONG = "friction seems to be"
NUMBER = re.compile(r"\d+\.?\d*(?:e-?\d+)?")


def as_it_is(sample):
    return sample


def gamma(sample):
    if isinstance(sample, WrenchSample):
        return sample
    return sample._replace(position=(sample.position[0] + 2e-3, *sample.position[1:]))


def force_along(sample):
    if not isinstance(sample, WrenchSample):
        return sample
    return sample._replace(force=(*sample.force[:2], sample.force[2] + 5.0))


def torque(sample):
    if not isinstance(sample, WrenchSample):
        return sample
    return sample._replace(torque=(sample.torque[0], sample.torque[1] + 0.1, sample.torque[2]))


@cache
def played(bag, change=as_it_is, end=99.0, **scene):
    """Return the pipeline and its outputs by time [s]."""
    found = stored_configuration(Bag(bag))
    line = Pipeline(replace(found, scene=replace(found.scene, **scene)))
    outputs = list(line.play(map(change, samples(bag, 0.0, end))))
    return line, {round((each.t_ns - outputs[0].t_ns) * 1e-9, 3): each for each in outputs}


@pytest.mark.parametrize("bag", [JAM, SLIP], ids=lambda bag: bag.stem)
@pytest.mark.parametrize("t", [0.3, 0.45])
def test_no_motion_tells_an_encoder_that_is_off_and_its_cost_is_right(bag, t):
    clean, off = (played(bag, change)[1] for change in (as_it_is, gamma))
    moved = np.abs(off[t].normal - clean[t].normal).max()
    assert moved == pytest.approx(clean[t].monitor["doubt_gamma"], rel=0.3)


@pytest.mark.parametrize("t", [0.3, 0.45, 0.6])
def test_a_force_along_the_peg_without_slip_is_taken_for_friction_at_its_cost(t):
    clean, off = (played(JAM, change)[1] for change in (as_it_is, force_along))
    moved = np.abs(off[t].normal - clean[t].normal).max()
    assert off[t].contact_mode == "three_point"
    assert moved == pytest.approx(clean[t].monitor["doubt_force_along"], rel=0.4)


def test_slip_tells_that_force_in_time():
    told = played(SLIP)[1]
    costs = [told[t].monitor["doubt_force_along"] for t in (0.2, 0.4, 0.6)]
    assert costs[0] > costs[1] > costs[2]
    assert costs[2] < 0.5 * played(JAM)[1][0.6].monitor["doubt_force_along"]


def test_a_motion_in_all_directions_tells_all():
    told = played(CYCLE, end=5.5)[1]
    begun, later = (
        {name: told[t].monitor[f"doubt_{name}"] for name in UNOBSERVABLE_SETTINGS}
        for t in (1.6, 5.4)
    )
    assert max(begun.values()) > 8.0 and max(later.values()) < 1.5
    # In the air there are no reactions that it could cost.
    assert not any(key.startswith("doubt_") for key in told[0.5].monitor)


def test_what_is_stated_takes_the_place_of_what_is_typical():
    usual, surer = (played(JAM, end=0.4, **scene)[1] for scene in ({}, {"friction_stddev": 0.02}))
    costs = [told[0.35].monitor["doubt_friction"] for told in (usual, surer)]
    assert costs[1] == pytest.approx(0.4 * costs[0], rel=0.25)


def test_a_friction_that_what_is_stated_refutes_is_told():
    line, _ = played(JAM, torque)
    assert [cause for cause in line.causes if WRONG in cause]
    for bag in (JAM, SLIP):
        assert played(bag)[0].causes == []
    # Nothing is learnt, and so nothing refuted.
    assert not [c for c in played(JAM, torque, friction_stddev=0.0)[0].causes if WRONG in c]


def test_how_far_off_a_friction_is_told_is_how_far_off_it_was_tested():
    (text,) = (cause for cause in played(JAM, torque)[0].causes if WRONG in cause)
    learnt, stddev, at, stated, off = map(float, NUMBER.findall(text)[:5])
    # Of a Gaussian: what is learnt lies off by as much of its variance as it has taken away.
    assert off == pytest.approx(abs(learnt - at) / (stated**2 - stddev**2) ** 0.5, abs=0.1)
    # It is told from a likelihood ratio on, which is half of its square.
    assert 0.5 * off**2 > 0.99 * UNOBSERVABLE_TEST.refuted


def test_the_summary_has_it_in_words(tmp_path, capsys):
    assert main(["replay", str(JAM)]) == 0
    (line,) = (
        x
        for x in capsys.readouterr().out.splitlines()
        if x.startswith("settings that this motion cannot")
    )
    assert "a force along the peg of 5 N: " in line and "gamma by 2 mrad: " in line
