"""
Scenes over which each tuned number is varied, and what is said of them, as figures.

Most are recordings that the stream of node and replay is played with, as they are or with a fault;
the last are recordings that cells are calibrated with.
"""

import hashlib
import json
import os
from collections.abc import Callable
from functools import cache
from math import nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

import benchmarks.insertion.scenes as insertions
import benchmarks.scenes.draw as closings
from benchmarks.faults import scenes as shipped
from benchmarks.faults.expected import BY_NAME, PART, Case
from benchmarks.faults.injector import inject
from benchmarks.faults.play import LEVELS, play
from benchmarks.faults.scenes import Part, Scene, read_part
from benchmarks.faults.score import errors_of, false_jams, untold_jams, wrong_flags
from benchmarks.harness.truths import truth_of
from benchmarks.tuned_numbers import whole
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.simulated_bag import write_bag
from peg_on_hole_ros.bags.truth import BOUND_STDDEVS, THREE_POINT

TO_THE_END = 99.0
# Of a faulted recording, where a fault is that does not last [s].
WITHIN = (0.2, 0.4)


class Played(NamedTuple):
    """A part of a recording by the name of its source, and the fault that is put into it."""

    part: Part
    fault: Case = BY_NAME["no fault"]


def _bag(source, begin=0.0, end=TO_THE_END, fault="no fault", faulted=WITHIN):
    return Played(Part(source, begin, end, faulted, ""), BY_NAME[fault])


def _drawn(family, number=0):
    return Played(Part(f"{family}_{number}", 0.0, TO_THE_END, WITHIN, ""))


def _called(source, begin, end, at, what):
    case = Case(what, "call", {"what": what}, **PART)
    return Played(Part(source, begin, end, (at, TO_THE_END), ""), case)


FAULTED = {
    "closing_with_slip": (
        "wrench noise x 5", "joint noise x 5", "encoders stand still", "the sensor stands still",
        "each wrench 10 times", "spikes of 500 N", "saturates at 20 N, 1 N m",
        "wrench with the other sign", "axes 5 of 23", "torque in N mm", "angles in degrees",
        "1 % of wrenches 80 ms late", "up to 5 ms of delay", "both clocks jump back by 5 s",
    ),
    "closing_without_slip": ("bias of 5 N along the peg",),
}  # fmt: skip
# Of the cycle the second try: free air, touch-down at 8.7 s, slide, transition at 10.29 s, in the
# hole.
PLAYED = {
    "closing": _bag("closing_with_slip"),
    "jam": _bag("closing_without_slip"),
    "cycle": _bag("working_cycle", 8.5, 10.5),
    "insertion": _bag("insertion"),
    "cell_ur_like": _bag("cell_ur_like", 1.6, 3.0),
    "cell_ur_like_base": _bag("cell_ur_like_base", 1.6, 2.2),
    "cell_iiwa_like": _bag("cell_iiwa_like", 1.6, 4.8),
    "cell_franka_like": _bag("cell_franka_like", 1.6, 2.3),
    **{family: _drawn(family) for family in closings.FAMILIES if family != "insertion"},
    "insertion jammed": _drawn("jammed"),
    "tare in the air": _called("working_cycle", 8.0, 8.7, 0.5, "tare"),
    "payload in the air": _called("working_cycle", 8.0, 8.6, 0.5, "payload"),
    "expected insertion": _called("working_cycle", 9.9, 10.6, 0.3, "expect insertion"),
    "cycle: joint states stamped 20 ms late":
        _bag("working_cycle", 8.7, 10.4, "joint states stamped 20 ms late"),
    **{f"{source}: {each}": _bag(source, fault=each) for source, of in FAULTED.items()
       for each in of},
}  # fmt: skip
# Of a recording that is calibrated with.
WHOLE: dict[str, Callable[[], dict]] = {
    "calibration": whole.calibration,
    "still poses": whole.still_poses,
    "presses": whole.presses,
}
SCENES = (*PLAYED, *WHOLE)


