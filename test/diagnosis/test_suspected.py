"""A suspected setting is one class of the registry: all else follows from what it says."""

import numpy as np
import pytest

from late_samples import ordered
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected import registry
from peg_on_hole_ros.diagnosis.suspected.suspect import PARTS, Suspect, has_part
from peg_on_hole_ros.engine import settings_against_data
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import UNOBSERVABLE_SETTINGS

SAMPLES = ordered(300)
STATED = Configuration().wrench.force_stddev


class Made(Suspect):
    """Finds, at the fifth wrench that is due, that the noise of the force is another."""

    NAME = "made"
    ADOPTS = True

    def __init__(self, stated):
        self.stated, self.passed, self.taken = stated, 0, 0

    def restart(self):
        self.taken = 0

    def take_every_wrench(self, t_ns, wrenches):
        self.passed += len(t_ns)

    def take(self, moment, unsure):
        self.taken += 1
        if self.taken == 5 and self.stated.configuration.wrench.force_stddev == STATED:
            found = {"force_stddev": 2.0 * STATED}
            self.finding = Finding("the noise is twice as large", found)


class Unadopted(Made):
    ADOPTS = False


class Several(Made):
    def take(self, moment, unsure):
        super().take(moment, unsure)
        self.finding = self.finding and self.finding._replace(alone=False)


class Broken(Made):
    def take(self, moment, unsure):
        raise KeyError("made up")


class Doubting(Made):
    NAME = "doubting"

    @property
    def unsure(self):
        return True

    def take(self, moment, unsure):
        assert not unsure


class Told(Made):
    def take(self, moment, unsure):
        assert unsure
        super().take(moment, unsure)


class Hiding(Made):
    NAME = "hiding"
    WITHOUT_WRENCH = True
    hides = True

    def take(self, moment, unsure):
        self.finding = Finding("nothing can be trusted", {})


class Offline(Made):
    OFFLINE = True


class Costly(Made):
    NAME = "costly"
    COSTS = np.arange(1.0, 1.0 + len(UNOBSERVABLE_SETTINGS))

    @property
    def reaction_errors(self):
        return self.COSTS if self.taken else None

    def take(self, moment, unsure):
        self.taken += 1


def played(monkeypatch, *members, offline=False):
    monkeypatch.setattr(settings_against_data, "SUSPECTED", (*members, *registry.SUSPECTED))
    line = Pipeline(Configuration(), offline=offline)
    return line, list(line.play(SAMPLES))


def test_what_a_look_finds_is_reported_once_and_used_where_it_may_be(monkeypatch):
    line, _ = played(monkeypatch, Made)
    (cause,) = line.causes
    assert cause.startswith("wrench: the noise is twice as large; used in place")
    assert line.counts["setting_contradicted"] == line.counts["setting_adopted"] == 1
    assert line.configuration.wrench.force_stddev == 2.0 * STATED


@pytest.mark.parametrize("member", [Unadopted, Several])
def test_what_may_not_be_adopted_is_reported_alone(member, monkeypatch):
    line, _ = played(monkeypatch, member)
    assert line.causes == ["wrench: the noise is twice as large"]
    assert line.counts["setting_contradicted"] == 1 and not line.counts["setting_adopted"]


def test_a_look_that_fails_is_counted_by_its_name(monkeypatch):
    line, rows = played(monkeypatch, Broken)
    assert line.counts["look_failed_made"] == 1 and line.causes == []
    assert len(rows) == len(played(monkeypatch)[1])


def test_a_look_that_doubts_withholds_what_rests_on_the_wrench(monkeypatch):
    line, rows = played(monkeypatch, Doubting, Told)
    assert line.counts["contact_doubted"] == len(rows) > 100
    assert not any("look_failed" in name for name in line.counts)
    assert {row.contact_mode for row in rows} <= {"open", "unknown"}


def test_costs_that_a_look_knows_are_published_on_three_contacts(monkeypatch):
    _, rows = played(monkeypatch, Costly)
    on_rim = [row.monitor for row in rows if row.contact_mode == "three_point"]
    assert len(on_rim) > 100
    for name, cost in zip(UNOBSERVABLE_SETTINGS, Costly.COSTS):
        assert {numbers[f"doubt_{name}"] for numbers in on_rim} == {cost}


def test_what_hides_others_leaves_those_that_stand_without_the_wrench(monkeypatch):
    line, _ = played(monkeypatch, Made, Hiding)
    assert line.causes == ["wrench: nothing can be trusted"]


@pytest.mark.parametrize("offline", [False, True])
def test_what_takes_time_looks_offline_alone(offline, monkeypatch):
    line, _ = played(monkeypatch, Offline, offline=offline)
    assert bool(line.counts["setting_adopted"]) == offline


def test_each_look_says_what_it_finds_and_has_a_part_to_look_with():
    names = [member.NAME for member in registry.SUSPECTED]
    assert len(set(names)) == len(names)
    for member in registry.SUSPECTED:
        assert member.FINDS and any(has_part(member, part) for part in PARTS)
