"""What the stamps alone show: bursts, clocks that drift or were set, and nothing of jitter."""

import random

import pytest

from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from recorded import Row, joints, wrench, write
from recorded_faults import BAGS, from_zero, is_wrench
from tiers import nightly

MS = 1_000_000
# On three contacts from 1.2 s on; nothing is told of what comes before 0.1 s.
UNTIL = 3.6


def recorded(end=UNTIL):
    """Return samples of the working cycle, from stamp 0 on."""
    return from_zero(BAGS[2], end)


def stamped(found, change, of=is_wrench):
    """Return samples in their order of arrival, those of one kind with other stamps [ns]."""
    return [s._replace(t_ns=round(change(s.t_ns))) if of(s) else s for s in found]


def joint_stamps(found, change):
    return stamped(found, change, lambda sample: not is_wrench(sample))


def arriving(found, late):
    """Return samples in the order in which they arrive, so late each [ns]."""
    order = sorted(range(len(found)), key=lambda i: found[i].t_ns + late(found[i]))
    return [found[i] for i in order]


def heaps(count, period=MS):
    """Return what stamps wrenches on arrival, so many at a time, 20 us apart."""

    def at(t_ns):
        heap, place = divmod(round(t_ns / period), count)
        return (heap + 1) * count * period + place * 20_000

    return at


def played(found, **parameters):
    line = Pipeline(from_parameters(parameters))
    return line, list(line.play(found))


def told(found):
    return played(found)[0].causes


@pytest.mark.parametrize("count", [16, *nightly(4, 8)])
def test_bursts_are_told_with_their_size_and_period(count):
    found = stamped(recorded(), heaps(count))
    line, outputs = played(sorted(found, key=lambda sample: sample.t_ns))
    (cause,) = line.causes
    assert cause.startswith("wrench: wrenches come in bursts: on /wrench ")
    assert f" {count} within" in cause and f"every {count} ms" in cause
    assert "latency timer of a USB adapter" in cause
    # Contact begins at 1.2 s, and eight bursts take 0.13 s.
    assert not any(each.monitor["reactions_determined"] for each in outputs)
    assert line.counts["reactions_withheld"] > len(outputs) - 400
    # What rests on the tilt alone is told.
    assert outputs[-1].contact_mode == "three_point"


def test_bursts_that_end_withhold_nothing_more():
    at = heaps(16)
    found = stamped(recorded(), lambda t: at(t) if t < 800 * MS else t)
    line, outputs = played(sorted(found, key=lambda sample: sample.t_ns))
    assert len(line.causes) == 1
    assert outputs[-1].monitor["reactions_determined"] == 1.0


def test_jitter_is_no_burst_no_drift_and_no_step():
    """A thread that wakes up to 10 ms late, a network that takes up to 30 ms, or 40 at times."""
    rng = random.Random(7)
    wakes = [rng.choice((0, 0, 0, rng.randrange(10))) for _ in range(10_000)]

    def late(t_ns):
        return t_ns + wakes[round(t_ns / MS)] * MS

    jittered = stamped(recorded(), lambda t: max(late(t - i * MS) for i in range(10)) + t % 977)
    assert told(sorted(jittered, key=lambda sample: sample.t_ns)) == []
    way = [rng.expovariate(1 / 5.0) + 40.0 * (rng.random() < 0.01) for _ in range(10_000)]
    for of in (True, False):
        found = recorded()
        ways = {s.t_ns: way[round(s.t_ns / MS)] * MS for s in found}
        delayed = arriving(found, lambda s, of=of, ways=ways: ways[s.t_ns] * (is_wrench(s) == of))
        assert told(delayed) == []


def test_pairs_are_no_bursts():
    found = stamped(recorded(), heaps(2))
    assert told(sorted(found, key=lambda sample: sample.t_ns)) == []


@pytest.mark.parametrize("ppm", [5000, -5000, *nightly(2500, -2500)])
def test_a_clock_that_drifts_is_told_by_how_much(ppm):
    line, outputs = played(joint_stamps(recorded(), lambda t: t * (1 + ppm * 1e-6)))
    (cause,) = line.causes
    assert cause.startswith("clocks: the clock of /joint_states drifts: it goes ")
    size, unit, side = cause.split("it goes ")[1].split()[:3]
    # Blocks of a few hundred leads, each whole periods of a wrench.
    assert float(size) == pytest.approx(abs(ppm), rel=0.05) and unit == "ppm"
    assert side == ("fast" if ppm > 0 else "slow")
    # 5 ms apart takes one second, or two at half the rate; and eight blocks 1.6 s.
    assert not any(o.monitor["reactions_determined"] for o in outputs if o.t_ns > 2600 * MS)


