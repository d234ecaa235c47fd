"""The last step of `peg-on-hole setup`: an insertion that the settings have to explain."""

from peg_on_hole_ros.bags.score import Score, flag_lines, score_table
from peg_on_hole_ros.cli.bag_and_configuration import truth_in
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.setting_up.bags import Opened, SetupBags
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.identification.calibration import calibrate
from peg_on_hole_ros.identification.hole_by_end import hole_by_end
from peg_on_hole_ros.replay.advice import MISFIT, MISFIT_COUNT
from peg_on_hole_ros.replay.run import Replayed, check_bag, replay_bag
from peg_on_hole_ros.replay.summary import Summary
from peg_on_hole_ros.setup_steps.hole_evidence import take_hole
from peg_on_hole_ros.setup_steps.knowledge import DEFAULT, MEASURED, UNKNOWN, Cell, Known

_FOUND = {"friction": "scene.friction", "delay": "joints.delay"}
# What an insertion rests on: without it, what comes out means nothing.
_NEEDED = ("joints.peg_xyz", "joints.peg_rpy", "wrench.sensor_xyz", "scene.peg_height")
_PLACE = ("joints.hole_xyz", "joints.hole_rpy")


def check_by_run(cell: Cell, bags: SetupBags, opened: Opened) -> list[str]:
    """
    Take hole, friction and delay from an insertion, and replay it; return what there is to say.

    What the replay names as wrong contradicts the settings.
    """
    path = str(opened.bag.path)
    missing = [name for name in _NEEDED if cell.how(name).kind == UNKNOWN]
    if missing:
        return [f"{opened.name} is not used: {', '.join(missing)} is not known"]
    if cell.value("joints.source") == "robot":
        found = hole_by_end(opened.orientations(), opened.configuration.scene)
        take_hole(cell, found, opened.configuration, opened.name)
        missing = [name for name in _PLACE if cell.how(name).kind == UNKNOWN]
        if missing:
            return [f"{opened.name} is not replayed: {', '.join(missing)} is not known"]
        opened = bags.open(path)
    if cell.contradictions:
        # What comes of a wrong setting would be named beside it.
        return [f"{opened.name} is not replayed: correct the contradicted settings first"]
    _take_calibration(cell, opened)
    opened = bags.open(path)
    replayed, content, score = _replayed(opened)
    for line in replayed.causes:
        cell.contradict(_named(line), f"{line} (replay of {opened.name})")
    if replayed.events.get(MISFIT_COUNT) and not replayed.causes:
        cell.contradict("wrench", f"{MISFIT} (replay of {opened.name})")
    shares = ", ".join(f"{mode} {share:.1%}" for mode, share in content["contact_mode"].items())
    transition = content["transition_time"]
    lines = [
        f"{opened.name}: {replayed.used} of {replayed.read} messages used",
        f"contact mode: {shares}",
        f"transition: {'none' if transition is None else f'after {transition:.3f} s'}",
    ]
    if not replayed.used:
        cell.contradict("joints.names", f"no message of {opened.name} can be used")
    if score:
        head, *rows = score_table(score)
        lines += [table(head, rows, 2), *flag_lines(score)]
    return lines


def _take_calibration(cell: Cell, opened: Opened) -> None:
    """Take friction and delay, where the motion tells them."""
    if opened.configuration.wrench.gravity != "measured":
        cell.tell(
            "joints.delay",
            Known(UNKNOWN, "not estimated where the controller subtracts the weight"),
        )
        return
    try:
        with ProgressBar("calibrating") as progress:
            found = calibrate(opened.record(), opened.configuration, progress)
    except BagError as error:
        if not cell.is_given("joints.delay"):
            cell.tell(
                "joints.delay", Known(UNKNOWN, f"{opened.name} does not determine it: {error}")
            )
        return
    for one in found.estimates:
        name = _FOUND.get(one.name)
        if name is None:
            continue
        if not one.seen:
            if not cell.is_given(name):
                cell.tell(name, _not_seen(name, opened.name))
            continue
        half = (one.high - one.low) / 2.0
        how = f"+- {half:.2g}{f' {one.unit}' if one.unit else ''}, by sliding in {opened.name}"
        value = float(f"{one.value:.4g}")
        cell.put(name, value, Known(MEASURED, how))


def _not_seen(name: str, source: str) -> Known:
    """Return what is known of a parameter that the motion does not tell."""
    how = f"the motion in {source} does not determine it"
    if name == "scene.friction":
        return Known(DEFAULT, f"{how}; it is estimated from contact on")
    return Known(
        UNKNOWN,
        f"{how}; 0 is right if one clock stamps robot and sensor, else record quick changes of "
        "speed while the peg slides",
    )


def _replayed(opened: Opened) -> tuple[Replayed, dict, Score | None]:
    bag, configuration = opened.bag, opened.configuration
    check_bag(bag, configuration)
    truth, summary = truth_in(bag), Summary()
    score = Score(truth) if truth else None
    sinks = [sink for sink in (summary, score) if sink is not None]
    with ProgressBar("replaying") as progress:
        replayed = replay_bag(bag, configuration, 0.0, sinks, progress)
    return replayed, summary.content(), score


def _named(line: str) -> str:
    """Return the parameter, or the part of the cell, that a line of a replay begins with."""
    return line.partition(":")[0]
