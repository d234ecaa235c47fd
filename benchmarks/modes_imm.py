"""
Hold the recursive mode probability against an interacting-multiple-model filter.

    python benchmarks/modes_imm.py [--scenes 6] --out DIR

Both see the same measurements of a handful of the scenes. The IMM is filterpy's, over three
filters on the numpy model: three-point contact, constant rates (the peg is guided by the hole),
and a free body that the measured couple turns. Its modes come from the likelihoods of the
orientations alone, or, in a second run, also from what the recursive one knows: the load, and the
tilt against gamma0. Told are the share of samples whose most probable mode is wrong, how late the
transition is sure, and the processor time of a step, that of one filter of the three beside it.
"""

import argparse
import json
import sys
from math import exp
from pathlib import Path
from time import process_time

import numpy as np
from filterpy.kalman import IMMEstimator
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.reference.kalman import ReferenceFilter

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.measurement import PegJoints, WrenchReduction
from peg_on_hole_ros.monitoring.carried import carried_load, new_means
from peg_on_hole_ros.monitoring.contacts import below, load_evidence
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.simulation.measure import START_NS, measure
from scenes_draw import Case, noise_seeds, plan_of
from scenes_labels import labels_of
from scenes_play import truth_of

MODES = ("three_point", "two_point", "open")
CLASS = {"three_point": 0, "stuck": 0, "two_point": 1, "open": 2}
SURE, SETTLE, LATE = 0.9, 0.05, 0.1
METHODS = ("recursive", "IMM, orientations", "IMM, all evidence")
CASES = [
    Case("insertion", 0), Case("insertion", 6), Case("clearance", 0), Case("wedge", 1),
    Case("contact_loss", 0), Case("retry", 0),
]  # fmt: skip


class Hypothesis:
    """One mode's filter, as filterpy's IMM asks for it."""

    def __init__(self, mode: str, reference: ReferenceFilter, options):
        self.mode, self.filter, self.options = mode, reference, options
        self.dt, self.R, self.likelihood = 0.0, np.eye(3), 1.0
        self.seconds = 0.0

    @property
    def x(self):
        """State, shape (14,)."""
        return self.filter.x

    @x.setter
    def x(self, value):
        self.filter.x = value

    @property
    def P(self):
        """Covariance, shape (14, 14)."""
        return self.filter.P

    @P.setter
    def P(self, value):
        self.filter.P = value

    def predict(self, u=None):
        """Predict over dt under the mode's own motion."""
        begun = process_time()
        self._predict()
        self.seconds += process_time() - begun

    def _predict(self):
        reference, before = self.filter, (self.x.copy(), self.P.copy())
        if self.mode == "three_point":
            try:
                reference.predict_contact(self.dt)
                if np.isfinite(self.x).all() and np.linalg.eigvalsh(self.P).min() > -1e-9:
                    return
            except (PegOnHoleError, np.linalg.LinAlgError, FloatingPointError):
                pass
            self.x, self.P = before
        if self.mode == "open":
            self.x[3:6] += self.dt * free_turning(reference.scene, before[0])
        reference.predict_free(self.dt, self.options.free_rate_noise)

    def update(self, z):
        """Correct with an orientation; psi and phi may be off by turns."""
        z = z.copy()
        z[1:] -= 2 * np.pi * np.round((z[1:] - self.x[1:3]) / (2 * np.pi))
        self.filter.correct(z, self.R)
        # A bound: no one outlier decides for all time.
        self.likelihood = max(float(self.filter.likelihood), 1e-12)


def free_turning(scene, full):
    """Return gamma'', psi'', phi'' of a free body, shape (3,), by Euler's equations."""
    (gamma, _, phi), (dgamma, dpsi, dphi), M = full[:3], full[3:6], full[9:12]
    s, c = np.sin(gamma), np.cos(gamma)
    # Peg axes without phi: eta, e, zeta; gamma turns about -e.
    turn = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
    moment = np.array([*(turn @ M[:2]), M[2]])
    frame = np.array([dpsi * s, -dgamma, dpsi * c])
    inertia = np.array([scene.transverse_inertia] * 2 + [scene.axial_inertia])
    spin = frame + [0.0, 0.0, dphi]
    change = (moment - np.cross(frame, inertia * spin)) / inertia
    ddpsi = (change[0] - dpsi * dgamma * c) / s
    return np.array([-change[1], ddpsi, change[2] - ddpsi * c + dpsi * dgamma * s])


