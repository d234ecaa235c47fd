"""Log times that cannot be are replaced; those that only look odd are left as they are."""

from itertools import product

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer

from peg_on_hole_ros.bags.reader import Bag
from recorded import INPUTS, STORE, Row, joints, motion, wrench, write
from small_bags import MS
from tiers import at_push, nightly

SECOND = 10**9


def logs(bag):
    return [item.log_ns for item in bag.items(INPUTS)]


def told(bag):
    return {name: info.wrong_log_times for name, info in bag.topics.items()}


@pytest.mark.parametrize("wrong", [0, 2**63, 2**64 - 5000, 3600 * SECOND])
@pytest.mark.parametrize("chunk_size", [1000, 20_000, 1 << 20])
def test_wrong_log_times_are_placed_by_the_stamp(tmp_path, wrong, chunk_size):
    rows = motion(600, start=10_000 * SECOND)
    # A transport that takes 3 ms.
    rows = [row._replace(log_ns=row.log_ns + 3 * MS) for row in rows]
    expected = [row.log_ns for row in rows]
    for i in (*range(300, 303), 500, len(rows) - 1):
        rows[i] = rows[i]._replace(log_ns=wrong + i if wrong else 0)
    bag = Bag(write(tmp_path / "a.mcap", rows, chunk_size=chunk_size))
    assert logs(bag) == expected
    assert sum(told(bag).values()) == 5
    info = bag.topics["/wrench"]
    assert (info.first_ns, info.last_ns) == (expected[1], expected[-1])
    (line,) = bag.remarks(INPUTS)
    assert line.startswith("log time: 5 messages (")


def third(rows):
    return [i % 3 == 0 for i in range(len(rows))]


def second_wrench(rows):
    found = np.cumsum([row.topic == "/wrench" for row in rows])
    return [row.topic == "/wrench" and n % 2 == 0 for row, n in zip(rows, found.tolist())]


def at_random(rows):
    return (np.random.default_rng(7).random(len(rows)) < 0.3).tolist()


def scattered(rows, which, low, high):
    draw = np.random.default_rng(8).integers(low, high, len(rows), endpoint=True).tolist()
    return [row._replace(log_ns=t) if it else row for row, t, it in zip(rows, draw, which)]


@pytest.mark.parametrize(
    ("chunk_size", "between", "which"),
    at_push(
        [(1000, (0, 9998 * SECOND), at_random), (1 << 20, (0, 0), third)],
        product((1000, 1 << 20), ((0, 0), (0, 9998 * SECOND)), (third, second_wrench, at_random)),
    ),
)
def test_wrong_log_times_do_not_vouch_for_one_another(tmp_path, which, between, chunk_size):
    rows = motion(3000, start=10_000 * SECOND)
    rows = [row._replace(log_ns=row.log_ns + 3 * MS) for row in rows]
    wrong = which(rows)
    path = write(tmp_path / "a.mcap", scattered(rows, wrong, *between), chunk_size=chunk_size)
    bag = Bag(path)
    assert logs(bag) == [row.log_ns for row in rows]
    assert sum(told(bag).values()) == sum(wrong)


@pytest.mark.parametrize("run", [slice(-150, None), slice(150), slice(1000, 2600)])
@pytest.mark.parametrize("chunk_size", [1 << 20, *nightly(1000)])
def test_a_run_of_log_times_that_were_never_set(tmp_path, run, chunk_size):
    rows = motion(3000, start=10_000 * SECOND)
    rows = [row._replace(log_ns=row.log_ns + 3 * MS) for row in rows]
    expected = [row.log_ns for row in rows]
    rows[run] = [row._replace(log_ns=0) for row in rows[run]]
    bag = Bag(write(tmp_path / "a.mcap", rows, chunk_size=chunk_size))
    assert logs(bag) == expected
    assert sum(told(bag).values()) == len(rows[run])


@pytest.mark.parametrize("which", [third, second_wrench, at_random])
def test_wrong_log_times_in_sqlite(tmp_path, which):
    rows = motion(3000, start=10_000 * SECOND)
    wrong = which(rows)
    folder = tmp_path / "rec"
    with Rosbag2Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as out:
        topics = {name: out.add_connection(name, t, typestore=STORE) for name, t in INPUTS.items()}
        for row in scattered(rows, wrong, 0, 0):
            out.write(topics[row.topic], row.log_ns, row.data)
    bag = Bag(folder)
    assert logs(bag) == [row.log_ns for row in rows]
    assert sum(told(bag).values()) == sum(wrong)


