"""`peg-on-hole replay`: the estimator over a bag, as the node would have run."""

import argparse
import json
from collections import Counter
from contextlib import nullcontext
from os.path import lexists
from pathlib import Path
from typing import Any

from peg_on_hole_ros.bags.reader import Bag, absolute
from peg_on_hole_ros.bags.score import (
    Score,
    flag_lines,
    score_lines,
    score_table,
    undetermined_content,
)
from peg_on_hole_ros.bags.storage.bag_files import bag_files
from peg_on_hole_ros.bags.storage.rosbag2_folder import is_folder_name, rosbag2_folder
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.bag_and_configuration import (
    Reading,
    open_recording,
    print_line,
    truth_in,
)
from peg_on_hole_ros.cli.output_paths import write_text
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.table import finite, table, to_json
from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.diagnosis.guarded_looks import Failures, GuardedLook
from peg_on_hole_ros.diagnosis.suspected.unobservable import words
from peg_on_hole_ros.errors import BagDamaged, PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import LATCHED, PREFIX
from peg_on_hole_ros.messages.transforms import STATIC_TRANSFORM_TOPIC
from peg_on_hole_ros.messages.tries import json_line
from peg_on_hole_ros.monitor.pose_only import MODES_OFF as UNJUDGED
from peg_on_hole_ros.number_text import number
from peg_on_hole_ros.replay.run import check_bag, replay_bag
from peg_on_hole_ros.replay.summary import VERSION, Summary, without_reactions
from peg_on_hole_ros.replay.topic_findings import two_robots
from peg_on_hole_ros.report.accuracy_line import accuracy_line
from peg_on_hole_ros.robot.frame_tree import frame_tree
from peg_on_hole_ros.safe_text import printable

ALARM_HEAD = ("time [s]", "alarm", "level", "message")
CYCLE_HEAD = ("try from [s]", "outcome", "lasts [s]", "transition [s]", "peak [N]", "alarms")


def run(arguments: argparse.Namespace) -> int:
    """Replay, write what was asked for, print a table; exit code 4 for a damaged bag."""
    if many(arguments):
        from peg_on_hole_ros.cli.many_bags import run as many_bags

        return many_bags.run(arguments)
    if arguments.report is True:
        raise PegOnHoleError("--report needs a name for the page: --report REPORT.html")
    if arguments.estimates:
        raise PegOnHoleError("--estimates is for many bags: of one, --out OUT.mcap writes them")
    if arguments.smooth and not arguments.out:
        raise PegOnHoleError("--smooth adds topics to an output: name one with --out OUT.mcap")
    if arguments.out and is_folder_name(arguments.out):
        with rosbag2_folder(Path(arguments.out)) as file:
            return _one_bag(arguments, str(file))
    return _one_bag(arguments, arguments.out)


def _one_bag(arguments, out):
    texts = arguments.report, arguments.summary, arguments.cycles
    bag, configuration, node, _ = open_recording(
        arguments.bags[0], arguments.config, [out], texts, Reading.of(arguments)
    )
    if out:
        _tell_frames(configuration)
    result, score, doubts, no_page = replay(
        bag, configuration, node, out, arguments.report, arguments.smooth
    )
    if arguments.summary:
        write_text(arguments.summary, to_json(result) + "\n")
    if arguments.cycles:
        lines = [json_line(record) + "\n" for record in result["cycles"]]
        write_text(arguments.cycles, "".join(lines))
    remarks = words(result["untold"], configuration), accuracy_line(result["accuracies"])
    print(_summary_text(result, score, doubts, list(filter(None, remarks))))
    if not configuration.monitor.modes:
        print(UNJUDGED)
    if no_page is not None:
        raise no_page
    if bag.damage:
        raise BagDamaged(bag.damage)
    return 0


def _tell_frames(configuration):
    """Say why an output has not the hole's place, though it is stated."""
    line = frame_tree(configuration).hole_line
    if line:
        print_line(line)


def many(arguments: argparse.Namespace) -> bool:
    """Return whether the arguments mean many bags, were it one."""
    more = len(arguments.bags) > 1 or arguments.jobs is not None or arguments.dask is not None
    # A pattern that the shell was kept from.
    pattern = any(c in arguments.bags[0] for c in "*?[") and not lexists(arguments.bags[0])
    return more or pattern


