"""An engine that nobody here wrote, MuJoCo, carries the reactions that the equations say."""

import importlib.util

import numpy as np
import pytest

from simulated import ROOT


@pytest.fixture(scope="module")
def draw():
    spec = importlib.util.spec_from_file_location("draw", ROOT / "docs" / "figures" / "draw.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# Of the largest reaction: median and 95th percentile over the trace, and rms over the mean. What
# is left is the engine's compliance: its peg vibrates on the springs of its contacts, most when
# it turns (measured 0.2, 0.7, 0.9 % without turning, 0.8, 2.0, 2.6 % with).
BOUNDS = {"mujoco_align": (0.003, 0.01, 0.012), "mujoco_turning": (0.01, 0.025, 0.03)}
# From the wrench alone the vibration's accelerations enter too.
BOUNDS_SIX = {"mujoco_align": (0.003, 0.025, 0.025), "mujoco_turning": (0.025, 0.07, 0.085)}


@pytest.mark.parametrize("name", BOUNDS)
def test_reactions_of_the_engine_are_those_of_the_equations(draw, name):
    path = ROOT / "test" / "data" / f"{name}.npz"
    found = draw.compare_engine(path)
    assert np.all(found["engine"][:, 100:] > 5)
    errors = draw.engine_errors(found)
    for way, bounds in (("balance", BOUNDS[name]), ("six", BOUNDS_SIX[name])):
        for kind, bound in zip(("median", "p95", "rms"), bounds, strict=True):
            assert np.all(errors[way][kind] < bound), (way, kind, errors[way][kind])
    # The tilt sweeps most of the way down to gamma0, 0.2003 rad.
    assert found["gamma"][0] > 0.59 and found["gamma"][-1] < 0.225


def test_traces_are_small():
    sizes = [path.stat().st_size for path in (ROOT / "test" / "data").glob("mujoco_*.npz")]
    assert len(sizes) == 2 and sum(sizes) < 500_000


@pytest.mark.nightly
def test_figures_are_drawn(draw, tmp_path, capsys):
    draw.main(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        "limit_at_gamma0.png",
        "mujoco.png",
        "wedging.png",
    }
    said = capsys.readouterr().out
    assert "slip     0 rad/s: N_K/mg below 2.170, above 15.178" in said
    assert "slip 0.001 rad/s: N_K/mg below 3.797, above 3.797" in said