@pytest.mark.parametrize("chunk_size", [1000, 1 << 20])
def test_wrong_log_times_where_the_clock_jumped(tmp_path, chunk_size):
    """On either side of a jump a message is placed with those about it."""
    rows = motion(2000, start=10_000 * SECOND)
    seam = 1000
    rows[seam:] = [row._replace(log_ns=row.log_ns + 60 * SECOND) for row in rows[seam:]]
    wrong = third(rows)
    path = write(tmp_path / "a.mcap", scattered(rows, wrong, 0, 0), chunk_size=chunk_size)
    found = logs(Bag(path))
    apart = [i for i, row in enumerate(rows) if found[i] != row.log_ns]
    assert all(abs(i - seam) <= 32 for i in apart)


@pytest.mark.parametrize("apart", [0.02, 1.0, 30.0])
def test_a_bag_that_was_played_slowly_is_in_order(tmp_path, apart):
    rows = motion(1500, start=10_000 * SECOND)
    rows = [row._replace(log_ns=row.log_ns + round(i * apart * 1e9)) for i, row in enumerate(rows)]
    bag = Bag(write(tmp_path / "a.mcap", rows, chunk_size=20_000))
    assert logs(bag) == [row.log_ns for row in rows] and not sum(told(bag).values())


def test_wrong_log_times_outside_chunks(tmp_path):
    rows = motion(100, start=10_000 * SECOND)
    expected = [row.log_ns for row in rows]
    rows[40] = rows[40]._replace(log_ns=0)
    assert logs(Bag(write(tmp_path / "a.mcap", rows, use_chunking=False))) == expected


@pytest.mark.parametrize("stamp", [0, 7 * SECOND, 20_000 * SECOND])
@pytest.mark.parametrize("share", [1, 10, 3])
def test_wrong_stamps_leave_the_order_as_it_is(tmp_path, stamp, share):
    rows = motion(600, start=10_000 * SECOND)
    rows = [
        row if i % share else row._replace(data=wrench(stamp) if i % 3 else joints(stamp))
        for i, row in enumerate(rows)
    ]
    bag = Bag(write(tmp_path / "a.mcap", rows, chunk_size=9000))
    assert logs(bag) == [row.log_ns for row in rows] and not sum(told(bag).values())


@pytest.mark.parametrize("seconds", [1, 4, 3600])
def test_a_clock_of_another_time_a_loop_and_a_pause_are_no_wrong_log_times(tmp_path, seconds):
    rows = motion(600, start=10_000 * SECOND)
    later = seconds * SECOND
    shifted = [row._replace(log_ns=row.log_ns + later) for row in rows]
    clocks = [
        row._replace(data=wrench(row.log_ns + later)) if row.topic == "/wrench" else row
        for row in rows
    ]
    paused = motion(600, start=10_000 * SECOND + later)
    for i, bag in enumerate((clocks, rows + shifted, rows + paused)):
        path = write(tmp_path / f"{i}.mcap", bag, chunk_size=9000)
        found = Bag(path)
        assert logs(found) == sorted(row.log_ns for row in bag)
        assert not sum(told(found).values()) and not found.remarks(INPUTS)


@pytest.mark.parametrize("seconds", [-3600, 4, 3600])
def test_a_recorder_whose_own_clock_jumps(tmp_path, seconds):
    rows = motion(600, start=10_000 * SECOND)
    rows[450:] = [row._replace(log_ns=row.log_ns + seconds * SECOND) for row in rows[450:]]
    bag = Bag(write(tmp_path / "a.mcap", rows))
    assert logs(bag) == sorted(row.log_ns for row in rows) and not sum(told(bag).values())
    bag = Bag(write(tmp_path / "b.mcap", rows, chunk_size=1000))
    assert not sum(told(bag).values())


def test_a_message_that_was_long_on_its_way_comes_when_it_came(tmp_path):
    rows = motion(5000, start=10_000 * SECOND)
    late = rows.pop(1000)
    rows.insert(4000, late._replace(log_ns=rows[3999].log_ns))
    bag = Bag(write(tmp_path / "a.mcap", rows))
    assert logs(bag) == [row.log_ns for row in rows]


def test_few_messages_tell_nothing(tmp_path):
    rows = [Row("/wrench", i, wrench(i * SECOND)) for i in (0, 50, 3)]
    assert logs(Bag(write(tmp_path / "a.mcap", rows))) == [0, 3, 50]
