"""`chart` and `stability`: they run, go on after an interruption, and say the same each time."""

import csv

import numpy as np
import pytest

from peg_on_hole_ros.cli import chart, stability
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.edges.partial_table import PartialTable
from peg_on_hole_ros.edges.plots import chart as chart_plots
from peg_on_hole_ros.edges.plots.labels import place_labels
from peg_on_hole_ros.estimation.bound import Meaning
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.study import filtering, front, implementations, integration, scenes
from peg_on_hole_ros.study import stability as study

plt = pytest.importorskip("matplotlib.figure")


@pytest.fixture
def tiny(monkeypatch):
    monkeypatch.setattr(stability, "QUICK_COUNT", 2)
    monkeypatch.setattr(study, "MAPS", study.MAPS[1:3])
    monkeypatch.setattr("peg_on_hole_ros.study.regularisation.effects.__defaults__", ((1e-4,),))


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_stability_goes_on_and_gives_the_same(tmp_path, tiny, monkeypatch, capsys):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    assert main(["stability", "--quick", "--out", str(whole)]) == 0
    assert "filter's prediction" in capsys.readouterr().out
    examine, calls = study.examine, []

    def until_interrupted(*arguments):
        calls.append(arguments)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return examine(*arguments)

    monkeypatch.setattr(study, "examine", until_interrupted)
    assert main(["stability", "--quick", "--out", str(cut)]) == 130
    assert main(["stability", "--quick", "--out", str(cut)]) == 0
    # 8 places; of the 4th call's line of two the first is examined once more.
    assert len(calls) == 4 + 8 - 2
    assert (cut / "stability.csv").read_bytes() == (whole / "stability.csv").read_bytes()
    assert (cut / "stability.svg").read_bytes() == (whole / "stability.svg").read_bytes()
    assert not list(cut.glob("*.partial"))
    found = rows(whole / "stability.csv")
    assert len(found) == 8 * len(study.ALL_METHODS)
    assert {row["verdict"] for row in found} <= {verdict.value for verdict in study.Verdict}


def test_a_table_of_another_state_is_not_gone_on_with(tmp_path):
    path = tmp_path / "a.csv"
    first = PartialTable(path, ("x", "y"), "# one", 2)
    first.add([(1, 2.0), (3, 4.0), (5, float("nan")), (6, 7.0), (8, 9.0)])
    first.close()
    again = PartialTable(path, ("x", "y"), "# one", 2)
    assert again.rows == [["1", "2"], ["3", "4"], ["5", ""], ["6", "7"]]
    again.close()
    other = PartialTable(path, ("x", "y"), "# two", 2)
    assert other.rows == []
    other.finish()
    assert path.read_text() == "x,y\n"


@pytest.fixture(scope="module")
def motion():
    truth = scenes.first_samples(scenes.truth_of(scenes.CASES[0], Configuration()), 220)
    recordings = [scenes.recorded(truth, seed) for seed in (1, 2)]
    return truth, scenes.bound_along(truth), recordings


def clock():
    """A clock that goes on by a second a look: what is timed is then counted."""
    clock.now = getattr(clock, "now", 0.0) + 1.0
    return clock.now


def test_default_filter_is_near_the_bound_and_others_are_not(motion):
    by_name = {v.name: v for v in filtering.variants({}.get)}
    names = (
        filtering.DEFAULT,
        "wrench, orientation at 100 Hz",
        "constant rates, no contact model",
    )
    default, slow, bare = filtering.scores([by_name[n] for n in names], "a", motion, clock)
    # Two seeds of 0.2 s: chance moves the ratio by some tenths.
    assert 0.7 < default.state_ratio < 1.4 and 0.6 < default.reaction_ratio < 1.4
    assert default.lost == 0 and default.coverage > 0.85
    assert slow.reaction_error > 1.2 * default.reaction_error
    assert np.isnan(bare.reaction_ratio) and np.isnan(bare.reaction_error)
    # A tick of the clock for a run of 219 wrenches, or of 21: over the same time of motion.
    assert default.microseconds == pytest.approx(1e6 / 219)
    assert slow.microseconds == pytest.approx(1e6 / 21 / 10)
    # Of the mean reaction, some 100 N: the wrench's noise is 0.2 N.
    assert 1e-3 < default.reaction_error < 2e-2


def test_the_same_seed_gives_the_same_score(motion):
    chosen = [filtering.VARIANTS[0]]
    first, again = (filtering.scores(chosen, "a", motion, clock)[0] for _ in range(2))
    assert first[:-1] == again[:-1]


