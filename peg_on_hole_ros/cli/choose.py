"""`peg-on-hole choose`: the cheapest method and the lowest rate that are enough for a cell."""

from argparse import Namespace
from collections.abc import Callable, Sequence
from math import isnan
from pathlib import Path
from time import thread_time
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA, configuration_metadata
from peg_on_hole_ros.cli.bag_and_configuration import open_recording
from peg_on_hole_ros.cli.output_paths import check_output_paths, out_folder, write_text
from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.simulation_file import SIMULATION_PART, read_plan
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.config.parameters_file import load_yaml
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.replay.run import replay_bag
from peg_on_hole_ros.replay.summary import Summary
from peg_on_hole_ros.safe_text import cut, printable
from peg_on_hole_ros.sim.truth import Truth, integrate
from peg_on_hole_ros.study.choice import (
    FEW,
    THINNED,
    Limit,
    Measured,
    Seeds,
    Tolerances,
    Tried,
    cheapest,
    limits,
    nearest,
    tried,
)
from peg_on_hole_ros.study.motions import (
    LONGEST,
    PIECE,
    Recorded,
    on_three,
    planned_motion,
    recorded_motion,
    simulated_cell,
)
from peg_on_hole_ros.study.runs import run as run_once

FIRST_CHOICE_SEED = 900
_LIMITED = {"reactions": "the reactions", "tilt_rate": "the tilt's rate"}
# What a limit gives is told from so many seeds.
LIMIT_SEEDS = 6
# Those that may pay; the others of `filter.method` lose to one of them in every scene.
COMPARED = ("mixture", "one_level", "quasi_static", "balance", "two_dof", "unscented")
# What is not told for longer than a piece of the motion that is followed, and than so many periods
# of the wrench, ends a stretch.
_GAP = 5.0
_NO_STRETCH = (
    "reactions are never determined on three contacts in the recording, so there is no motion to "
    "follow; peg-on-hole replay --report shows why"
)
# By what a peg in its hole is another one.
_OF_PEG_AND_HOLE = tuple(
    f"scene.{name}" for name in ("hole_diameter", "peg_diameter", "peg_mass", "mass_center_height")
)
# As a share: a change below it is none.
_SOME = 0.1


class CellMotion(NamedTuple):
    """A simulated motion of a cell, what it is in words, and what makes it doubtful."""

    truth: Truth
    words: str
    doubts: Sequence[str] = ()


class Followed(NamedTuple):
    """
    The simulated motion of a recording.

    Attributes
    ----------
    truth : Truth
    begin, end : float
        From when to when the recording is followed [s].
    doubts : list of str
        What else the recording states of the peg, and what makes it doubtful, as a replay tells
        it.

    """

    truth: Truth
    begin: float
    end: float
    doubts: list[str]


def run(arguments: Namespace) -> int:
    """Simulate the cell's motion, run every method at every rate, choose, print and write."""
    within = _tolerances(arguments)
    if arguments.out is not None:
        needed()
    motion = _motion(arguments)
    folder = None if arguments.out is None else out_folder(arguments.out, arguments.config)
    seeds = Seeds(FIRST_CHOICE_SEED, arguments.seeds)
    with ProgressBar("choose") as progress:
        found = all_tried(Measured(motion.truth, seeds), within, progress)
        chosen = cheapest(found, within)
        known = list(
            limits(
                motion.truth, chosen or nearest(found, within),
                Seeds(FIRST_CHOICE_SEED, min(arguments.seeds, LIMIT_SEEDS)), thread_time,
            )
        )  # fmt: skip
    print(in_words(motion, found, chosen, within, known))
    if folder is not None:
        from peg_on_hole_ros.plots.choice import figure

        written = save(figure(found, chosen, within), folder / "choose")
        if chosen is not None:
            setting = folder / "choose.yaml"
            write_text(setting, _setting(chosen))
            written = [setting, *written]
        print(", ".join(map(str, written)))
    return 0


def _tolerances(arguments):
    if not 2 <= arguments.seeds <= 100:
        raise PegOnHoleError(f"--seeds = {arguments.seeds} is not within 2 to 100")
    if not 10 <= arguments.rate <= 10_000:
        raise PegOnHoleError(f"--rate = {arguments.rate} Hz is not within 10 to 10000 Hz")
    return Tolerances(
        _share("--within", arguments.within),
        _share("--rate-within", arguments.rate_within),
        _flag(arguments.flag_within),
    )


def _share(name, text):
    try:
        value = float(text.rstrip("%")) / 100.0
    except ValueError:
        value = float("nan")
    if not 1e-4 <= value <= 1.0:
        raise PegOnHoleError(f"{name} {text} is not a share within 0.01% to 100%, such as 3%")
    return value


