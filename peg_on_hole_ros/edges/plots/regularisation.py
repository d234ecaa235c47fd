"""Velocity scale of friction against error: what it spoils, and how integrators bear it."""

import numpy as np
from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, PINK = "#0072b2", "#d55e00", "#009e73", "#cc79a7"


def figure(effects, default: float) -> Figure:
    """
    Draw the effects of a velocity scale.

    Parameters
    ----------
    effects : list of study.regularisation.Effect
    default : float
        Scale that is the default [m/s].

    """
    scale = np.array([effect.scale for effect in effects])
    fig = Figure(figsize=(12, 5), dpi=110, layout="constrained")
    model, steps = fig.subplots(1, 2)
    _line(model, scale, [e.slow_reaction_error for e in effects], BLUE, "o",
          "error of N_K, closing slowly near gamma0 [share]")  # fmt: skip
    _line(model, scale, [e.stop_angle_error for e in effects], ORANGE, "s",
          "angle from where dry friction stops the peg [rad]")  # fmt: skip
    model.axhline(1e-4, color="grey", linewidth=1, linestyle=":")
    text = "one measured orientation's\nstandard deviation [rad]"
    model.annotate(
        text, (scale[-1], 1e-4), ha="right", va="top", fontsize=8, xytext=(0, -3),
        textcoords="offset points",
    )  # fmt: skip
    model.set_title("what it spoils of dry friction")
    named = (
        ("implicit_error", GREEN, "o", "implicit Euler (default)"),
        ("linearly_implicit_error", PINK, "s", "linearly implicit Euler"),
        ("explicit_error", ORANGE, "^", "explicit Euler"),
    )
    for name, color, marker, label in named:
        values = np.array([getattr(e, name) for e in effects])
        _line(steps, scale, np.where(np.isfinite(values), values, np.nan), color, marker, label)
    steps.set_title("speed error of steps of 1 ms as the peg stops [m/s]")
    for axis in (model, steps):
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_xlabel("velocity scale of friction [m/s]")
        axis.axvline(default, color="black", linewidth=1, linestyle="--", label="default")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=9)
    return fig


def _line(axis, x, y, color, marker, label):
    axis.plot(x, y, color=color, marker=marker, markersize=5, label=label)
