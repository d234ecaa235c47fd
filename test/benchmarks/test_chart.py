"""`chart`: what is scored, what is drawn, and that it goes on after an interruption."""

import csv
from functools import partial

import numpy as np
import pytest

from peg_on_hole_ros.cli import chart as command
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.partial_table import PartialTable
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.mechanics.kernel import closed_forms, small_forms
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.study import chart, cost_floor, runs, scenes
from peg_on_hole_ros.study.bare_balance import bare_balance
from peg_on_hole_ros.study.bound import Meaning
from peg_on_hole_ros.study.estimators import BARE, DEFAULT, ESTIMATORS, LEFT_OUT

pytest.importorskip("matplotlib.figure")
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

from peg_on_hole_ros.plots.chart import figure  # noqa: E402
from peg_on_hole_ros.plots.labels import place_labels  # noqa: E402


@pytest.fixture(scope="module")
def motion():
    return scenes.first_samples(scenes.truth_of(scenes.CASES[0], Configuration()), 220)


def clock():
    """A clock that goes on by a second a look: what is timed is then counted."""
    clock.now = getattr(clock, "now", 0.0) + 1.0
    return clock.now


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def named(name, rate=1000):
    return next(e for e in ESTIMATORS if e.name == name and e.rate == rate)


def scored(motion, *chosen, seeds=(1,)):
    return chart.scores(chosen, scenes.CASES[0], motion, seeds, clock)


def test_no_more_than_sixteen_points_and_each_row_its_own():
    names = [str(estimator) for estimator in ESTIMATORS]
    assert len(names) == len(set(names))
    shown = [estimator for estimator in ESTIMATORS if estimator.shown]
    assert len(shown) <= 16 and shown[0] == DEFAULT
    # Every method has a row at each rate, the default a point at each; a part is left out once.
    others = [estimator for estimator in ESTIMATORS if not estimator.part]
    assert len(others) == 3 * len({estimator.name for estimator in others})
    assert [one.rate for one in shown if one.name == DEFAULT.name] == [1000, 500, 100]
    assert {one.name for one in ESTIMATORS if one.part} == set(LEFT_OUT)


def test_every_kind_of_scene_has_its_motion():
    """Those on three contacts keep them to the end, and the others slide on two."""
    for cases in scenes.SCENE_KINDS.values():
        truth = scenes.truth_of(cases[0], Configuration())
        assert len(truth.t_ns) > 400
        if cases[0].told:
            assert (truth.mode == "three_point").all() and (truth.normal > 0).all()
        else:
            slides = (truth.mode == "two_point") & (truth.place_rate[:, 2] > runs.SLIDES)
            assert slides.sum() > 500


def test_gears_turn_what_the_joints_say_and_nothing_else():
    case = scenes.SCENE_KINDS["robot cell"][0]
    truth = scenes.truth_of(case, Configuration())
    bent, straight = scenes.measured(case, truth, 1), list(measure(truth, 1))
    off = []
    for one, other in zip(bent, straight):
        if isinstance(one, JointSample):
            off.append(abs(one.position[0] - other.position[0]))
        else:
            assert one == other
    # An amplitude each of two axes across the peg, that gamma sees one of at a time.
    assert 0.5 * case.gears < max(off) < 2.0 * case.gears


def test_friction_is_that_of_the_leg():
    case = next(case for case in scenes.CASES if case.name == "friction steps up")
    truth = scenes.truth_of(case, Configuration())
    stated = truth.plan.configuration.scene.friction
    assert [phase.friction for phase in truth.plan.phases] == pytest.approx(
        [stated, stated, stated, 1.5 * stated]
    )