def test_what_a_variant_compiles_does_not_count(motion, monkeypatch):
    """It had: the first motion of a first chart showed `model: auto` a thousand times as slow."""
    run, seen = filtering.run, set()

    def compiling(variant, *rest):
        first = variant.name not in seen
        seen.add(variant.name)
        return run(variant, *rest)._replace(seconds=1e3 if first else 1.0)

    monkeypatch.setattr(filtering, "run", compiling)
    chosen = [filtering.VARIANTS[0], filtering.Variant("again")]
    default, again = filtering.scores(chosen, "a", motion, clock)
    assert again.microseconds == default.microseconds == pytest.approx(1e6 / 219)


def test_a_method_is_another_filter(motion):
    """The filter that a variant names is the one that runs."""
    truth, bound, recordings = motion
    chosen = [
        filtering.Variant("default"),
        filtering.Variant("unscented", {"method": "unscented"}),
    ]
    short = scenes.first_samples(truth, 60)
    cut = bound._replace(**{name: getattr(bound, name)[:60] for name in bound._fields})
    recording = recordings[0]._replace(
        **{name: getattr(recordings[0], name)[:60] for name in ("wrench", "angles", "covariances")}
    )
    found = filtering.scores(chosen, "a", (short, cut, [recording]), clock)
    assert found[0].state_error != found[1].state_error


def test_filter_variants_that_are_methods_come_with_their_options(monkeypatch):
    assert len(filtering.variants({}.get)) == len(filtering.VARIANTS)
    monkeypatch.setattr(
        filtering,
        "_METHODS",
        (("friction", "considered", "a method", 2), ("nothing", "x", "none", 2)),
    )
    found = filtering.variants({"filter.friction": ("estimated", "considered")}.get)
    assert [variant.name for variant in found[len(filtering.VARIANTS) :]] == ["a method"]


def test_predictions_are_scored_with_what_is_lost(motion):
    kept, ends = integration.solved([integration.stretches(motion[0])])
    exact = integration.predict_all(kept, ends, "implicit Euler, halved", 1e-4, clock, 1)
    coarse = integration.predict_all(kept, ends, "implicit Euler, halved", 1e-2, clock, 1)
    # First order: a hundred times the step, some hundred times the error.
    assert 30 < coarse.error / exact.error < 300
    assert exact.lost == coarse.lost == 0
    # One tick of the clock over all stretches.
    assert exact.microseconds == pytest.approx(1e6 / (len(kept[0]) * 20))
    wrong = [ends[0] + 1.0]
    assert integration.predict_all(kept, wrong, "RK4", 1e-3, clock, 1).lost == 1.0


def test_implementations_give_one_result(motion):
    truth, _, recordings = motion
    found = implementations.costs(Configuration(), truth, recordings[0], None, clock, 1)
    by_name = {cost.name: cost for cost in found}
    assert implementations.C not in by_name
    # Of a standard deviation; rounding and Newton's tolerance, over 25 steps.
    assert by_name[implementations.FILTERPY].difference < 1e-6
    assert by_name[implementations.CALLED].difference == 0


def test_front_keeps_what_nothing_beats():
    cost, error = np.array([1.0, 2.0, 3.0, 2.0]), np.array([5.0, 1.0, 2.0, 4.0])
    assert front.front(cost, error) == [0, 1]


@pytest.mark.parametrize(
    "cost, error, expected",
    [
        (0.95, 0.95, False),  # better, but not by more than a tenth
        (0.85, 1.02, True),
        (0.85, 1.05, False),  # cheaper and worse: both are on the front
        (1.02, 0.85, True),
        (1.2, 0.5, False),  # dearer and better
        (0.5, 0.5, True),
    ],
)
def test_what_beats_the_default(cost, error, expected):
    assert front.beats(cost, error) is expected


def made_up(name, microseconds, error, coverage=0.95, lost=0.0, case="a"):
    ratios = (error,) * 6
    return filtering.Score(
        case, name, 1.0, error, error, error, *ratios, coverage, lost, microseconds
    )


