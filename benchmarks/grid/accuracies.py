"""
Sensors, payloads, encoders and gauges that are off by as much as their data sheets state.

Of each scene all that `accuracy.*` states is drawn: normal, with the stated standard deviation,
once for the whole scene. Friction is drawn and learnt. A scene is played twice: with the
accuracies as they are stated (`stated`), and as if all were exact (`exact`). The table has which
share of the reactions that are called determined lies within 95 % bounds, of K, B1 and B2 the
least (limit 90 %); the stated deviation over the error, both root mean square over the load (limit
2.5); which share of the samples in contact is called determined; and which share of the frictions
there lies within bounds. `all` draws every kind, the others one kind alone, `nothing` none.
"""

from argparse import Namespace
from dataclasses import fields, replace
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.grid import cells, misstated, other_pegs
from benchmarks.grid.cells import Motion, truth_of
from benchmarks.grid.misstated import with_scene, with_sections, with_values
from benchmarks.harness.errors import (
    REACTIONS,
    SETTLE_NS,
    changed_parameters,
    drawn,
    inside,
    runs_of,
)
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import play
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.config.options import Accuracy
from peg_on_hole_ros.measurements.rotations import tilt_axes
from peg_on_hole_ros.records import ACCURACY_PARAMETERS, JointSample
from peg_on_hole_ros.sim.measure import START_NS, measure, measured_angles, sensor_wrench
from peg_on_hole_ros.study.runs import LEAST_COVERED

FIRST_SEED = 910_000
MOTIONS = {
    str(motion): motion
    for motion in (
        Motion(1e-4, 0.2, 0.16, "slip"),
        Motion(5e-4, 0.2, 0.16, "reversals"),
        Motion(1e-4, 0.2, 0.16, "align"),
        Motion(2e-3, 0.2, 0.16, "slip"),
        Motion(1e-4, 0.5, 0.16, "slip"),
    )
}
TRUTHS = (*MOTIONS, *other_pegs.PEGS)
ALL, NOTHING = "all", "nothing"
SCENES, OF_KIND, QUICK = 60, 10, 10
SHARP = 2.5
# Parameters of each kind that is drawn; a low-pass is no error of a data sheet.
FIELDS = {
    kind: tuple(name.removeprefix("accuracy.") for name in names)
    for kind, names in ACCURACY_PARAMETERS.items()
    if kind != "low_pass"
}


@cache
def truth_named(name: str):
    """Return one of TRUTHS."""
    return truth_of(MOTIONS[name])[0] if name in MOTIONS else other_pegs.cycle(name)


def _load(truth) -> float:
    """Return what all contacts carry together in the mean, while any does [N]."""
    load = np.nansum(truth.normal, axis=1)
    return float(load[load > 0.0].mean()) if (load > 0.0).any() else 0.0


def spread_of(kind: str) -> Accuracy:
    """Return what is drawn of a kind: the default accuracies, the others exact."""
    if kind == ALL:
        return Accuracy()
    names = FIELDS.get(kind, ())
    return replace(Accuracy.exact(), **{name: getattr(Accuracy(), name) for name in names})


class Cell:
    """
    A cell that is off by what a seed draws of accuracies.

    Parameters
    ----------
    truth : Truth
        Of whose configuration a payload is stated.
    accuracy : Accuracy
        Standard deviations of what is drawn.
    seed : sequence of int

    Attributes
    ----------
    gain : ndarray, shape (6, 6)
        What the sensor makes of forces and torques.
    as_it_is, stated : Truth
        With the sensor and payload that there are, and with the sizes that are stated.

    """

    def __init__(self, truth, accuracy: Accuracy, seed):
        draw = np.random.default_rng(seed)
        wrench, scene = truth.plan.configuration.wrench, truth.plan.configuration.scene
        # All are drawn, so that those of one kind are the same beside others and alone.
        common, own, spoken = draw.normal(size=3)[0], draw.normal(size=6), draw.normal(size=(6, 6))
        place, axes, com = draw.normal(size=(3, 3))
        heavier, thicker, wider = draw.normal(size=3).tolist()
        self._tilt, peg_tilt = np.sqrt(0.5) * accuracy.orientation * draw.normal(size=(2, 2))
        self._peg_turn = np.array([*peg_tilt, 0.0])
        neighbours = np.kron(np.eye(2), 1.0 - np.eye(3))
        self.gain = np.eye(6) + accuracy.crosstalk * spoken * neighbours
        self.gain += np.sqrt(0.5) * accuracy.gain * np.diag(common + own)
        self.as_it_is = with_values(
            truth, "wrench",
            sensor_xyz=tuple(np.array(wrench.sensor_xyz) + accuracy.sensor_xyz * place),
            sensor_rpy=tuple(np.array(wrench.sensor_rpy) + accuracy.sensor_rpy * axes),
            payload_mass=wrench.payload_mass * (1.0 + accuracy.payload_mass * heavier),
            payload_com=tuple(np.array(wrench.payload_com) + accuracy.payload_com * com),
        )  # fmt: skip
        # Contacts give by what they carry in the mean; what is stated has that much less room.
        gives = accuracy.compliance * abs(draw.normal()) * _load(truth)
        self.stated = with_scene(
            truth,
            peg_diameter=scene.peg_diameter + accuracy.diameter * thicker + gives,
            hole_diameter=scene.hole_diameter + accuracy.diameter * wider,
        )

    def samples(self, seed: int) -> list[tuple]:
        """Return what its sensors measure, with noise of a seed."""
        exact = sensor_wrench(self.as_it_is) @ self.gain.T
        samples = measure(self.as_it_is, seed, exact=exact)
        return [tuple(map_joints(sample, self.turned)) for sample in samples]

    def turned(self, position: tuple) -> tuple:
        """Return the angles that encoders read of a peg [rad]."""
        turned = measured_angles(
            np.array([position]), self._peg_turn[None, :], tilt_axes(self._tilt)
        )
        return tuple(turned[0].tolist())


