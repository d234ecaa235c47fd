"""Messages that are taken many at once give what they give one by one, bit for bit."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from mcap.reader import make_reader

from late_samples import MS, SCENE, ordered, shuffled
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.replay import replay
from peg_on_hole_ros.config.options import NodeOptions
from peg_on_hole_ros.messages.stream import MessageStream
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.replay.run import replay_bag
from peg_on_hole_ros.report.inputs import Inputs
from peg_on_hole_ros.report.tracks import Tracks
from recorded import Row, joints, wrench, write
from simulated import truth
from tiers import at_push

AT = 240


def in_order(samples):
    return samples


def late(samples):
    return shuffled(samples, 3 * MS)


def silence(samples):
    return [s._replace(t_ns=s.t_ns + (1500 * MS if i > AT else 0)) for i, s in enumerate(samples)]


def set_back(samples):
    return [s._replace(t_ns=s.t_ns - (2500 * MS if i > AT else 0)) for i, s in enumerate(samples)]


def repeated(samples):
    return [s for i, s in enumerate(samples) for _ in range(1 + (i % 50 == 7))]


def ahead(samples):
    i = next(i for i in range(AT, len(samples)) if isinstance(samples[i], WrenchSample))
    return [*samples[:i], samples[i]._replace(t_ns=samples[i].t_ns + 900 * MS), *samples[i + 1 :]]


def not_finite(samples):
    return [
        s._replace(force=(np.nan, 0.0, 0.0)) if i % 60 == 11 and isinstance(s, WrenchSample) else s
        for i, s in enumerate(samples)
    ]


def many_orientations_ahead(samples):
    """More than may wait for the wrench of their time."""
    first = [s for s in samples if isinstance(s, JointSample)][0]
    more = [first._replace(t_ns=samples[-1].t_ns + k * MS) for k in range(700)]
    return [*samples[:AT], *more, *samples[AT:]]


def no_orientations(samples):
    return [s for i, s in enumerate(samples) if i < AT or isinstance(s, WrenchSample)]


def pushed_by_the_peg(samples):
    """The sign is wrong: in doubt nothing sure is told, then it is found."""
    return [
        s._replace(force=tuple(-f for f in s.force), torque=tuple(-m for m in s.torque))
        if isinstance(s, WrenchSample)
        else s
        for s in samples
    ]


def orientations_of_the_same_stamp_behind(samples):
    """Each joint state with the stamp of the wrench before it."""
    stamps, moved = None, []
    for s in samples:
        if isinstance(s, WrenchSample):
            stamps = s.t_ns
        elif stamps is not None:
            s = s._replace(t_ns=stamps)
        moved.append(s)
    return moved


def held_back(samples, by):
    """Joint states by(i) later than they are due, in their order."""
    arrival, last = [], 0
    for i, s in enumerate(samples):
        last = max(last + 1, s.t_ns + by(i)) if isinstance(s, JointSample) else last
        arrival.append(last if isinstance(s, JointSample) else s.t_ns)
    return [samples[i] for i in np.argsort(arrival, kind="stable")]


def joint_states_behind(samples):
    return held_back(samples, lambda i: 1_800_000)


def joint_states_far_behind(samples):
    """Some so far that they are dropped, where late ones are put in their places."""
    return held_back(samples, lambda i: (6 + 60 * (i % 200 > 190)) * MS)


def joint_states_behind_at_times(samples):
    """In bursts, as a network gives them."""
    return held_back(samples, lambda i: (9 - i % 9) * MS * (i // 90 % 2))


def joint_states_of_the_stamp_before(samples):
    """Late ones whose stamps are those of wrenches."""
    return held_back(orientations_of_the_same_stamp_behind(samples), lambda i: i % 3 * MS)


def pushed_by_the_peg_with_joint_states_behind(samples):
    return joint_states_behind(pushed_by_the_peg(samples))


def joint_states_behind_and_a_silence(samples):
    return joint_states_behind(silence(samples))


def joint_states_behind_and_wrenches_ahead(samples):
    return joint_states_behind(ahead(samples))


def ends_with_an_orientation_of_the_last_stamp(samples):
    last = [s for s in samples if isinstance(s, WrenchSample)][-1]
    behind = [s for s in samples if isinstance(s, JointSample)][-1]
    return [*samples, behind._replace(t_ns=last.t_ns)]


STREAMS = (
    ends_with_an_orientation_of_the_last_stamp,
    joint_states_behind,
    joint_states_far_behind,
    joint_states_behind_at_times,
    joint_states_of_the_stamp_before,
    pushed_by_the_peg_with_joint_states_behind,
    joint_states_behind_and_a_silence,
    joint_states_behind_and_wrenches_ahead,
    in_order,
    late,
    silence,
    set_back,
    repeated,
    ahead,
    not_finite,
    many_orientations_ahead,
    no_orientations,
    pushed_by_the_peg,
    orientations_of_the_same_stamp_behind,
)


def recording(samples, path):
    rows = []
    for i, s in enumerate(samples):
        data = (
            wrench(s.t_ns, s.force, s.torque)
            if isinstance(s, WrenchSample)
            else joints(s.t_ns, s.position, s.names)
        )
        topic = "/wrench" if isinstance(s, WrenchSample) else "/joint_states"
        rows.append(Row(topic, 10**9 + i * MS // 2, data))
    return write(path, rows)


def replayed(bag, configuration, path):
    content, _, doubts, *_ = replay(Bag(bag), configuration, NodeOptions(), path)
    with open(path, "rb") as file:
        reader = make_reader(file)
        statistics = reader.get_summary().statistics
        messages = [
            (channel.topic, message.log_time, message.data)
            for _, channel, message in reader.iter_messages(log_time_order=False)
        ]
    told = {key: value for key, value in content.items() if key != "realtime_factor"}
    return told, doubts, messages, statistics.channel_message_counts


# One of each way to leave the order; without a window there is no going back.
AT_PUSH = [
    (late, 0.05),
    (joint_states_far_behind, 0.05),
    (silence, 0.05),
    (pushed_by_the_peg_with_joint_states_behind, 0.05),
    (joint_states_behind, 0.0),
]


@pytest.mark.parametrize(
    ("stream", "window"),
    at_push(AT_PUSH, product(STREAMS, (0.05, 0.0))),
    ids=lambda value: getattr(value, "__name__", str(value)),
)
def test_in_one_go_is_as_one_by_one(stream, window, tmp_path, monkeypatch):
    configuration = truth(SCENE).plan.configuration
    kalman = replace(configuration.filter, late_window=window)
    topics = replace(configuration.topics, wrench="/wrench", joint_states="/joint_states")
    configuration = replace(configuration, filter=kalman, topics=topics)
    bag = recording(stream(ordered(450)), tmp_path / "in.mcap")
    taken = []

    def take(self, arrivals, begin, original=MessageStream.take):
        end, columns = original(self, arrivals, begin)
        taken.append(0 if columns is None else len(columns))
        return end, columns

    with monkeypatch.context() as patch:
        patch.setattr(MessageStream, "take", take)
        found = replayed(bag, configuration, tmp_path / "many.mcap")
    monkeypatch.setattr(MessageStream, "take", lambda self, arrivals, begin: (begin, None))
    assert found == replayed(bag, configuration, tmp_path / "one.mcap")
    # Without a window late joint states are used by another rule, one by one.
    by_itself = stream is late or (not window and "joint_states_" in stream.__name__)
    assert sum(taken) > 100 or by_itself


def drawn(bag, configuration):
    """Return what a report draws of the messages that came in."""
    tracks = Tracks()
    inputs = Inputs(configuration, tracks)
    replay_bag(Bag(bag), configuration, 0.0, [tracks, inputs], watch=inputs)
    return inputs.tables()


# Orientations of another time are far off the estimate, and what a wrong stamp draws ends sooner.
@pytest.mark.parametrize(
    "stream",
    at_push(
        (late, set_back),
        [s for s in STREAMS if s not in (ahead, many_orientations_ahead, no_orientations)],
    ),
)
def test_what_a_report_draws_of_the_input_is_the_same(stream, tmp_path, monkeypatch):
    configuration = truth(SCENE).plan.configuration
    topics = replace(configuration.topics, wrench="/wrench", joint_states="/joint_states")
    configuration = replace(configuration, topics=topics)
    bag = recording(stream(ordered(450)), tmp_path / "in.mcap")
    found = drawn(bag, configuration)
    monkeypatch.setattr(MessageStream, "take", lambda self, arrivals, begin: (begin, None))
    expected = drawn(bag, configuration)
    assert found.keys() == expected.keys()
    for name, table in expected.items():
        for column in table:
            np.testing.assert_array_equal(found[name][column], table[column])
    squared = expected["innovations"]["squared"]
    assert len(squared) > 100 and np.median(squared) < 4.0