def stay(dt, rate):
    """Return the chance of each mode to become each other in dt, shape (3, 3)."""
    change = 1 - exp(-rate * dt)
    return np.eye(3) * (1 - change) + change / 3


def run_imm(configuration, samples, informed):
    """
    Return the IMM's mode probabilities, and its cost.

    Returns
    -------
    probabilities : ndarray, shape (n, 3)
        At each wrench.
    seconds, of_one : float
        A step, and of it the prediction on three contacts alone.

    """
    scene, options = configuration.scene, configuration.filter
    reduction = WrenchReduction(configuration.wrench, scene)
    orientation, imm = PegJoints(configuration.joints), None
    shadow = ContactFilter(scene, options, reduction.covariance)
    means, last, found = new_means(), None, []
    waiting, seconds = None, 0.0
    for sample in samples:
        if not isinstance(sample, WrenchSample):
            waiting = orientation(sample)
            continue
        if imm is None:
            shadow.start(waiting.q, waiting.covariance)
            bank = []
            for mode in MODES:
                reference = ReferenceFilter(scene, shadow.process, reduction.covariance)
                reference.x[:6], reference.P = shadow.x, shadow.joint_covariance()
                bank.append(Hypothesis(mode, reference, options))
            imm = IMMEstimator(bank, [0.6, 0.2, 0.2], stay(1e-3, 2.0))
            last, waiting = sample.t_ns, None
        dt, last = (sample.t_ns - last) * 1e-9, sample.t_ns
        u = reduction.on_peg(sample.force, sample.torque, imm.x[:3])
        begun = process_time()
        if dt > 0.0:
            for hypothesis in imm.filters:
                hypothesis.dt = dt
                hypothesis.filter.hold(u)
            imm.predict()
        if waiting is not None and dt > 0.0:
            for hypothesis in imm.filters:
                hypothesis.R = waiting.covariance
            imm.update(waiting.q)
            waiting = None
        if informed:
            shadow.x[:], shadow.u[:] = imm.x[:6], u
            shadow.Z[3:6, 3:6] = imm.P[3:6, 3:6]
            monitor = configuration.monitor
            load, noise = carried_load(shadow.memory, means, dt, monitor.evidence_time)
            moved = scene.peg_mass * monitor.free_acceleration
            scale = np.sqrt(monitor.contact_force_threshold**2 + moved**2 + 3.0 * noise)
            share = min(dt / monitor.evidence_time, 1.0)
            imm.mu[2] *= exp(-share * load_evidence(load, scale))
            under = below((scene.gamma0 - imm.x[0]) / np.sqrt(imm.P[0, 0]))
            # The tilt is no evidence that adds up: it says which of two can be at all.
            touching = imm.mu[0] + imm.mu[1]
            imm.mu[:2] = touching * (1 - under), touching * under
            imm.mu = np.maximum(imm.mu, 1e-9)
            imm.mu /= imm.mu.sum()
            imm._compute_mixing_probabilities()
        seconds += process_time() - begun
        found.append(imm.mu.copy())
    return np.array(found), seconds / len(found), bank[0].seconds / len(found)


def run_recursive(configuration, samples):
    """Return the pipeline's probabilities of three-point, two-point, free, and seconds a step."""
    pipeline, found, seconds = Pipeline(configuration), [], 0.0
    for sample in samples:
        begun = process_time()
        outputs = pipeline.on_sample(sample)
        seconds += process_time() - begun
        if outputs is not None:
            m = outputs.monitor
            three = m["mode_probability_three_point"] + m["mode_probability_stuck"]
            found.append([three, m["mode_probability_two_point"], m["mode_probability_free"]])
    return np.array(found), seconds / len(found), None


def scored(labels, probabilities):
    """Return samples and wrong ones, and how late the transition was sure [s], or None."""
    true = np.array([CLASS.get(kind, -1) for kind in labels.kind])
    asked = (true >= 0) & (labels.t >= SETTLE)
    wrong = int((probabilities.argmax(axis=1) != true)[asked].sum())
    latency = None
    if labels.transition is not None:
        sure = (probabilities[:, 1] > SURE) & (labels.t > SETTLE)
        rises = np.flatnonzero(np.diff(np.concatenate([[False], sure]).astype(int)) == 1)
        near = [labels.t[k] - labels.transition for k in rises]
        near = [x for x in near if abs(x) <= LATE]
        latency = float(near[0]) if near else float("nan")
    rises = int((np.diff((probabilities[:, 1] > SURE).astype(int)) == 1).sum())
    return {"samples": int(asked.sum()), "wrong": wrong, "latency": latency, "rises": rises}