def test_the_default_competes_with_what_keeps_its_promise():
    chosen = [filtering.Variant("default"), filtering.Variant("told", told=True)]
    chosen += [filtering.Variant("half", every=2), filtering.Variant("other")]
    default = made_up("default", 10.0, 0.02)
    beaten = made_up("other", 10.0, 0.01)
    aside = [
        made_up("told", 5.0, 0.01),
        made_up("half", 5.0, 0.02),
        made_up("other", 5.0, 0.01, coverage=0.6),
    ]
    found = front.standings([default, *aside], chosen)[0]
    assert found.on_front and found.competing == ("default",)
    found = front.standings([default, *aside[:2], beaten], chosen)[0]
    assert not found.on_front and found.by == "other"
    assert (found.cost, found.error) == (1.0, 0.5)
    lost = beaten._replace(lost=0.1)
    assert front.standings([default, lost], chosen)[0].on_front
    unsure = default._replace(coverage=0.5)
    assert not front.standings([unsure, aside[2]], chosen)[0].on_front
    # What the filter saves is little of all that a wrench costs.
    cheaper = made_up("other", 5.0, 0.02)
    assert not front.standings([default, cheaper], chosen)[0].on_front
    assert front.standings([default, cheaper], chosen, 50.0)[0].on_front


def test_motions_are_put_together_by_their_median():
    scores = [made_up("default", k, k, case=f"case {k}") for k in (1.0, 2.0, 9.0)]
    scores.append(made_up("default", 5.0, float("nan"), case="no bound"))
    whole = front.overall(scores)[0]
    assert whole.reaction_ratio == 2.0 and (whole.reaction_low, whole.reaction_high) == (1.5, 5.5)
    assert whole.microseconds == 3.5


def test_labels_cover_neither_points_nor_each_other():
    fig = chart_plots._figure((6, 4))
    axis = fig.add_axes((0.1, 0.1, 0.8, 0.8))
    rng = np.random.default_rng(0)
    points = rng.uniform(0.4, 0.6, (18, 2))
    axis.plot(*points.T, "o", markersize=6)
    axis.set(xlim=(0, 1), ylim=(0, 1))
    fig.canvas.draw()
    labels = place_labels(fig, axis, points, [f"label {k}" for k in range(18)])
    renderer = fig.canvas.get_renderer()
    boxes = [label._get_xy_display() for label in labels]
    assert len(boxes) == 18
    # Of the text alone, without the pale ground behind it.
    extents = []
    for label in labels:
        label.set_bbox(None)
        extents.append(label.get_window_extent(renderer))
    for k, box in enumerate(extents):
        assert not any(box.overlaps(other) for other in extents[:k])
        assert not box.count_contains(axis.transData.transform(points))


def test_pictures_of_the_chart_are_drawn(tmp_path, motion):
    # Made-up figures that are alike: labels and lines must bear it, also without C.
    scores = [made_up(f"v{k}", 20.0, 0.01, lost=k / 10) for k in range(4)]
    scores[0] = scores[0]._replace(name=filtering.DEFAULT, reaction_ratio=float("nan"))
    standings = front.standings(scores, [])
    predictions = [
        integration.Prediction(m, h, 1e-3 * h, 1e-3, 0.0, 1.0, 1e-3 / h)
        for m in ("RK4", "implicit Euler, halved") for h in (1e-4, 1e-3)
    ]  # fmt: skip
    costs = [implementations.Cost("kernel", 5.0, 4.0, float("nan"), 0.0)]
    for name, fig in (
        ("a", chart_plots.filters(front.overall(scores), None)),
        ("d", chart_plots.fronts(scores, standings)),
        ("b", chart_plots.integrators(predictions, 1e-4, None)),
        ("e", chart_plots.integrators(predictions, None, None)),
        ("c", chart_plots.costs(costs, "\nno compiler")),
    ):
        paths = chart.save(fig, tmp_path / name)
        assert [path.suffix for path in paths] == [".png", ".svg"]
        assert all(path.stat().st_size > 5000 for path in paths)
    text = chart.summary(front.overall(scores), standings, standings, costs, "no compiler")
    assert "on the front in 1 of 1" in text


def test_a_motion_whose_bound_is_nowhere_sound_is_left_out_of_the_median(motion):
    truth, bound, _ = motion
    slow = bound._replace(meaning=np.full_like(bound.meaning, Meaning.SLOW))
    known = scenes.rotation_bound(truth, bound)
    # Of an orientation that is measured to 1e-4 rad about each axis.
    assert 1e-5 < known < 1e-3
    assert scenes.typical_bound([(truth, slow), (truth, bound)]) == known
    assert scenes.typical_bound([(truth, slow)]) is None


@pytest.mark.parametrize("command", ["chart", "stability"])
def test_a_file_is_no_folder(command, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main([command, "--quick", "--out", str(tmp_path / "file")]) == 2
    assert "cannot make the folder" in capsys.readouterr().err
