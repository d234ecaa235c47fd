"""
Compile what most tests run, before several workers would each do so at the same time.

    python tools/compiled.py [estimator|simulation]

Most of the time goes to functions that others call: a process looks through them once for all
that call them, and anew where it has the callers but one from the files of another process.
What is compiled is kept between runs, for each state of the sources.
"""

import argparse
import contextlib
import io
import sys
import tempfile
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from time import perf_counter

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "test")]

import compiled_beside as beside  # noqa: E402
from benchmarks.bag_steps import bag_samples, bag_steps  # noqa: E402
from insertions import inserted  # noqa: E402
from peg_on_hole_ros.bags.reader import Bag  # noqa: E402
from peg_on_hole_ros.cli.main import main  # noqa: E402
from peg_on_hole_ros.config.options import Configuration  # noqa: E402
from peg_on_hole_ros.identification.likelihood import Likelihood  # noqa: E402
from peg_on_hole_ros.identification.quantities import coordinates  # noqa: E402
from peg_on_hole_ros.identification.recording import recording, steady  # noqa: E402
from peg_on_hole_ros.measurements.orientation import PegJoints  # noqa: E402
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction  # noqa: E402
from peg_on_hole_ros.messages.warm_up import warm  # noqa: E402
from peg_on_hole_ros.records import WrenchSample  # noqa: E402
from peg_on_hole_ros.replay.run import stored_configuration  # noqa: E402
from peg_on_hole_ros.sim.truth import integrate  # noqa: E402
from peg_on_hole_ros.study import runs, scenes  # noqa: E402
from peg_on_hole_ros.study.chart import DEFAULT, step_times  # noqa: E402
from peg_on_hole_ros.study.smoothed import make_smoothed  # noqa: E402
from simulated import contact_plan, plan  # noqa: E402

NAME = "closing_with_slip"
BAG = ROOT / "bags" / f"{NAME}.mcap"
# Samples; enough for every estimator to have seen all.
FEW = 120


def estimator() -> None:
    """Replay in blocks and one by one, each estimator that is compared, and calibration."""
    warm(Configuration())
    nothing = io.StringIO()
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.redirect_stdout(nothing),
        contextlib.redirect_stderr(nothing),
    ):
        main(["replay", str(BAG), "--out", f"{folder}/out.mcap"])
    configuration = stored_configuration(Bag(BAG))
    samples = list(bag_samples(BAG, configuration))
    runs.run(configuration, samples[:FEW], perf_counter)
    told = runs.always_in_contact(configuration)
    runs.run(told, samples[:FEW], perf_counter, make_smoothed)
    step_times([DEFAULT], told, samples[:FEW], perf_counter)
    _steps(configuration)
    joints = PegJoints(configuration.joints)
    wrenches = [sample for sample in samples if isinstance(sample, WrenchSample)]
    angles = [joints(sample) for sample in samples if not isinstance(sample, WrenchSample)]
    record = recording(wrenches, angles)
    Likelihood(record, steady(record, configuration), configuration).run(
        coordinates(configuration)
    )


def _steps(configuration):
    """Take the parts of a step that are held against the estimator on filterpy."""
    taken = bag_steps(BAG, configuration)[:FEW]
    stamps = accumulate(each.dt for each in taken)
    rows = [beside.Wrench(t, each.u, each.q, each.R) for t, each in zip(stamps, taken)]
    noise = WrenchReduction(configuration.wrench, configuration.scene).covariance
    cell = beside.cell_of(configuration.scene, noise)
    assert all(np.isfinite(each.mean).all() for each in beside.run(beside.Compiled(cell, 7), rows))


def simulation() -> None:
    """Integrate three contacts, two, and a peg in the hole; and the bound along a motion."""
    closing = plan(NAME)
    truth = integrate(replace(closing, phases=closing.phases[:1]))
    scenes.bound_along(scenes.first_samples(truth, FEW))
    rates = [-0.16, 0.0, 0.0]
    pull = {"kind": "parted", "duration": 0.03, "rates": rates, "offset": [1e-3, 0.0, -5e-4]}
    integrate(contact_plan([0.22, 0.0, 0.0], rates, [-5e-4, 0.0, -5e-4], phases={"pull": pull}))
    inserted("goes_on")


if __name__ == "__main__":
    parts = {"estimator": estimator, "simulation": simulation}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("part", nargs="?", choices=list(parts))
    chosen = parser.parse_args().part
    for name, compile_part in parts.items():
        if chosen in (None, name):
            compile_part()