class Came(NamedTuple):
    """
    What came of a scene.

    Attributes
    ----------
    digest : str
        Of everything that was said, bit for bit.
    figures : dict of str to float, or str
        NaN where there is nothing that counts.

    """

    digest: str
    figures: dict


def came_of(name: str, folder: Path) -> Came:
    """Return what comes of a scene; `folder` keeps what is simulated."""
    if name in WHOLE:
        figures = WHOLE[name]()
        return Came(_digest_of(figures), figures)
    played = PLAYED[name]
    scene, digest = _scene(played.part, folder), hashlib.sha256()
    recording = scene.recording
    if played.fault.fault:
        begin, end = (0.0, TO_THE_END) if played.fault.lasts else played.part.faulted
        recording = inject(
            recording, played.fault.fault, begin, end, cell=scene.cell, **played.fault.parameters
        )
    said = play(scene, recording, lambda outputs: digest.update(outputs.row.tobytes()))
    for values in (said.true_ns, said.mode, said.jamming, said.loss, said.overload, said.level):
        digest.update(values.tobytes())
    texts = {"told": said.told, "counts": said.counts, "answers": said.answers}
    digest.update(_digest_of(texts).encode())
    return Came(digest.hexdigest(), figures_of(scene, said))


def figures_of(scene: Scene, said) -> dict:
    """Return the figures of what was said of a scene; `said` is a Said."""
    error, mode, _ = errors_of(scene, said)
    three = (mode == THREE_POINT) & np.isfinite(error[:, 3:]).all(axis=1)
    sure = three & said.determined & (said.mode == THREE_POINT)
    known = said.mode != "unknown"
    within = np.abs(error) <= BOUND_STDDEVS * said.stddev
    level = np.max([said.jamming, said.loss, said.overload], axis=0, initial=0)
    flag_ns = said.true_ns[said.flag]
    crossed_ns = scene.recording[0].true_ns if scene.crossed_ns is None else scene.crossed_ns
    return {
        "determined": _mean(sure[three]),
        "reactions covered": _mean(within[sure, 3:]),
        "angles covered": _mean(within[known, :3]),
        "tilt RMS [mrad]": 1e3 * _rms(error[known, 0]),
        "reaction RMS [N]": _rms(error[sure, 3:]),
        "wrong flags": int(wrong_flags(scene, said).sum()),
        "flag after [ms]": float(flag_ns[0] - crossed_ns) * 1e-6 if len(flag_ns) else nan,
        "false alarms": int(false_jams(scene, said).sum()),
        "missed alarms": int(untold_jams(scene, said).sum()),
        "warned": _mean(level >= 1),
        "alarmed": _mean(level >= 2),
        "mode right": _mean(said.mode == mode),
        "mode unknown": _mean(~known),
        "wrenches answered": len(said.true_ns),
        "worst diagnostics": LEVELS[max((each for _, each in said.worst), default=0)],
        "told": "; ".join(sorted(said.told)),
        "answers": "; ".join(said.answers),
    }


def _mean(values):
    return float(np.mean(values)) if np.size(values) else nan


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values)))) if np.size(values) else nan


def _digest_of(tree):
    return hashlib.sha256(json.dumps(tree, sort_keys=True, default=str).encode()).hexdigest()


@cache
def _scene(part, folder):
    """Return a part of a recording; what is not shipped is simulated and kept."""
    source = part.source
    path = shipped.ROOT / "bags" / f"{source}.mcap"
    if source in shipped.SIMULATED:
        return shipped.scene(source, folder)
    if not path.exists():
        path = folder / f"{source}.mcap"
    if not path.exists():
        family, _, number = source.rpartition("_")
        drawn = closings if family in closings.FAMILIES else insertions
        truth, why = truth_of(drawn.plan_of(drawn.Case(family, int(number))), folder / "truths")
        if truth is None:
            raise RuntimeError(f"{source}: {why}")
        # Another process may come to write it.
        partial = folder / f"{source}.{os.getpid()}.mcap"
        write_bag(partial, truth)
        partial.replace(path)
    return read_part(source, part, Bag(path))
