"""What a live page is told of a node, whatever arrives together."""

import numpy as np
import pytest

from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.records import ANGLES, CONTACTS
from peg_on_hole_ros.watch.page_updates import WHOLE, PageUpdates

MS = 1_000_000
SCENE = Scene()


def state(k):
    return _message(k, ANGLES, [0.2 - 1e-3 * k, 0.0, 0.0], [])


def contacts(k, load):
    return _message(k, CONTACTS, [1.0] * 3, [load, 20.0, 20.0])


def _message(k, names, position, effort):
    fields = {"name": list(names), "position": position, "velocity": [], "effort": effort}
    return Encoder(JOINTS_TYPE)({"header": header(k * MS), **fields})


def told(frames, **arrived):
    none = dict.fromkeys((*WHOLE, "contact_mode", "alarms"), [])
    return frames.frame(none | arrived, {}, SCENE)


@pytest.mark.parametrize("together", [True, False])
def test_no_load_is_lost_where_it_arrives_after_its_state(together):
    """A slow sensor's wrench, or the last one: no other state comes beside its contacts."""
    frames = PageUpdates()
    for k in range(1, 6):
        load = 30.0 + k
        if together:
            told(frames, state=[state(k)], contacts=[contacts(k, load)])
            continue
        told(frames, state=[state(k)])
        last = told(frames, contacts=[contacts(k, load)])
        assert last["lines"]["K"] == [[pytest.approx((k - 1) * 1e-3), load]]
    loads = [v for frame in frames.kept for _, v in frame["lines"].get("K", [])]
    assert loads == [31.0, 32.0, 33.0, 34.0, 35.0]
    # And what is drawn is of both, in every frame from the first load on.
    drawn = [frame["moment"] for frame in list(frames.kept)[1:]]
    assert all(moment["K"] is not None and moment["gamma"] is not None for moment in drawn)


def test_nothing_is_told_before_the_first_state():
    frames = PageUpdates()
    assert "t" not in told(frames, contacts=[contacts(1, 30.0)])
    assert told(frames, state=[state(2)])["anew"]


def test_stamps_that_fall_begin_anew_without_the_loads_of_before():
    frames = PageUpdates()
    told(frames, state=[state(100)], contacts=[contacts(100, 30.0)])
    begun = told(frames, state=[state(1)])
    assert begun["anew"] and len(frames.kept) == 1
    assert begun["moment"]["K"] is None
    assert np.isclose(begun["moment"]["gamma"], 0.199)