def test_in_the_hole_the_slide_counts_where_it_is_told():
    case = scenes.SCENE_KINDS["in the hole"][0]
    truth = scenes.truth_of(case, Configuration())
    exact = np.hstack([truth.q, truth.rates, truth.normal])
    determined = truth.mode == "two_point"
    track = runs.Track(truth.t_ns, exact.copy(), np.full_like(exact, 1e-3), determined.copy(), 0.0)
    # What B1 and B2 share counts together; what is not told, or no slide, does not.
    track.values[:, 7] += 5.0
    track.values[:, 8] -= 5.0
    track.values[~determined, 6:] += 100.0
    fine = runs.errors(truth, track)
    assert fine.reactions == pytest.approx(0.0, abs=1e-9) and fine.determined == 1.0
    track.determined[truth.t_ns > 600_000_000] = False
    assert 0.2 < runs.errors(truth, track).determined < 0.8
    track.determined[:] = False
    silent = runs.errors(truth, track)
    assert np.isnan(silent.reactions) and silent.determined == 0.0 and not silent.lost


@pytest.mark.nightly
def test_what_the_default_and_others_come_to(motion):
    default, slow, driven, unscented, smoother = scored(
        motion, DEFAULT, named("mixture", 100), named("dde_driven"),
        named("unscented"), named("smoother"),
    )  # fmt: skip
    # Of the mean reaction, some 60 N: the wrench's noise is 0.2 N.
    assert 1e-3 < default.reactions < 2e-2 and default.reactions_inside > 0.9
    assert default.determined > 0.95 and default.lost == 0
    # A tenth of the wrenches; where friction is learnt, a time later than half of this motion.
    assert default.reactions < slow.reactions < 0.1
    # Noise that is integrated: rates several times worse, and reactions that it does not know.
    assert driven.tilt_rate > 4 * default.tilt_rate and driven.reactions > 4 * default.reactions
    # The same process with other points than tangents: much the same where all slips are told.
    assert 0.5 < unscented.reactions / default.reactions < 2.0
    assert unscented.tilt_rate < 2.0 * default.tilt_rate
    # What comes later tells of rates, and by them of reactions.
    assert smoother.tilt_rate < 0.8 * default.tilt_rate
    assert smoother.reactions < default.reactions and smoother.reactions_inside > 0.9


@pytest.mark.nightly
def test_common_methods_come_to_what_they_leave_out(motion):
    """Closing with slip: the tilt goes on at 0.16 rad/s, the turn about the peg at 2 rad/s."""
    default, balance, small, one, two, particles = scored(
        motion, DEFAULT,
        *map(named, ("balance", "small_angle", "one_dof", "two_dof", "particles_1000")),
    )  # fmt: skip
    # Joint states alone tell rates worse than with a wrench.
    assert balance.tilt_rate > 1.5 * default.tilt_rate and balance.reactions_inside > 0.9
    # The lengths of a small tilt are 0.1 to 0.4 % off here: beside 0.4 % of noise they show.
    assert balance.reactions < small.reactions < balance.reactions + 1e-2
    # Without slip friction has another direction; with it, and without slide, it has its own.
    assert one.reactions > 0.1 > 1e-2 > two.reactions
    assert particles.reactions < 2.0 * default.reactions and particles.reactions_inside > 0.85


def test_lengths_of_a_small_tilt_go_over_into_the_true_ones():
    gamma0 = np.array([0.01, 0.02])
    off = []
    for g in gamma0:
        given = 0.05 * np.cos(g), 0.05, 0.035, g, 1.5 * g
        off.append(np.abs(np.divide(small_forms(*given), closed_forms(*given)) - 1.0))
    # Second order: twice the tilt is four times off.
    assert off[1] == pytest.approx(4.0 * off[0], rel=0.1)
    assert 0 < off[0].max() < 1e-2


def test_the_step_that_is_timed_is_the_estimator_s_own(motion):
    configuration = runs.always_in_contact(motion.plan.configuration)
    kept = cost_floor.noted(configuration, list(measure(motion, 1)), clock)
    for _ in range(2):
        peg, seconds = cost_floor.taken_anew(kept, kept.arguments[4], clock)
        assert np.array_equal(peg.mixture.mean, kept.mixture.mean)
        assert np.array_equal(peg.mixture.covariance, kept.mixture.covariance)
        # By the clock a second passes, over all wrenches.
        assert seconds == pytest.approx(1.0 / len(motion.t_ns))


