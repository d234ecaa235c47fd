"""Arrays hold what a decoder reads field by field, whatever lies in the messages."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from peg_on_hole_ros.bags.batch import stretches
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.messages.decode import frame_of, joint_sample, wrench_sample
from recorded import INPUTS, Row, joints, motion, wrench, write
from small_bags import JOINTS, MS

number = st.floats(width=64)
text = st.sampled_from(["", "a", "ab", "abc", "tool0", "Grüße", "x" * 300])
stamp = st.integers(0, 2**31 - 1).map(lambda sec: sec * 10**9 + 5)


@st.composite
def any_wrench(draw):
    vector = st.tuples(number, number, number)
    return "/wrench", wrench(draw(stamp), draw(vector), draw(vector), draw(text))


@st.composite
def any_joints(draw):
    names = draw(st.lists(text, max_size=4))
    positions = draw(st.lists(number, min_size=len(names), max_size=len(names)))
    velocity = draw(st.sampled_from([(), (1.0,), (1.0, 2.0, 3.0)]))
    if draw(st.booleans()):
        positions = positions[:-1]
    return "/joint_states", joints(draw(stamp), positions, names, velocity, draw(text))


@st.composite
def spoilt(draw):
    topic, data = draw(any_wrench() | any_joints())
    data = bytearray(data)
    for _ in range(draw(st.integers(0, 3))):
        data[draw(st.integers(0, len(data) - 1))] = draw(st.integers(0, 255))
    return topic, bytes(data[: draw(st.integers(0, len(data)))])


def by_fields(bag):
    read = {"/wrench": wrench_sample, "/joint_states": joint_sample}
    return [
        (m.topic, m.log_ns, read[m.topic](m.message), frame_of(m.message))
        for m in bag.messages(INPUTS)
    ]


def exact(items):
    """Return them as text that keeps every bit, so that one NaN is another's equal."""
    return [repr(tuple(item)) for item in items]


@settings(max_examples=60, deadline=None)
@given(st.lists(any_wrench() | any_joints() | spoilt(), min_size=1, max_size=30))
def test_batches_hold_what_is_read_field_by_field(tmp_path_factory, messages):
    path = tmp_path_factory.mktemp("bag") / "a.mcap"
    rows = [Row(topic, i, data) for i, (topic, data) in enumerate(messages)]
    write(path, rows, chunk_size=500)
    one, other = Bag(path), Bag(path)
    assert exact(one.items(INPUTS)) == exact(by_fields(other))
    assert one.undecodable == other.undecodable


def test_efforts_are_read_where_they_are_asked_for(tmp_path):
    names = "K", "B1", "B2"
    rows = [
        Row("/joint_states", i, joints(i * MS, (1.0, 0.0, i), names, (0.5,), "hole", effort))
        for i, effort in enumerate([(10.0, 20.0, 30.0), (), (11.0, 21.0, 31.0), (1.0, 2.0)])
    ]
    bag = Bag(write(tmp_path / "a.mcap", rows))
    (batch,) = bag.batches({"/joint_states": JOINTS}, efforts=True)
    layouts = [batch.layouts[i] for i in batch.layout[:3]]
    assert [layout.efforts for layout in layouts] == [True, False, True]
    assert batch.values[0].tolist() == [1.0, 0.0, 0.0, 10.0, 20.0, 30.0]
    assert batch.values[1, :3].tolist() == [1.0, 0.0, 1.0]
    assert batch.values[2].tolist() == [1.0, 0.0, 2.0, 11.0, 21.0, 31.0]
    # Not as many as positions: read field by field.
    assert list(batch.others) == [3] and list(batch.others[3].effort) == [1.0, 2.0]
    (plain,) = bag.batches({"/joint_states": JOINTS})
    assert not plain.others and plain.values.shape == (4, 3)


def test_what_repeats_is_numbers_and_nothing_else_is(tmp_path):
    rows = motion(1000)
    batches = list(Bag(write(tmp_path / "a.mcap", rows, chunk_size=20_000)).batches(INPUTS))
    assert len(batches) > 5 and sum(map(len, batches)) == len(rows)
    assert not any(batch.others for batch in batches)
    (force,) = {batch.layouts[0].frame_id for batch in batches}
    assert force in ("sensor", "")
    z = np.concatenate([s.values[:, 2] for b in batches for _, s in stretches(b, "/wrench")])
    assert z == pytest.approx(-10.0 - 1e-3 * np.arange(1000), abs=1e-12)


def test_gaps_that_ros_fills_with_rubbish_do_not_matter(tmp_path):
    rng = np.random.default_rng(1)
    rows = []
    for i in range(200):
        data = bytearray(joints(i * MS, (0.1, 0.2, 0.3), ("g", "psi1", "phi")))
        # Behind "g\0" and "phi\0" and "psi1\0" CDR leaves bytes up to the next multiple of four.
        at = data.index(b"g\0") + 2
        data[at : at + 2] = rng.bytes(2)
        at = data.index(b"psi1\0") + 5
        data[at : at + 3] = rng.bytes(3)
        rows.append(Row("/joint_states", i, bytes(data)))
    (batch,) = Bag(write(tmp_path / "a.mcap", rows)).batches({"/joint_states": JOINTS})
    assert not batch.others and len(batch.layouts) == 1
    assert {item.sample.names for item in batch.items()} == {("g", "psi1", "phi")}


def test_what_fits_no_layout_is_read_by_the_decoder(tmp_path):
    big = b"\0\0\0\0" + struct.pack(">iII7sx", 1, 2, 7, b"sensor\0") + b"\0" * 4
    big += struct.pack(">6d", 1, 2, 3, 4, 5, 6)
    rows = [Row("/wrench", 0, wrench(MS)), Row("/wrench", 1, big), Row("/wrench", 2, big[:-1])]
    bag = Bag(write(tmp_path / "a.mcap", rows))
    (batch,) = bag.batches(INPUTS)
    assert list(batch.others) == [1] and bag.undecodable == {"/wrench": 1}
    assert [item.sample.force for item in batch.items()] == [(0, 0, -10), (1, 2, 3)]


def test_many_frames_and_names_are_many_layouts(tmp_path):
    rows = [Row("/wrench", i, wrench(i, frame=f"f{i % 40}")) for i in range(400)]
    rows += [
        Row("/joint_states", 400 + i, joints(i, (0.1,), (f"j{i % 40}",), frame=f"{i % 3}"))
        for i in range(400)
    ]
    bag = Bag(write(tmp_path / "a.mcap", rows))
    assert exact(bag.items(INPUTS)) == exact(by_fields(bag))


def test_a_long_message_is_read_by_the_decoder(tmp_path):
    # Of a message of fixed layout several times its bytes are kept, so a long one has none.
    rows = [
        Row("/wrench", 0, wrench(MS, frame="x" * 20_000)),
        Row("/wrench", 1, wrench(2 * MS, frame="y")),
    ]
    bag = Bag(write(tmp_path / "a.mcap", rows))
    (batch,) = bag.batches(INPUTS)
    assert list(batch.others) == [0] and [each.frame_id for each in batch.layouts] == ["y"]
    assert exact(bag.items(INPUTS)) == exact(by_fields(bag))