def replay(
    bag: Bag,
    configuration: Configuration,
    node: NodeOptions,
    out: str | Path | None = None,
    report_path: str | Path | None = None,
    smooth: bool = False,
) -> tuple[dict, Score | None, list[str], Exception | None]:
    """
    Replay a bag.

    Parameters
    ----------
    bag : Bag
    configuration : Configuration
    node : NodeOptions
        For the rate of the markers.
    out, report_path : path, optional
        MCAP and HTML to write.
    smooth : bool
        Whether to add the smoothed state to `out`.

    Returns
    -------
    content : dict
        The JSON of the summary.
    score : Score or None
        The comparison with the truth.
    doubts : list of str
        What makes the numbers doubtful.
    no_page : Exception or None
        Why there is no report, though one was asked for; all else is done and written.

    """
    needed = check_bag(bag, configuration)
    page = _Page(configuration) if report_path else None
    truth = truth_in(bag)
    summary = Summary()
    score, cycles = Score(truth) if truth else None, _ToldTries()
    sinks: list[Any] = [sink for sink in (summary, score, page, cycles) if sink is not None]
    latched = [*(PREFIX + suffix for suffix in LATCHED), STATIC_TRANSFORM_TOPIC]
    # No stack of contexts: a signal that comes while it is built would leave a half file.
    with (
        BagWriter(out, configuration, latched=latched) if out else nullcontext() as opened,
        ProgressBar("replaying") as progress,
    ):
        writer = _Writer(opened) if opened else None
        if writer:
            sinks.append(writer)
        replayed = replay_bag(
            bag,
            configuration,
            # Nothing else shows the markers.
            node.markers_rate if out else 0.0,
            sinks,
            progress,
            writer if smooth else None,
            page,
        )
        for sink in (cycles, writer) if writer else (cycles,):
            sink.add(replayed.t_ns, replayed.ending)
    content = {
        "version": VERSION,
        "bag": printable(bag.path),
        "damage": printable(bag.damage) or None,
        "messages": replayed.messages,
        **summary.content(),
        "cycles": cycles.records,
        "reactions_void": None,
        "failed_looks": [],
    }
    if replayed.reactions_are_void:
        content = without_reactions(content)
    content["realtime_factor"] = finite(content["duration"] / max(replayed.seconds, 1e-9))
    if score:
        content |= {"rmse": score.rmse(), "coverage95": score.coverage95()}
        content["undetermined"] = undetermined_content(score)
    doubts = replayed.doubts(content, configuration)
    topics = (absolute(configuration.topics.wrench), absolute(configuration.topics.joint_states))
    mixed = two_robots({name: info.types for name, info in bag.topics.items()}, *topics)
    doubts = [*bag.remarks(needed), *bag.foreign(), *([mixed] if mixed else []), *doubts]
    failed = _note_failures(content, replayed.failures)
    no_page = None
    if page is not None and report_path:
        told = [*doubts, *failed], replayed.contradicted
        no_page = page.write(report_path, bag, content, score, told, configuration)
        failed += _note_failures(content, page.failures)
    doubts += failed
    return content, score, doubts, no_page


def _cycle_rows(cycles, begun):
    return [
        (
            f"{cycle['start_time'] - begun:.3f}",
            cycle["outcome"],
            f"{cycle['duration']:.3f}",
            "-" if cycle["transition_time"] is None else f"{cycle['transition_time']:.3f}",
            _peak(cycle["peak_normal"]),
            str(cycle["alarm_count"]),
        )
        for cycle in cycles
    ]


def _peak(normal):
    return "-" if None in normal.values() else number(max(normal.values()))


def _largest(normal, void):
    if void:
        return f"reactions: not told, as {void} (above)"
    if None in normal.values():
        return "largest reaction: none, because no sample determines them (reactions_determined)"
    row = "largest reaction [N]", *map(number, normal.values())
    return table(("", *normal), [row])


def _alarm_rows(alarms):
    return [
        (f"{alarm['time']:.3f}", alarm["name"], alarm["level"], alarm["message"])
        for alarm in alarms
    ]


