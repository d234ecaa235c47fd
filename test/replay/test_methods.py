"""Every method of `filter.method` is one in the registry, for node, replay and smoother."""

from dataclasses import replace
from functools import cache
from importlib import import_module

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import BY_NAME
from peg_on_hole_ros.config.options import Configuration, FilterOptions
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods.method import Method
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.replay.run import replay_bag, stored_configuration
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.study import runs, scenes
from simulated import ROOT
from tiers import at_push

BAG = ROOT / "bags" / "closing_with_slip.mcap"
# Of the speed of the chart's motions: inertia is nothing beside the wrench's noise.
SLOWER = 0.25


class Kept:
    """Keeps the rows, or the stamps of smoothed states."""

    def __init__(self):
        self.rows, self.stamps = [], []

    def take(self, columns):
        self.rows.append(columns.rows.copy())

    def add(self, t_ns, messages):
        self.stamps.append(t_ns)


def replayed(method, smooths):
    bag, kept = Bag(BAG), Kept()
    configuration = stored_configuration(bag)
    options = replace(configuration.filter, method=method)
    configuration = replace(configuration, filter=options)
    replay_bag(bag, configuration, 0.0, [kept], smoothed=kept if smooths else None)
    return np.concatenate(kept.rows), kept.stamps


def test_the_parameter_offers_what_there_is():
    row = BY_NAME["filter.method"]
    assert row.choices == tuple(METHODS)
    assert row.default == FilterOptions().method == next(iter(METHODS))
    for name, method in METHODS.items():
        module = import_module(f"peg_on_hole_ros.estimator.methods.{name}")
        assert module.METHOD is method


@pytest.mark.parametrize("method", at_push(["one_level", "unscented"], list(METHODS)))
def test_what_is_smoothed_is_the_estimate_of_the_method_that_is_set(method):
    plain, smooth = replayed(method, False)[0], replayed(method, True)
    np.testing.assert_allclose(smooth[0]["state"], plain["state"], rtol=1e-9, atol=1e-12)
    assert len(smooth[1]) == len(plain) > 600
    if method != "mixture":
        mixture = replayed("mixture", True)[0]
        # Those of one_level differ by 0.2 N, of others by more.
        assert np.abs(mixture["normal"] - plain["normal"])[300:].max() > 0.1


@pytest.mark.parametrize("method", METHODS)
def test_node_and_replay_take_every_method_in_their_compiled_call(method):
    options = replace(FilterOptions(), method=method)
    pipeline = Pipeline(replace(Configuration(), filter=options))
    assert type(pipeline.filter) is ContactFilter
    assert METHODS[method].settings is not None


@pytest.mark.parametrize("method", at_push(["balance"], list(METHODS)))
def test_a_configuration_file_names_the_method(method, tmp_path):
    file, out = tmp_path / "cell.yaml", tmp_path / "out.mcap"
    stated = (ROOT / "config" / "closing_with_slip.yaml").read_text(encoding="utf-8")
    at = stated.index("    joints:")
    text = f"{stated[:at]}    filter: {{method: {method}}}\n{stated[at:]}"
    file.write_text(text, encoding="utf-8")
    assert main(["replay", str(BAG), "--config", str(file), "--out", str(out)]) == 0
    assert stored_configuration(Bag(out)).filter.method == method


@cache
def tracks(motion):
    """Return a slow motion, and what each method tells of it."""
    truth = scenes.truth_of(scenes.Case("slow", motion, speed=SLOWER), Configuration())
    configuration = runs.always_in_contact(truth.plan.configuration)
    samples = list(measure(truth, 7))
    found = {
        name: runs.run(configuration, samples, lambda: 0.0, method.make)
        for name, method in METHODS.items()
    }
    return truth, found


@pytest.mark.nightly
@pytest.mark.parametrize("method", [name for name in METHODS if name != "mixture"])
def test_a_slow_motion_is_the_same_to_all(method):
    """
    Two estimates of one truth are apart by no more than the sum of both bounds.

    Where a peg only tilts, to those for which it does; where it turns too, to all others.
    """
    turns = method != "one_dof"
    truth, found = tracks("closing with slip" if turns else "closing without slip")
    own, default = found[method], found["mixture"]
    late = own.t_ns >= runs.SETTLE_NS
    apart = np.abs(own.values[late, 6:] - default.values[late, 6:])
    bounds = runs.INSIDE_STDDEVS * (own.stddev[late, 6:] + default.stddev[late, 6:])
    assert (apart <= bounds).mean() > 0.95
    # Not because one of them says nothing.
    assert np.isfinite(bounds).all()


@pytest.mark.nightly
def test_the_lengths_of_a_small_tilt_are_off_by_a_percent():
    """At 0.08 to 0.15 rad lengths are 0.1 to 2 % off, by the square of the tilt."""
    truth = scenes.truth_of(scenes.CASES[0], Configuration())
    configuration = runs.always_in_contact(truth.plan.configuration)
    samples = list(measure(truth))
    full, small = (
        runs.run(configuration, samples, lambda: 0.0, METHODS[name].make)
        for name in ("balance", "small_angle")
    )
    late = full.t_ns >= 2 * runs.SETTLE_NS
    off = np.abs(small.values[late, 6:] / full.values[late, 6:] - 1.0).mean()
    assert 1e-3 < off < 2e-2
    # Motion comes from the same orientations.
    np.testing.assert_array_equal(small.values[:, :6], full.values[:, :6])


def test_a_method_with_a_class_of_its_own_is_not_smoothed_silently(monkeypatch):
    monkeypatch.setitem(METHODS, "one_level", Method(METHODS["one_level"].make))
    with pytest.raises(PegOnHoleError, match="'one_level' cannot be smoothed: leave --smooth out"):
        replayed("one_level", True)