def map_joints(sample, change):
    """Return a joint state with other positions; others as they are."""
    if not isinstance(sample, JointSample):
        return sample
    return sample._replace(position=change(sample.position))


def scene_of(kind: str, number: int):
    """Return a truth and the seed of a scene; every other one carries a payload."""
    truth = truth_named(TRUTHS[number % len(TRUTHS)])
    if kind == "payload" or (number // len(TRUTHS)) % 2:
        mass = truth.plan.configuration.scene.peg_mass
        truth = with_values(
            truth, "wrench", payload_mass=2.0 * mass, payload_com=(0.0, 0.0, -0.03)
        )
    return truth, [FIRST_SEED, number]


def score_member(member: Member, folder: Path) -> dict:
    """Return the figures of a scene with accuracies stated, and as if all were exact."""
    kind, number = member.of
    truth, seed = scene_of(kind, number)
    spread = spread_of(kind)
    cell = Cell(truth, spread, seed)
    samples, noise = cell.samples(FIRST_SEED + number), FIRST_SEED + number
    stated = Accuracy() if kind in (ALL, NOTHING) else spread
    found = {}
    for name, accuracy in (("stated", stated), ("exact", Accuracy.exact())):
        told = with_sections(cell.stated, accuracy=accuracy).plan.configuration
        parameters = changed_parameters(drawn(told, noise))
        record = play(parameters, samples, START_NS + SETTLE_NS)
        found[name] = figures(truth, runs_of(truth, [record]), record)
    return found


def figures(truth, runs, record) -> dict:
    """Return shares and mean squares of the determined reactions of one run."""
    told = (truth.mode == "three_point") & truth.known & (truth.t_ns >= SETTLE_NS)
    chosen = runs.determined[0] & told
    error, stddev = runs.error[0][chosen][:, REACTIONS], runs.stddev[0][chosen][:, REACTIONS]
    load = truth.normal[chosen].sum(axis=1, keepdims=True)
    rows = record.rows_at(truth.t_ns, START_NS)
    friction, spread = (rows.monitor[name][chosen] for name in ("friction", "friction_stddev"))
    off = friction - truth.plan.configuration.scene.friction
    return {
        "samples": int(told.sum()),
        "determined": int(chosen.sum()),
        "covered": inside(error, stddev).sum(axis=0).tolist(),
        "friction": int(inside(off, spread).sum()),
        "error2": float(np.square(error / load).sum()),
        "stated2": float(np.square(stddev / load).sum()),
    }


def pooled(rows: list[dict]) -> dict:
    """Return the figures of several scenes: the least share covered, sharpness, determined."""
    determined = sum(row["determined"] for row in rows)
    covered = np.sum([row["covered"] for row in rows], axis=0)
    error2, stated2 = (sum(row[name] for row in rows) for name in ("error2", "stated2"))
    return {
        "covered": float(covered.min() / determined) if determined else None,
        "sharp": float(np.sqrt(stated2 / error2)) if error2 else None,
        "friction": sum(row["friction"] for row in rows) / determined if determined else None,
        "determined": determined / sum(row["samples"] for row in rows),
    }


def report(found, options) -> Report:
    """Return a row for each kind, and what exceeds the limits."""
    of: dict[str, list] = {}
    for member, row in found:
        of.setdefault(member.of[0], []).append(row)
    head = ["drawn", "scenes"]
    for name in ("covered (limit 90 %)", "deviation over error (limit 2.5)", "determined"):
        head += [f"{name}: exact", "stated"]
    head += ["friction covered: exact", "stated"]
    lines, problems = [], []
    for kind, rows in of.items():
        exact, stated = (pooled([row[name] for row in rows]) for name in ("exact", "stated"))
        line = [kind, len(rows), *(percent(each["covered"]) for each in (exact, stated))]
        line += [
            "" if each["sharp"] is None else f"{each['sharp']:.2f}" for each in (exact, stated)
        ]
        for name in ("determined", "friction"):
            line += [percent(each[name]) for each in (exact, stated)]
        lines.append(line)
        if kind == NOTHING:
            continue
        if stated["covered"] < LEAST_COVERED:
            problems.append(f"{kind}: {percent(stated['covered'])} are covered, below 90 %")
        if kind == ALL and stated["sharp"] > SHARP:
            problems.append(f"{kind}: deviation over error is {stated['sharp']:.2f}, above 2.5")
    return Report(table(head, lines), problems=problems)


def members(options: Namespace) -> list[Member]:
    """Return scenes of everything, and fewer of each kind."""
    counts = {ALL: SCENES, NOTHING: OF_KIND, **dict.fromkeys(FIELDS, OF_KIND)}
    if options.quick:
        counts = {ALL: QUICK}
    return [
        Member(f"{kind}_{number:03d}", [kind, number])
        for kind, count in counts.items()
        for number in range(count)
    ]


def _add_options(parser):
    parser.add_argument("--quick", action="store_true", help=f"{QUICK} scenes of everything")


FAMILY = Family(
    members, score_member, report, options=_add_options,
    group=lambda member: member.of[1] % len(TRUTHS), sources=(cells, misstated, other_pegs),
)  # fmt: skip
assert {name for names in FIELDS.values() for name in names} == {f.name for f in fields(Accuracy)}
