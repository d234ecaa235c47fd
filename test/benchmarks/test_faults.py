"""Faults do what their names say, and what has to happen with them happens."""

from math import inf

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.faults import faults
from benchmarks.faults.expected import BY_NAME, CASES, CLEAN, Case, shortfalls
from benchmarks.faults.injector import FAULTS, Sent, inject, sent
from benchmarks.faults.page import must
from benchmarks.faults.play import play
from benchmarks.faults.scenes import PARTS, scene
from benchmarks.faults.score import score
from benchmarks.faults.short import listed
from benchmarks.harness import runner
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import ANGLES, JointSample, WrenchSample

MS = 1_000_000
# One of each kind, in one scene or the other; all others in the nightly run.
OFTEN = (
    "no wrench for a while",
    "a third of the messages lost in bursts",
    "up to 5 ms of delay",
    "1 % of wrenches stamped 80 ms ahead",
    "both clocks jump back by 5 s",
    "joint states stamped 5 ms late",
    "wrench noise x 5",
    "joint noise x 5",
    "encoders stand still",
    "the sensor stands still",
    "each wrench 10 times",
    "5 % of wrenches NaN",
    "spikes of 500 N",
    "wrench with the other sign",
    "axes 7 of 23",
    "force in kN",
    "angles in degrees",
    "gamma stands still",
    "tare in contact",
)


def where_at_push(name):
    """Return the scene in which a fault is played at every push, by turns, or none."""
    return ("closing", "jam")[OFTEN.index(name) % 2] if name in OFTEN else None


def recording(count=400):
    draw, found = np.random.default_rng(1), []
    for k in range(count):
        t_ns = 10**9 + k * MS
        if k % 2 == 0:
            angles = np.array([0.15 - 1e-4 * k, 1e-3 * k, 2e-3 * k]) + draw.normal(0, 1e-4, 3)
            found.append(JointSample(t_ns, ANGLES, tuple(angles.tolist())))
        force, torque = draw.normal(0, 0.2, 3) + [1, 2, -20], draw.normal(0, 5e-3, 3)
        found.append(WrenchSample(t_ns, tuple(force.tolist()), tuple(torque.tolist())))
    return sent(found)


def of(faulted, kind=WrenchSample):
    return [item.sample for item in faulted if isinstance(item.sample, kind)]


@pytest.mark.parametrize("name", sorted({*FAULTS} - {"loop", "clock_jump", "drift", "set_again"}))
def test_a_fault_stays_in_its_part_and_is_the_same_each_time(name):
    clean = recording()
    changed = {"force": 1e-3} if name == "unit" else {}
    faulted = inject(clean, name, 0.1, 0.2, **changed)
    # NaN is not itself.
    assert repr(faulted) == repr(inject(clean, name, 0.1, 0.2, **changed))
    assert clean == recording()
    assert [item for item in faulted if not within(item, 0.1, 0.2)] == [
        item for item in clean if not within(item, 0.1, 0.2)
    ]
    assert repr(faulted) != repr(clean)


def within(item, begin, end):
    return begin <= (item.true_ns - 10**9) * 1e-9 < end


def test_what_is_lost_comes_twice_or_in_another_order():
    clean = recording()
    assert len(of(inject(clean, "gap", 0.1, 0.2, source="wrench"))) == 300
    assert len(of(inject(clean, "burst_loss", share=0.3))) == pytest.approx(280, abs=40)
    assert len(inject(clean, "duplicate")) == 2 * len(clean)
    assert inject(clean, "loop") == clean + clean
    reordered = inject(clean, "reorder", most_ms=5.0)
    assert sorted(map(repr, reordered)) == sorted(map(repr, clean))
    behind = np.maximum.accumulate([i.true_ns for i in reordered]) - [i.true_ns for i in reordered]
    assert 3 * MS < behind.max() <= 5 * MS
    again = inject(clean, "set_again", 0.1, 0.2)
    stamps = [item.sample.t_ns for item in again]
    assert stamps == sorted(stamps) and max(np.diff(stamps)) == MS and len(again) == 450