def test_steps_are_those_of_every_method_on_the_same_samples(motion):
    configuration = runs.always_in_contact(motion.plan.configuration)
    chosen = DEFAULT, named("balance"), named("smoother"), named(BARE)
    told = chart.step_times(chosen, configuration, list(measure(motion, 1)), clock)
    assert [len(each) for each in told] == [chart.STEP_TURNS] * 2 + [0, 0]
    peg, _ = cost_floor.taken_anew(
        cost_floor.noted(configuration, list(measure(motion, 1)), clock),
        default_settings(**METHODS["balance"].settings),
        clock,
    )
    made = []

    def make(*given):
        made.append(METHODS["balance"].make(*given))
        return made[-1]

    runs.run(configuration, list(measure(motion, 1)), clock, make)
    assert np.array_equal(peg.mixture.mean, made[0].mixture.mean)


def test_the_bare_balance_is_off_as_least_squares_are(motion):
    configuration = runs.always_in_contact(motion.plan.configuration)
    track = bare_balance(configuration, list(measure(motion, 1)), clock)
    assert track.determined.all() and len(track.t_ns) > 200
    error = runs.errors(motion, track)
    # The closing is steady: its rates are off by twice 0.1 mrad over 10 ms, of 85 orientations.
    assert error.tilt_rate == pytest.approx(np.sqrt(2.0) * 1e-4 / 0.01, rel=0.2)
    # 0.2 N of noise in six equations for some 60 N.
    assert error.reactions < 0.01


def test_time_is_that_of_the_motion_and_judging_is_the_defaults(motion, monkeypatch):
    """By a clock that tells a run's wrenches, and twice as many where modes are judged."""
    spent = []

    def run(configuration, samples, clock, make=None):
        track = runs.run(configuration, samples, lambda: 0.0, make or DEFAULT.method.make)
        per_wrench = 2.0 if configuration.monitor.modes else 1.0
        spent.append(per_wrench)
        return track._replace(seconds=per_wrench * len(track.t_ns))

    monkeypatch.setattr(chart, "run", run)
    default, slow = scored(motion, DEFAULT, named("one_level", 100))
    # 219 ms: 220 wrenches of a second each, and a second each for judging.
    assert default.whole == pytest.approx(1e6 * 2.0 * 220 / 219)
    assert slow.whole == pytest.approx(1e6 * 2.0 * 22 / 219)
    assert 2.0 in spent


def test_the_same_seed_gives_the_same_score(motion):
    first, again = (scored(motion, DEFAULT)[0] for _ in range(2))
    assert first[:-1] == again[:-1]


def test_thinned_samples_keep_their_stamps(motion):
    samples = list(measure(motion, 1))
    kept = runs.thinned(samples, 10_000_000)
    stamps = sorted({sample.t_ns - START_NS for sample in kept})
    assert stamps == list(range(0, 220_000_000, 10_000_000))
    # A wrench and an orientation each.
    assert len(kept) == 2 * len(stamps)
    later = runs.thinned(samples, 10_000_000, 4_000_000)
    assert {(sample.t_ns - START_NS) % 10_000_000 for sample in later} == {4_000_000}


