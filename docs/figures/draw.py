"""
Draw the figures of the mechanics' documents; needs matplotlib.

    PYTHONPATH=test python docs/figures/draw.py [FOLDER]

Writes PNG files to FOLDER (this one by default) and prints the numbers that the text quotes.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from paper import examples, printed
from paper.wedging import wedging
from peg_on_hole_ros.mechanics import reference
from peg_on_hole_ros.mechanics.geometry import (
    contact_geometry_above,
    normals,
    velocity_jacobians,
)
from peg_on_hole_ros.mechanics.scene import Scene

HERE = Path(__file__).parent
TRACES = HERE.parents[1] / "test" / "data"
SCENE = Scene()
WEIGHT = SCENE.peg_mass * 9.80665
CLOSING = -0.16


def limit_at_gamma0(slip):
    """
    Return excesses and N_K over the weight above and below gamma0 for imposed closing.

    Parameters
    ----------
    slip : float
        phi' [rad/s].

    """
    e = np.geomspace(1e-8, 2e-2, 240)
    rates = np.array([CLOSING, 0.0, slip])
    above = [imposed_above(x, rates) for x in e]
    below = [examples.imposed_two_point(SCENE, SCENE.gamma0 - x, rates)[0] for x in e]
    return e, np.array(above) / WEIGHT, np.array(below) / WEIGHT


def imposed_above(excess, rates):
    """Return N_K of imposed motion at gamma0 + excess, accurate for the smallest excess."""
    g = contact_geometry_above(SCENE, excess)
    J = velocity_jacobians(g, SCENE.peg_diameter, SCENE.hole_diameter)
    u, _ = reference.slip_directions(J, rates, 0.0)
    p = rates[0]
    right = SCENE.peg_mass * np.array([g.ddh_c * p**2, 0, g.ddz_c * p**2]) + [0, 0, WEIGHT]
    return np.linalg.solve((normals(g) - SCENE.friction * u).T, right)[0]


def draw_limit(folder):
    """Draw N_K on both sides of gamma0: the limit for pure alignment is not uniform."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), sharey=True)
    for slip, colour in ((0.0, "C3"), (0.001, "C1"), (0.01, "C2"), (0.1, "C0"), (2.0, "C4")):
        e, above, below = limit_at_gamma0(slip)
        label = "pure alignment" if not slip else f"$\\varphi'$ = {slip:g} rad/s"
        axes[0].semilogx(e, below, colour, label=label)
        axes[1].semilogx(e, above, colour, label=label)
        print(f"slip {slip:5g} rad/s: N_K/mg below {below[0]:.3f}, above {above[0]:.3f}")
    at = printed.reaction(SCENE, (-CLOSING, 0, 0)) / WEIGHT
    print(f"(39) as printed, pure alignment: {at:.3f}")
    for ax in axes:
        ax.axhline(at, color="k", ls=":", lw=1, label="(39) as printed: K at rest")
        ax.grid(alpha=0.3)
    axes[0].invert_xaxis()
    axes[0].set(xlabel=r"$\gamma_0 - \gamma$ [rad], two-point", ylabel=r"$N_K / mg$")
    axes[1].set(xlabel=r"$\gamma - \gamma_0$ [rad], three-point", ylim=(0, 18))
    axes[0].legend(fontsize=7, loc="upper left")
    figure.suptitle("Imposed closing at 0.16 rad/s by a couple, f = 0.2", fontsize=10)
    save(figure, folder / "limit_at_gamma0.png")


def draw_determinant(folder):
    """Draw the determinant and the critical frictions of pure alignment over the tilt."""
    gamma = SCENE.gamma0 + np.geomspace(5e-5, 0.05, 200)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4))
    for slip, colour in ((0.0, "C3"), (0.02, "C2"), (2.0, "C0")):
        found = [wedging(SCENE, [g, 0, 0], [CLOSING, 0, slip]) for g in gamma]
        label = "pure alignment" if not slip else f"$\\varphi'$ = {slip:g} rad/s"
        axes[0].plot(gamma, [x.determinant for x in found], colour, label=label)
        points = [(g, root) for g, x in zip(gamma, found) for root in x.roots if root < 0.8]
        if points:
            axes[1].plot(*np.array(points).T, colour + ".", ms=3, label=label)
    axes[0].axhline(0, color="k", lw=0.8)
    axes[0].set(xlabel=r"$\gamma$ [rad]", ylabel="normalised determinant", title="f = 0.2")
    axes[1].axhline(SCENE.friction, color="k", ls=":", lw=1)
    axes[1].set(xlabel=r"$\gamma$ [rad]", ylabel="critical friction", xlim=(0.063, 0.067))
    for ax in axes:
        ax.grid(alpha=0.3)
        ax.legend(fontsize=7)
    save(figure, folder / "wedging.png")