def test_no_constant_delay_is_named_where_a_clock_drifts():
    line = Pipeline(from_parameters({}), offline=True)
    for _ in line.play(joint_stamps(recorded(6.0), lambda t: 1.005 * t)):
        pass
    assert len(line.causes) == 1 and "no constant joints.delay fits" in line.causes[0]


@pytest.mark.parametrize("milliseconds", [400, *nightly(-400, 80)])
def test_a_clock_of_the_joints_that_was_set_is_told(milliseconds):
    """And that it was set again: nothing is determined in between."""

    def ahead(t):
        return t + milliseconds * MS * (1500 * MS <= t < 2500 * MS)

    line, outputs = played(joint_stamps(recorded(), ahead))
    size = f"by {abs(milliseconds) / 1e3:g} s"
    assert [cause.split(", and that of")[0] for cause in line.causes] == [
        f"clocks: the clock of /joint_states was set {way} {size} at {at}"
        for way, at in zip(
            ("forward", "back") if milliseconds > 0 else ("back", "forward"),
            # By the wrench that came before it.
            ("1.499 s", "2.499 s"),
        )
    ]
    # 25 joint states come in 50 ms.
    between = [o for o in outputs if 1560 * MS < o.t_ns < 2500 * MS]
    assert between and not any(o.monitor["reactions_determined"] for o in between)


def test_clocks_that_were_both_set_back_are_told_as_that():
    found = stamped(recorded(), lambda t: t - 400 * MS * (t >= 2000 * MS), lambda s: True)
    (cause,) = told(found)
    assert cause.startswith(
        "clocks: the clocks of /wrench and /joint_states were set back by 0.4 s at 2.000 s"
    )


def test_a_recording_that_is_played_again_is_no_clock_that_was_set():
    found = recorded(0.7)
    assert told(found + found + found) == []


def test_what_is_lost_or_late_is_no_clock_that_was_set():
    lost = [s for s in recorded() if not 2000 * MS <= s.t_ns < 2300 * MS]
    assert told(lost) == []
    of_joints = [s for s in recorded() if is_wrench(s) or not 2000 * MS <= s.t_ns < 2300 * MS]
    assert told(of_joints) == []
    held = arriving(recorded(), lambda s: (2200 * MS - s.t_ns) * (2000 * MS <= s.t_ns < 2200 * MS))
    assert told(held) == []


def test_a_way_that_becomes_longer_is_no_clock_that_was_set():
    longer = arriving(recorded(), lambda s: 100 * MS * (not is_wrench(s) and s.t_ns >= 2000 * MS))
    assert told(longer) == []


def test_one_stamp_that_is_wrong_is_no_clock_that_was_set():
    found = joint_stamps(recorded(), lambda t: t + 300 * MS * (t == 2000 * MS))
    assert told(found) == []


def bag(path, found):
    rows = []
    for number, sample in enumerate(found):
        t_ns = 10**9 + sample.t_ns
        if is_wrench(sample):
            row = Row("/wrench", number * MS, wrench(t_ns, sample.force, sample.torque))
        else:
            row = Row("/joint_states", number * MS, joints(t_ns, sample.position))
        rows.append(row._replace(log_ns=10**9 + number * 650_000))
    write(path, rows)
    return str(path)


SPOILT = {
    "bursts": lambda: sorted(stamped(recorded(), heaps(16)), key=lambda sample: sample.t_ns),
    "drifts": lambda: joint_stamps(recorded(), lambda t: 1.005 * t),
    "were set back by 0.4 s": lambda: stamped(
        recorded(), lambda t: t - 400 * MS * (t >= 2000 * MS), lambda s: True
    ),
}


@pytest.mark.parametrize("word", SPOILT)
def test_inspect_and_replay_tell_what_the_node_does(word, tmp_path, capsys):
    found = SPOILT[word]()
    (cause,) = told(found)
    path = bag(tmp_path / "a.mcap", found)
    assert word in cause
    for verb in ("inspect", "replay"):
        assert main([verb, path]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert cause in lines
        assert not any(line.startswith("loop") or "state joints.delay" in line for line in lines)