def test_stamps_and_values_are_off_by_what_is_asked_for():
    clean = recording()
    ahead = inject(clean, "stamps_off", source="wrench", by_ms=80.0, share=0.1)
    off = [item.sample.t_ns - item.true_ns for item in ahead]
    assert set(off) == {0, 80 * MS} and 20 < sum(x > 0 for x in off) < 60
    later = inject(clean, "clock_jump", 0.2, by_s=5.0)
    assert {item.sample.t_ns - item.true_ns for item in later[300:]} == {5000 * MS}
    held = of(inject(clean, "zero_order_hold", times=4))
    assert all(len({s.force for s in held[k : k + 4]}) == 1 for k in range(0, 400, 4))
    noisy = np.array([s.force for s in of(inject(clean, "noise", times=5.0))])
    assert noisy.std(axis=0) == pytest.approx([1.0] * 3, rel=0.15)
    turned = of(inject(clean, "noise", source="joints", times=10.0), JointSample)
    angles = [
        Rotation.from_matrix(peg_axes(a.position).T @ peg_axes(b.position)).as_rotvec()
        for a, b in zip(turned, of(clean, JointSample))
    ]
    assert np.std(angles) == pytest.approx(1e-3, rel=0.1)
    base = of(inject(clean, "base_axes"))[5]
    R = peg_axes(of(clean, JointSample)[2].position)
    np.testing.assert_allclose(base.force, R @ of(clean)[5].force)
    drifted = np.array([s.force for s in of(inject(clean, "drift", 0.1, 0.2, force=(10, 0, 0)))])
    assert drifted[-1, 0] - of(clean)[-1].force[0] == pytest.approx(1.0, abs=1e-2)
    called = inject(clean, "call", 0.1, what="reset")
    assert called[150] == Sent("reset", 10**9 + 100 * MS) and len(called) == len(clean) + 1


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("faults")


PAIRS = [
    pytest.param(
        name,
        case.name,
        marks=() if name == where_at_push(case.name) else pytest.mark.nightly,
        id=f"{name}-{case.name}",
    )
    for name, case in faults.pairs(PARTS, (CLEAN, *CASES))
]


@pytest.mark.parametrize(("name", "case"), PAIRS)
def test_what_has_to_happen_happens_but_for_what_is_listed(folder, name, case):
    found = faults.score_member(faults.Fault(name, BY_NAME[case]), folder)
    assert faults.surprises(name, case, shortfalls(BY_NAME[case], found)) == []


def test_what_is_listed_is_of_the_table():
    pairs = {(name, case.name) for name, case in faults.pairs(PARTS, (CLEAN, *CASES))}
    assert {key[:2] for key in listed()} <= pairs


def test_a_wrong_flag_and_a_jam_untold_count_where_nothing_doubts_them(folder):
    """What is said of a jam is changed by hand; beside `unknown` or an ERROR it counts no more."""
    recorded = scene("jam", folder)
    said = play(recorded, recorded.recording)
    count = int((said.true_ns >= recorded.jams_ns).sum())
    assert count > 40

    def figures(**changed):
        return score(recorded, said, said._replace(**changed), 0.0, inf, 0.3)

    none, yes = np.zeros_like(said.jamming), np.ones(len(said.flag), bool)
    assert (figures().jam, figures().flag) == (0, 0)
    assert figures(jamming=none).jam == count
    assert figures(jamming=none, level=none + 2).jam == 0
    assert figures(jamming=none, mode=np.full(len(none), "unknown")).jam == 0
    assert figures(flag=yes).flag == int((said.mode != "unknown").sum())


def test_what_falls_short_and_what_no_longer_does_are_surprises(monkeypatch):
    monkeypatch.setattr(faults, "known", lambda scene, case: {"told": "it is quiet"})
    assert faults.surprises("jam", "a", {"told": "not reported"}) == []
    assert faults.surprises("jam", "a", {"told": "not reported", "jam": "3 samples"}) == [
        "jam, a: 3 samples"
    ]
    assert faults.surprises("jam", "a", {}) == [
        "jam, a: told holds now, and is listed in benchmarks/faults/short.csv"
    ]


def test_the_table_tells_what_has_to_happen_and_what_falls_short(folder, tmp_path):
    """A fault that nobody tells, which falls short as soon as something is to be told of it."""
    case = Case("a little noise", "noise", {"times": 1.05}, told="noise of the force")
    pairs = faults.pairs(["closing"], [CLEAN, case])
    found = runner.run("faults", pairs, tmp_path, 1, lambda line: None)
    report = faults.report(found, None)
    assert report.problems == [f"closing, {case.name}: not reported"]
    text = report.text
    assert "| a little noise | reported | **" in text
    assert "| 1 | ? |" in text
    assert must(BY_NAME["tare in contact"]) == "counted; “nothing taken”"
    # It goes on with what it has.
    told = []
    assert runner.run("faults", pairs, tmp_path, 1, told.append) == found
    assert told == ["faults: 2 members, 0 to compute"]
