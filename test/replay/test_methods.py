"""Every method of `filter.method` is one in the registry, for node, replay and smoother."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.configuration import BY_NAME
from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimator.methods.method import Method
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.replay.run import replay_bag, stored_configuration
from simulated import ROOT
from tiers import at_push

BAG = ROOT / "bags" / "closing_with_slip.mcap"


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


@pytest.mark.parametrize("method", at_push(["one_level"], list(METHODS)))
def test_what_is_smoothed_is_the_estimate_of_the_method_that_is_set(method):
    plain, smooth = replayed(method, False)[0], replayed(method, True)
    np.testing.assert_allclose(smooth[0]["state"], plain["state"], rtol=1e-9, atol=1e-12)
    assert len(smooth[1]) == len(plain) > 600
    if method != "mixture":
        mixture = replayed("mixture", True)[0]
        # Those of one_level differ by 0.2 N, of others by more.
        assert np.abs(mixture["normal"] - plain["normal"])[300:].max() > 0.1


def test_a_method_with_a_class_of_its_own_is_not_smoothed_silently(monkeypatch):
    monkeypatch.setitem(METHODS, "one_level", Method(METHODS["one_level"].make))
    with pytest.raises(PegOnHoleError, match="'one_level' cannot be smoothed: leave --smooth out"):
        replayed("one_level", True)