class _ToldTries:
    def __init__(self):
        self.records = []

    def add(self, t_ns, messages):
        told = (fields["data"] for suffix, _, fields in messages if suffix == "cycle")
        self.records += map(json.loads, told)

    def take(self, columns):
        for i, messages in columns.beside:
            self.add(int(columns.t_ns[i]), messages)


def _note_failures(content, failures):
    """Count looks that failed, also after the last message; return a line for each."""
    content["messages"]["events"] |= dict.fromkeys(failures.names, 1)
    content["failed_looks"] += failures.lines
    return failures.lines


class _Page:
    """Gathers what a report shows; what fails in it leaves the replay as it is."""

    def __init__(self, configuration):
        # These take a while to import, and few replays need them.
        from peg_on_hole_ros.report.inputs import Inputs
        from peg_on_hole_ros.report.page import library
        from peg_on_hole_ros.report.tracks import Tracks

        library()  # Missing, it is told before the work.
        tracks = Tracks()
        made = tracks, Inputs(configuration, tracks)
        self.failures = Failures(Counter())
        self._drawn = GuardedLook("report", lambda: made, self.failures)

    def take(self, columns):
        self._drawn(lambda both: [each.take(columns) for each in both], None)

    def read(self, sample):
        self._drawn(lambda both: both[1].read(sample), None)

    def take_inputs(self, arrivals, begin, end):
        self._drawn(lambda both: both[1].take_inputs(arrivals, begin, end), None)

    def write(self, path, bag, content, score, told, configuration):
        """Write the page, `told` are doubts and contradictions; return why not, or None."""
        from peg_on_hole_ros.report.replay_page import Replay, replay_page

        def draw(both):
            tracks, inputs = both
            files = bag_files(bag.path).files
            doubts, contradicted = told
            seen = files, content, tracks, inputs, score, doubts
            found = Replay(bag.path, *seen, configuration, contradicted)
            return replay_page(found)

        text = self._drawn(draw, None)
        if text is None:
            return self.failures.errors["report"]
        try:
            write_text(path, text)
        except PegOnHoleError as error:
            return error
        return None


class _Writer:
    def __init__(self, writer: BagWriter):
        self._writer = writer

    def add(self, t_ns, messages):
        self._writer.write_all(PREFIX, messages, t_ns)

    def take(self, columns):
        self._writer.write_columns(PREFIX, columns)


def _summary_text(result, score, doubts, remarks):
    messages = result["messages"]
    transition = result["transition_time"]
    lines = [
        f"{result['bag']}: {messages['used']} of {messages['read']} messages used, "
        f"{result['outputs']} outputs over {result['duration']:.3f} s, "
        f"{result['realtime_factor']:.1f} times real time",
    ]
    # What is likely to be wrong, before what rests on it; topics and frames may have any name.
    lines += map(printable, doubts)
    lines += [f"  {reason}: {count}" for reason, count in messages["dropped"].items()]
    lines += [f"  {event}: {count}" for event, count in messages["events"].items()]
    shares = ", ".join(f"{mode} {share:.1%}" for mode, share in result["contact_mode"].items())
    lines += [
        f"contact mode: {shares}",
        f"transition: {'none' if transition is None else f'after {transition:.3f} s'}",
        "",
        _largest(result["max_normal"], result["reactions_void"]),
    ]
    lines += remarks
    if result["cycles"]:
        begun, head = result["start_time"], CYCLE_HEAD
        if any(cycle["start_time"] < begun for cycle in result["cycles"]):
            # The clock went back: stamps are all that tells one try from another.
            begun, head = 0.0, ("try from stamp [s]", *CYCLE_HEAD[1:])
        lines += ["", table(head, _cycle_rows(result["cycles"][:10], begun), 1)]
    if result["alarms"]:
        rows = _alarm_rows(result["alarms"][:10])
        lines += ["", table(ALARM_HEAD, rows, 4)]
        if result["alarm_changes"] > len(rows):
            lines.append(f"... {result['alarm_changes'] - len(rows)} more changes of alarms")
    if score:
        head, *rows = score_table(score)
        lines += ["", table(head, rows, 2), *score_lines(score), *flag_lines(score)]
    return "\n".join(lines)