def _flag(milliseconds):
    if not 0.1 <= milliseconds <= 1000.0:
        raise PegOnHoleError(f"--flag-within = {milliseconds:g} ms is not within 0.1 to 1000 ms")
    return 1e-3 * milliseconds


def _motion(arguments) -> CellMotion:
    if arguments.bag is not None:
        return _of_recording(arguments)
    check_output_paths([arguments.config], texts=[])
    if SIMULATION_PART in load_yaml(Path(arguments.config)):
        truth = _first_contact(integrate(read_plan(arguments.config)))
        return CellMotion(
            truth, f"the motion of the section {SIMULATION_PART}: of {arguments.config}"
        )
    configuration, _ = load(arguments.config)
    cell = simulated_cell(configuration)
    return CellMotion(planned_motion(cell, arguments.rate), "the planned closing")


def _first_contact(truth):
    """Refuse a motion that does not begin on three contacts: it is what is compared."""
    if on_three(truth) < 100:
        raise PegOnHoleError(
            "the simulated motion does not begin on three contacts, where methods differ; begin "
            "it there, as config/closing_with_slip.yaml does, or give its recording with --bag"
        )
    return truth


class _Rows:
    """A sink that keeps what a motion is made of."""

    def __init__(self) -> None:
        self.parts: list[tuple[np.ndarray, ...]] = []

    def take(self, columns: OutputColumns) -> None:
        """Keep stamps, states, contact forces, and where three contacts are determined."""
        on_rim = np.array([mode == "three_point" for mode in columns.modes], bool)
        force = columns.force.sum(axis=1)
        self.parts.append((columns.t_ns, columns["state"], force, on_rim & columns.determined))


def _of_recording(arguments) -> CellMotion:
    opened = open_recording(arguments.bag, arguments.config)
    with ProgressBar(f"replaying {arguments.bag}") as progress:
        found = motion_of(opened.bag, opened.configuration, progress)
    words = f"the motion of {arguments.bag} from {found.begin:.2f} to {found.end:.2f} s"
    return CellMotion(found.truth, words, found.doubts)


def motion_of(
    bag: Bag, configuration: Configuration, progress: Callable[[float], None] = lambda share: None
) -> Followed:
    """
    Return the simulated motion of a recording.

    Raises
    ------
    PegOnHoleError
        There is none on three contacts that is long enough, or simulation does not keep them.

    """
    rows, summary = _Rows(), Summary()
    replayed = replay_bag(bag, configuration, 0.0, [rows, summary], progress)
    doubts = _stated_otherwise(bag, configuration)
    doubts += replayed.doubts(summary.content(), configuration)
    t_ns, state, force, good = (np.concatenate(part) for part in zip(*rows.parts))
    t = (t_ns - t_ns[0]) * 1e-9
    period = float(np.median(np.diff(t)))
    at = np.flatnonzero(good & np.isfinite(force).all(axis=1))
    if not len(at):
        raise PegOnHoleError("; ".join([_NO_STRETCH, *doubts[:1]]))
    at = at[_longest(t[at], max(PIECE, _GAP * period))]
    at = at[t[at] >= t[at[-1]] - LONGEST]
    turn = state[at, 1]
    c, s = np.cos(turn), np.sin(turn)
    x, y, z = force[at].T
    recorded = Recorded(
        t[at],
        np.column_stack([state[at, 0], np.unwrap(state[at, 1:3], axis=0)]),
        state[at, 3:6],
        -np.column_stack([c * x + s * y, c * y - s * x, z]),
    )
    rate = max(round(1.0 / period), 10)
    truth = recorded_motion(simulated_cell(configuration), recorded, rate)
    return Followed(truth, float(t[at[0]]), float(t[at[-1]]), doubts)


def _longest(t, gap):
    """Return the slice of the longest stretch of times that are no more than a gap apart."""
    edges = [0, *(np.flatnonzero(np.diff(t) > gap) + 1).tolist(), len(t)]
    return max((slice(a, b) for a, b in zip(edges, edges[1:])), key=lambda k: t[k][-1] - t[k][0])


def _stated_otherwise(bag, configuration):
    """Return a line where the recording carries another peg or hole than is stated."""
    given = configuration_metadata(configuration)
    carried = bag.metadata.get(CONFIGURATION_METADATA, {})
    others = [
        f"{name} = {cut(printable(carried[name]))} for {given[name]}"
        for name in _OF_PEG_AND_HOLE
        if name in carried and carried[name] != given[name]
    ]
    return [f"the recording states another peg or hole: {', '.join(others)}"] if others else []


def all_tried(
    motion: Measured, within: Tolerances, progress: Callable[[float], None] = lambda share: None
) -> list[Tried]:
    """Return what becomes of every method at every rate."""
    found = []
    pairs = [(method, every) for every in THINNED for method in COMPARED]
    # A warm run: what is compiled for the first time is no cost of a method.
    run_once(motion.truth.plan.configuration, motion.thinned(0, THINNED[-1]), thread_time)
    for k, (method, every) in enumerate(pairs):
        found.append(tried(motion, method, every, thread_time, within))
        progress((k + 1) / (len(pairs) + 1))
    return found