def run_case(case, folder):
    """Return the scores of all methods on a scene, and the probabilities."""
    plan = plan_of(case)
    truth, why = truth_of(plan, folder)
    if truth is None:
        raise SystemExit(f"{case}: {why}")
    labels, configuration = labels_of(truth), plan.configuration
    samples = list(measure(truth, noise_seeds(case)[-1], START_NS))
    curves, scores = {}, {}
    for method in METHODS:
        if method == "recursive":
            curves[method], seconds, of_one = run_recursive(configuration, samples)
        else:
            informed = method == METHODS[2]
            curves[method], seconds, of_one = run_imm(configuration, samples, informed)
        scores[method] = scored(labels, curves[method]) | {"seconds": seconds, "of_one": of_one}
    return labels, curves, scores


def table(results) -> str:
    """Return the table in Markdown."""
    lines = [
        "| method | wrong samples | transition sure: off, median / largest [ms] | not within "
        "100 ms | rises per transition | a step, of it one filter [us] |",
        "|---|---|---|---|---|---|",
    ]
    for method in METHODS:
        rows = [scores[method] for _, _, scores in results.values()]
        through = [r for r in rows if r["latency"] is not None]
        late = np.array([r["latency"] for r in through])
        seen = np.abs(late[np.isfinite(late)]) * 1e3
        off = f"{np.median(seen):.1f} / {seen.max():.1f}" if seen.size else "-"
        wrong = sum(r["wrong"] for r in rows) / sum(r["samples"] for r in rows)
        rises = sum(r["rises"] for r in through) / max(len(through), 1)
        cost = f"{np.median([r['seconds'] for r in rows]) * 1e6:.0f}"
        if rows[0]["of_one"] is not None:
            cost += f", {np.median([r['of_one'] for r in rows]) * 1e6:.0f}"
        lines.append(
            f"| {method} | {wrong:.3f} | {off} | {len(late) - seen.size} of {len(late)} "
            f"| {rises:.1f} | {cost} |"
        )
    return "\n".join(lines)


def draw(results, path):
    """Draw probabilities along one scene with a transition and one with a loss, and the errors."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    colours = dict(zip(METHODS, ("#0072B2", "#E69F00", "#009E73"), strict=True))
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    names = list(results)
    through = next(n for n in names if results[n][0].transition is not None)
    lost = next((n for n in names if "open" in results[n][0].kind and "retry" in n), names[-1])
    for axis, name, column, what in (
        (axes[0], through, 1, "two_point"), (axes[1], lost, 2, "open"),
    ):  # fmt: skip
        labels, curves, _ = results[name]
        axis.fill_between(labels.t, labels.kind == what, color="0.88", step="mid", label="true")
        for method in METHODS:
            axis.plot(labels.t, curves[method][:, column], color=colours[method], label=method)
        axis.set_title(f"P({what}), {name.rsplit('_', 1)[0].replace('_', ' ')}")
        axis.set_xlabel("t [s]")
        axis.set_ylim(-0.03, 1.03)
    axes[0].legend(frameon=False, loc="center left", fontsize=9)
    for j, method in enumerate(METHODS):
        shares = [s[method]["wrong"] / s[method]["samples"] for _, _, s in results.values()]
        places = np.arange(len(names)) + (j - 1) * 0.27
        axes[2].barh(places, shares, 0.25, color=colours[method])
    axes[2].set_yticks(range(len(names)), [n.rsplit("_", 1)[0].replace("_", " ") for n in names])
    axes[2].invert_yaxis()
    axes[2].set_xlabel("share of samples told wrongly")
    figure.savefig(path, dpi=130)


def main(arguments=None):
    """Run, print the table, and write it with the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scenes", type=int, default=len(CASES))
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    results = {}
    # What the compiler costs at first is not counted.
    run_recursive_once(options.out / "truths")
    for case in CASES[: options.scenes]:
        results[str(case)] = run_case(case, options.out / "truths")
        print(case, json.dumps(results[str(case)][2]), file=sys.stderr, flush=True)
    text = table(results)
    print(text)
    (options.out / "modes_imm.md").write_text(text + "\n")
    draw(results, options.out / "modes_imm.png")


def run_recursive_once(folder):
    """Compile everything on one scene."""
    case = CASES[0]
    truth, _ = truth_of(plan_of(case), folder)
    samples = measure(truth, noise_seeds(case)[-1], START_NS)
    run_recursive(plan_of(case).configuration, samples)


if __name__ == "__main__":
    main()