def test_errors_are_those_of_the_track(motion):
    exact = np.hstack([motion.q, motion.rates, motion.normal])
    stddev = np.full_like(exact, 1e-3)
    determined = np.ones(len(exact), bool)
    track = runs.Track(motion.t_ns, exact.copy(), stddev, determined, 0.0)
    # Whole turns are no error; what has not settled does not count.
    track.values[:, 2] += 2 * np.pi
    track.values[motion.t_ns < runs.SETTLE_NS] += 100.0
    fine = runs.errors(motion, track)
    assert fine == pytest.approx((0.0, 0.0, 1.0, 1.0, 1.0, False), abs=1e-9)
    track.values[:, 3] += 0.02
    track.values[:, 6:] += 3.0
    track.determined[:] = motion.t_ns >= 135_000_000
    off = runs.errors(motion, track)
    assert off.tilt_rate == pytest.approx(0.02)
    mean = motion.normal[motion.t_ns >= runs.SETTLE_NS].mean()
    assert off.reactions == pytest.approx(3.0 / mean)
    assert off.states_inside == off.reactions_inside == 0.0 and not off.lost
    assert off.determined == pytest.approx(0.5, abs=0.01)
    track.values[-1, 0] += 2e-3
    assert runs.errors(motion, track).lost
    track.values[-1, 0] = np.nan
    assert runs.errors(motion, track).lost
    silent = runs.Track(*(part[:0] for part in track[:4]), 0.0)
    assert runs.errors(motion, silent).lost


def test_a_holder_is_no_calmer_than_the_calmest():
    t = np.arange(400) * 1e-3
    rates = np.stack([np.full(400, -0.16), 0.5 * np.sin(40 * t), np.zeros(400)], axis=1)
    found = scenes.holder_of(t, rates)
    # 0.5 times 40 rad/s^2 at the most, and over the root of two of it.
    assert found.level == pytest.approx([3.0, 20 / np.sqrt(2), 3.0], rel=0.1)
    assert found.time[0] == found.time[2] == 0.05 and found.time[1] < 0.04


def test_front_keeps_what_nothing_beats():
    cost, error = np.array([1.0, 2.0, 3.0, 2.0]), np.array([5.0, 1.0, 2.0, 4.0])
    assert chart.front(cost, error) == [0, 1]


def made_up(name, reactions, kind="a", lost=0.0, whole=10.0):
    return chart.ChartScore(
        kind, "", name, reactions, reactions, reactions, 0.01, 0.95, 1.0, lost, 5.0, 4.0, 6.0,
        whole,
    )  # fmt: skip


def test_motions_and_then_kinds_are_put_together():
    found = [made_up("x", r, whole=100 * r) for r in (0.01, 0.04, 0.02)]
    found[0] = found[0]._replace(lost=0.5)
    (whole,) = chart.over_motions(found)
    assert whole.reactions == pytest.approx(0.02) and whole.whole == 2.0
    assert whole.lost == pytest.approx(1 / 6)
    # A motion in which nothing is determined says nothing of coverage.
    untold = made_up("x", 0.02)._replace(reactions_inside=float("nan"))
    assert chart.over_motions([*found, untold])[0].reactions_inside == pytest.approx(0.95)
    assert np.isnan(chart.over_motions([made_up("x", float("nan"))])[0].reactions)
    # Three motions of one kind count for as much as one of another.
    both = [*found, made_up("x", 0.32, kind="b")]
    assert chart.overall(both)[0].reactions == pytest.approx(0.08)
    assert [len(rows) for rows in chart.of_kinds(both).values()] == [1, 1]
    alone = made_up("x", 0.9, kind=chart.OWN_ROWS[0])
    assert chart.overall([*both, alone])[0].reactions == pytest.approx(0.08)


@pytest.mark.nightly
def test_the_bound_is_of_samples_where_it_means_something(motion):
    bound = scenes.bound_along(motion)
    known = scenes.least_errors(motion, bound)
    assert 1e-3 < known.reactions < 2e-2 and 1e-3 < known.tilt_rate < 2e-2
    slow = bound._replace(meaning=np.full_like(bound.meaning, Meaning.SLOW))
    assert np.isnan(scenes.least_errors(motion, slow)).all()


@pytest.fixture
def tiny(monkeypatch):
    monkeypatch.setattr(command, "ESTIMATORS", (DEFAULT, named("mixture", 100)))
    whole = scenes.truth_of
    monkeypatch.setattr(
        scenes, "truth_of", lambda *given: scenes.first_samples(whole(*given), 160)
    )
    kinds = dict(list(scenes.SCENE_KINDS.items())[:2])
    monkeypatch.setattr(scenes, "SCENE_KINDS", kinds)