def compare_engine(path):
    """
    Return the trace of another engine and what the equations say of it.

    Returns
    -------
    dict
        t [s], gamma [rad], `engine`, `balance`, `six` : N_K, N_B1, N_B2 over time, (3, n) [N]:
        as simulated; from force balance with the simulated change of momentum; from the six
        equations and the applied wrench alone.

    """
    trace = np.load(path)
    D, d, H, m, f, gravity = trace["scene"]
    scene = Scene(D, d, H, m, f, gravity=(0.0, 0.0, -float(gravity)))
    q, rates, wrench = (trace[name].T.astype(float) for name in ("q", "rates", "wrench"))
    to_P = np.swapaxes(reference.peg_axes(q), 0, 1)
    wrench_P = np.concatenate(
        [reference.product(to_P, wrench[:3]), reference.product(to_P, wrench[3:])]
    )
    A, r = reference.six_equations(scene, q, rates, wrench_P, 0.0)
    A, r = np.moveaxis(A, -1, 0), np.moveaxis(r, -1, 0)
    six = np.linalg.solve(A, r[..., None])[:, 3:, 0].T
    # The force balance of the equations, its accelerations replaced by the simulated ones.
    turn = np.swapaxes(reference.precession_axes(q[1]), 0, 1)
    momentum = reference.product(turn, trace["momentum_rate"].T[:3].astype(float))
    applied = reference.product(turn, wrench[:3]) - np.array([0, 0, m * gravity])[:, None]
    balance = np.linalg.solve(A[:, 3:, 3:], (applied - momentum).T[..., None])[..., 0].T
    normal = trace["normal"].T.astype(float)
    found = {"engine": normal, "balance": balance, "six": six}
    return {"t": trace["t"].ravel(), "gamma": q[0], **found}


def engine_errors(found, skip=100):
    """Return rms over the mean, and median and 95th percentile over the largest, of each way."""
    normal = found["engine"][:, skip:]
    result = {}
    for way in ("balance", "six"):
        error = np.abs(found[way][:, skip:] - normal)
        result[way] = {
            "rms": np.sqrt(np.mean(error**2, axis=1)) / normal.mean(axis=1),
            "median": np.median(error, axis=1) / normal.max(),
            "p95": np.percentile(error, 95, axis=1) / normal.max(),
        }
    return result


def draw_engine(folder):
    """Draw the reactions of another engine beside those of the equations."""
    paths = sorted(TRACES.glob("mujoco_*.npz"))
    figure, axes = plt.subplots(len(paths), 1, figsize=(8, 3 * len(paths)), sharex=True)
    for ax, path in zip(np.atleast_1d(axes), paths):
        found = compare_engine(path)
        for i, (name, colour) in enumerate(zip(("K", "B1", "B2"), ("C0", "C1", "C2"))):
            ax.plot(found["gamma"], found["engine"][i], colour, lw=2.5, alpha=0.4)
            ax.plot(found["gamma"], found["balance"][i], colour, lw=0.7, label=f"$N_{{{name}}}$")
        ax.set(ylabel="N [N]", title=f"{path.stem}: MuJoCo pale, equations thin", ylim=(0, None))
        ax.invert_xaxis()
        ax.grid(alpha=0.3)
        ax.legend(fontsize=7)
        for way, errors in engine_errors(found).items():
            print(path.stem, way, {k: np.round(100 * v, 2) for k, v in errors.items()}, "%")
    np.atleast_1d(axes)[-1].set_xlabel(r"$\gamma$ [rad]")
    save(figure, folder / "mujoco.png")


def save(figure, path):
    """Write a figure."""
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    plt.close(figure)
    print(path.name)


def main(folder=HERE):
    """Draw all figures."""
    folder = Path(folder)
    draw_limit(folder)
    draw_determinant(folder)
    draw_engine(folder)


if __name__ == "__main__":
    main(*sys.argv[1:2])
