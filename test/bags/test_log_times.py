"""Log times that cannot be are replaced; those that only look odd are left as they are."""

import pytest

from peg_on_hole_ros.bags.reader import Bag
from recorded import INPUTS, Row, joints, motion, wrench, write
from small_bags import MS

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
    # In chunks of six messages the jump cannot be told from wrong log times.
    bag = Bag(write(tmp_path / "b.mcap", rows, chunk_size=1000))
    assert sum(told(bag).values()) <= 6


def test_a_message_that_was_long_on_its_way_comes_when_it_came(tmp_path):
    rows = motion(5000, start=10_000 * SECOND)
    late = rows.pop(1000)
    rows.insert(4000, late._replace(log_ns=rows[3999].log_ns))
    bag = Bag(write(tmp_path / "a.mcap", rows))
    assert logs(bag) == [row.log_ns for row in rows]


def test_few_messages_tell_nothing(tmp_path):
    rows = [Row("/wrench", i, wrench(i * SECOND)) for i in (0, 50, 3)]
    assert logs(Bag(write(tmp_path / "a.mcap", rows))) == [0, 3, 50]