def in_words(
    motion: CellMotion,
    found: Sequence[Tried],
    chosen: Tried | None,
    within: Tolerances,
    known: Sequence[Limit],
) -> str:
    """Return what was found as text."""
    truth = motion.truth
    lines = [
        f"{motion.words}: {truth.t_ns[-1] * 1e-9:.2f} s, on three contacts "
        f"{1e-9 * truth.t_ns[on_three(truth) - 1]:.2f} s; {_cell(truth.plan.configuration)}",
        *motion.doubts,
        "",
        table(
            ["method", "wrench", "reactions off", "tilt's rate off", "within 95 %", "determined",
             "flag off", "step", "whole path", ""],
            [_row(one, within, max(each.draws for each in found)) for one in found],
        ),
        "",
    ]  # fmt: skip
    asked = (
        f"reactions within {100 * within.reactions:g} %, the tilt's rate within "
        f"{100 * within.tilt_rate:g} %, the flag within {1e3 * within.flag:g} ms"
    )
    if isnan(found[0].flag):
        asked += " (not tested: this motion ends before the transition)"
    best = chosen or nearest(found, within)
    if chosen is None:
        lines.append(f"no combination is enough for {asked}; the nearest is {_told(best)}")
    else:
        first = found[0]
        lines.append(f"enough for {asked}: {_told(chosen)}")
        if first is not chosen and first.whole > 0:
            lines.append(
                f"it takes {chosen.whole / first.whole:.2f} of the time of {_name(first)}"
            )
        lines.append(f"set filter.method: {chosen.method}")
    return "\n".join([*lines, *_limit_lines(best, known, within)])


def _cell(configuration: Configuration) -> str:
    scene, wrench, joints = configuration.scene, configuration.wrench, configuration.joints
    return (
        f"hole {1e3 * scene.hole_diameter:g} mm, clearance "
        f"{1e3 * (scene.hole_diameter - scene.peg_diameter):.3g} mm, friction {scene.friction:g} "
        f"± {scene.friction_stddev:g}; noise {wrench.force_stddev:.3g} N, "
        f"{wrench.torque_stddev:.3g} N m, {1e3 * joints.position_stddev:.3g} mrad; sensor "
        f"{1e3 * wrench.sensor_xyz[2]:.3g} mm above the peg's end"
    )


def _row(one, within, draws):
    if one.enough(within):
        remark = "enough"
    elif one.draws == FEW < draws:
        remark = f"far off after {FEW} draws"
    elif one.lost:
        remark = "lost"
    elif not one.holds:
        remark = "bounds too narrow" if one.determined >= 0.5 else "rarely determined"
    else:
        remark = ""
    flag = "" if isnan(one.flag) else f"{1e3 * one.flag:.0f} ms"
    return [
        one.method, f"{one.rate:g} Hz", f"{100 * one.reactions:.3g} %",
        f"{100 * one.tilt_rate:.3g} %", f"{100 * one.covered:.0f} %",
        f"{100 * one.determined:.0f} %", flag.replace("inf ms", "not flagged"),
        f"{one.step:.3g} us", f"{one.whole:.0f} us a ms", remark,
    ]  # fmt: skip


def _name(one):
    return f"{one.method} at {one.rate:g} Hz"


def _told(one):
    flag = "" if isnan(one.flag) else f", flag within {1e3 * one.flag:.0f} ms"
    return (
        f"{_name(one)}: reactions {100 * one.reactions:.2g} % off, the tilt's rate "
        f"{100 * one.tilt_rate:.2g} %{flag}; {100 * one.covered:.0f} % of determined reactions "
        f"within their 95 % bounds; {one.whole:.0f} us for a millisecond of motion"
    )


def _limit_lines(best, known, within):
    """Return what limits the error that is farthest from what is asked for, or nearest to it."""
    shares = {
        "reactions": best.reactions / within.reactions,
        "tilt_rate": best.tilt_rate / within.tilt_rate,
    }
    name = max(shares, key=lambda each: shares[each])
    now, lines = getattr(best, name), []
    for limit in known:
        then = getattr(limit, name)
        lines.append(
            f"{limit.what} would reduce it from {100 * now:.2g} % to {100 * then:.2g} %"
            if 1.0 - then / now > _SOME
            else f"{limit.what} changes nothing"
        )
    return [f"what limits the error of {_LIMITED[name]}: {'; '.join(lines)}"] if lines else []


def _setting(chosen):
    return (
        f"# By peg-on-hole choose: enough with a wrench at {chosen.rate:g} Hz.\n"
        f"peg_on_hole:\n  ros__parameters:\n    filter:\n      method: {chosen.method}\n"
    )