def test_chart_goes_on_and_draws(tmp_path, tiny, monkeypatch, capsys):
    scores, calls = chart.scores, []

    def until_interrupted(*arguments):
        calls.append(arguments[1].name)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return scores(*arguments)

    monkeypatch.setattr(chart, "scores", until_interrupted)
    assert main(["chart", "--quick", "--out", str(tmp_path)]) == 130
    assert main(["chart", "--quick", "--out", str(tmp_path)]) == 0
    # The first motion was there already.
    first, second = (cases[0].name for cases in scenes.SCENE_KINDS.values())
    assert calls == [first, second, second]
    found = rows(tmp_path / "chart.csv")
    names = [*map(str, command.ESTIMATORS), chart.BOUND]
    assert [row["name"] for row in found] == names * 2
    assert not list(tmp_path.glob("*.partial"))
    text = capsys.readouterr().out
    assert "mixture, 100 Hz" in text and "bound at 1 kHz: reactions" in text
    for name in ("chart", "chart_narrow", "chart_kinds", "chart_kinds_narrow"):
        svg = (tmp_path / f"{name}.svg").read_text(encoding="utf-8")
        # Two points in each of the panels; bound and whole path are lines, named in the legend.
        for label, count in (
            ("mixture, 1 kHz", 2), ("100 Hz", 2), ("bound at 1 kHz", 1), ("whole path at 1 kHz", 1)
        ):  # fmt: skip
            assert svg.count(f">{label}</text>") == count, label
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000


def test_hollow_is_what_does_not_keep_its_word():
    overall = partial(
        chart.Overall, reactions_inside=0.95, determined=1.0, lost=0.0, step_low=1.0,
        step_high=1.0, whole=100.0,
    )  # fmt: skip
    bound = chart.Limits(0.004, *[float("nan")] * 2)
    kept = overall("mixture, 1 kHz", *[0.01] * 4, step=10.0)
    wrong = overall("mixture, 100 Hz", *[0.005] * 4, step=50.0)
    nothing = float("nan")
    for change in (
        {"reactions_inside": 0.5}, {"reactions_inside": nothing}, {"lost": 0.1},
        {"determined": 0.2},
    ):  # fmt: skip
        fig = figure([kept, wrong._replace(**change)], bound)
        points = [
            line for axis in fig.axes for line in axis.lines if line.get_marker() in ("o", "^")
        ]
        hollow = [line for line in points if line.get_markerfacecolor() == "white"]
        assert len(points) == 4 and {line.get_marker() for line in hollow} == {"^"}
    assert [line.get_markerfacecolor() for line in figure([kept], bound).axes[0].lines[1:2]] != [
        "white"
    ]


def test_labels_cover_neither_points_nor_each_other():
    fig = Figure(figsize=(6, 4), dpi=110)
    FigureCanvasAgg(fig)
    axis = fig.add_axes((0.1, 0.1, 0.8, 0.8))
    rng = np.random.default_rng(0)
    points = rng.uniform(0.4, 0.6, (18, 2))
    axis.plot(*points.T, "o", markersize=6)
    axis.set(xlim=(0, 1), ylim=(0, 1))
    fig.canvas.draw()
    labels = place_labels(axis, points, [f"label {k}" for k in range(18)])
    renderer = fig.canvas.get_renderer()
    # Of the text alone, without the pale ground behind it.
    extents = []
    for label in labels:
        label.set_bbox(None)
        extents.append(label.get_window_extent(renderer))
    for k, box in enumerate(extents):
        assert not any(box.overlaps(other) for other in extents[:k])
        assert not box.count_contains(axis.transData.transform(points))


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


@pytest.mark.parametrize("name", ["chart", "stability"])
def test_a_file_is_no_folder(name, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main([name, "--quick", "--out", str(tmp_path / "file")]) == 2
    assert "cannot make the folder" in capsys.readouterr().err
