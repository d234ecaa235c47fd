"""`stability`: what a verdict says, and that the command goes on and gives the same."""

import csv

import pytest

from peg_on_hole_ros.cli import stability as command
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.study import stability as study
from peg_on_hole_ros.study.stability import MapPlace, Verdict, examine, truth_at

pytest.importorskip("matplotlib.figure")
SEED = 3


class Surer(ContactFilter):
    """States a twentieth of the deviations that it has."""

    def weigh(self, u, contacts):
        super().weigh(u, contacts)
        self.mixture.covariance[:] /= 400.0
        self._fill()


def surer(scene, options, noise, offsets=None):
    return Surer(scene, options, noise, offsets)


class Unwound(ContactFilter):
    """Loses its angles after a while."""

    def weigh(self, u, contacts):
        super().weigh(u, contacts)
        if self.state.time_since_start > 0.3:
            self.mixture.mean[0] += 0.01
            self._fill()


def unwound(scene, options, noise, offsets=None):
    return Unwound(scene, options, noise, offsets)


@pytest.mark.nightly
def test_what_holds_what_errs_and_what_diverges(monkeypatch):
    methods = {"default": make_filter, "surer": surer, "unwound": unwound}
    monkeypatch.setattr(study, "COMPARED_METHODS", methods)
    found = {result.method: result for result in examine(MapPlace(), Configuration(), [SEED])}
    assert found["default"].verdict is Verdict.HOLDS
    assert found["default"].reactions_inside > 0.9 and found["default"].states_inside > 0.9
    assert found["surer"].verdict is Verdict.ERRS
    # Whether a sample is beyond gamma0 it takes from its covariance too.
    assert found["surer"].reactions == pytest.approx(found["default"].reactions, rel=0.05)
    assert found["unwound"].verdict is Verdict.DIVERGED


def test_the_worst_seed_is_told(monkeypatch):
    monkeypatch.setattr(study, "COMPARED_METHODS", {"default": make_filter})
    run, calls = study.run, []

    def second_is_off(*arguments):
        calls.append(arguments)
        track = run(*arguments)
        if len(calls) == 2:
            track.values[-1, 0] += 0.1
        return track

    monkeypatch.setattr(study, "run", second_is_off)
    (result,) = examine(MapPlace(), Configuration(), [SEED, 4, 5])
    assert len(calls) == 3 and result.verdict is Verdict.DIVERGED


@pytest.mark.nightly
def test_reactions_that_are_not_told_are_no_error(monkeypatch):
    def silent(*arguments):
        track = run(*arguments)
        track.determined[:] = False
        return track

    run = study.run
    monkeypatch.setattr(study, "run", silent)
    monkeypatch.setattr(study, "COMPARED_METHODS", {"default": make_filter})
    (result,) = examine(MapPlace(), Configuration(), [SEED])
    assert result.verdict is Verdict.UNTOLD and result.determined == 0.0


@pytest.mark.nightly
def test_a_place_is_what_is_simulated():
    truth = truth_at(MapPlace(rate=400.0, size=0.02, lever=0.1, friction=0.3), Configuration())
    plan = truth.plan
    scene = plan.configuration.scene
    assert plan.wrench_rate == 400 and plan.joint_rate == 400
    assert scene.hole_diameter == 0.02 and scene.friction == 0.3
    assert scene.hole_diameter - scene.peg_diameter == pytest.approx(4e-5)
    assert plan.configuration.wrench.sensor_xyz == (0.0, 0.0, 0.1)
    # At the begin; the holder gives, and slows down from there on.
    assert -truth.rates[0, 0] == pytest.approx(0.16, rel=0.02)
    for axis in study.MAP_AXES:
        for far in axis.places(2):
            assert truth_at(far, Configuration()) is not None, far
    # A peg that the rim cannot hold from the begin on.
    assert truth_at(MapPlace(speed=3.0), Configuration()) is None


def test_rates_are_those_of_sensors():
    rates = [place.rate for place in study.MAP_AXES[0].places(8)]
    assert rates == sorted(set(rates)) and set(rates) <= set(study.SENSOR_RATES)


@pytest.fixture
def tiny(monkeypatch):
    monkeypatch.setattr(command, "QUICK_MAP_PLACES", 2)
    monkeypatch.setattr(study, "MAP_AXES", (study.MAP_AXES[0], study.MAP_AXES[4]))
    monkeypatch.setattr(study, "COMPARED_METHODS", {"default": make_filter, "surer": surer})


@pytest.mark.nightly
def test_stability_goes_on_and_gives_the_same(tmp_path, tiny, monkeypatch, capsys):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    assert main(["stability", "--quick", "--out", str(whole)]) == 0
    assert "surer" in capsys.readouterr().out
    calls = []

    def until_interrupted(*arguments):
        calls.append(arguments)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return examine(*arguments)

    monkeypatch.setattr(study, "examine", until_interrupted)
    assert main(["stability", "--quick", "--out", str(cut)]) == 130
    assert main(["stability", "--quick", "--out", str(cut)]) == 0
    # Four places, the third of them begun twice.
    assert len(calls) == 4 + 1
    for name in ("stability.csv", "stability.svg"):
        assert (cut / name).read_bytes() == (whole / name).read_bytes()
    with (whole / "stability.csv").open(newline="", encoding="utf-8") as file:
        found = list(csv.DictReader(file))
    assert len(found) == 4 * 2
    verdicts = {row["method"]: set() for row in found}
    for row in found:
        verdicts[row["method"]].add(row["verdict"])
    assert verdicts["surer"] == {Verdict.ERRS.value}
