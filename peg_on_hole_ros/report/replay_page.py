"""The report of a replay: words, tries, plots, drawing, settings, where it all comes from."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from peg_on_hole_ros.bags.score import Score, flag_lines, score_lines, score_table
from peg_on_hole_ros.bags.truth import BOUND_STDDEVS
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.number_text import bounded, number
from peg_on_hole_ros.records import CONTACTS
from peg_on_hole_ros.report import words
from peg_on_hole_ros.report.accuracy_line import accuracy_line
from peg_on_hole_ros.report.inputs import Inputs
from peg_on_hole_ros.report.markup import (
    banner,
    html,
    jump,
    points,
    section,
    sentence,
    shown,
    table,
)
from peg_on_hole_ros.report.model import model, with_drawing
from peg_on_hole_ros.report.page import document
from peg_on_hole_ros.report.panels import (
    Source,
    estimate_panels,
    input_panels,
    with_data,
)
from peg_on_hole_ros.report.provenance import (
    hashes,
    made_at,
    settings,
    stamp_text,
    versions,
)
from peg_on_hole_ros.report.tracks import Tracks, true_columns


class Replay(NamedTuple):
    """
    What a replay has found.

    Attributes
    ----------
    path : Path
        Of the bag, as it was given.
    files : tuple of Path
        That the bag consists of.
    content : dict
        The summary.
    tracks : Tracks
    inputs : Inputs
    score : Score or None
        Where the bag has truth.
    doubts : list of str
        What makes the numbers doubtful.
    configuration : Configuration
    contradicted : sequence of str
        What the data contradict, likeliest first: some of the doubts.

    """

    path: Path
    files: tuple[Path, ...]
    content: dict
    tracks: Tracks
    inputs: Inputs
    score: Score | None
    doubts: list[str]
    configuration: Configuration
    contradicted: Sequence[str] = ()


def replay_page(found: Replay) -> str:
    """Return the report as one HTML page."""
    content, tracks = found.content, found.tracks
    begun = words.tries_at(content["cycles"], tracks.runs)
    before = [
        f"<header>\n<h1>Replay of {html(found.path.name)}</h1>",
        *_verdict(found, begun),
        _meta(content),
        _damage(content["damage"]),
        "</header>",
        _summary(found),
        _tries(content["cycles"], begun),
    ]
    after = [
        _truth(found.score),
        _alarms(content["alarms"], content["alarm_changes"]),
        _counts(content),
        *_settings(found.configuration),
        _provenance(found),
    ]
    title = f"Replay of {shown(found.path.name)}"
    return document(title, before, _model(found), list(filter(None, after)))


def _verdict(found, begun):
    """Return what is wrong, with what to set first, and below it what happened."""
    doubt = words.doubt(found.contradicted, found.doubts)
    happened = sentence(_headline(found, begun))
    if doubt is None:
        return [f'<p class="lead">{happened}</p>']
    return [
        banner("error" if doubt.contradicted else "warn", doubt.headline, doubt.lines),
        f'<p class="verdict">{happened}</p>',
    ]


def _headline(found, begun):
    return words.headline(found.content["cycles"], begun, found.configuration.monitor.modes)


def _meta(content):
    return (
        f'<p class="note">Recorded from {html(stamp_text(content["start_time"]))}, '
        f"{content['duration']:.3f} s, {content['outputs']} estimates.</p>"
    )


def _damage(damage):
    if not damage:
        return ""
    return f'<p class="damage">{html(damage)}: what lies before has been used.</p>'


def _summary(found):
    content, limits = found.content, found.configuration.monitor.max_normal
    peaks = {} if content["reactions_void"] else found.tracks.peaks
    cards = [
        ("Doubts", points(words.doubt_lines(_doubts(found), found.tracks.undetermined))),
        ("Alarms", points(words.alarm_lines(content["alarms"], content["alarm_changes"]))),
        ("Loads", points(_load_lines(content, peaks, limits)) + _loads(peaks, limits)),
        ("Dropped", points([words.dropped_line(content["messages"])])),
    ]
    body = "\n".join(f"<div><h3>{title}</h3>\n{text}</div>" for title, text in cards)
    return section("summary", "In short", f'<div class="summary">\n{body}\n</div>')


def _doubts(found):
    """Return all doubts, what stands at the top first."""
    return list(dict.fromkeys([*found.contradicted, *found.doubts]))


def _load_lines(content, peaks, limits):
    accuracy = accuracy_line(content["accuracies"])
    bounded = [words.Remark(f"{accuracy[:1].upper()}{accuracy[1:]}.")] if accuracy else []
    return [words.load_line(peaks, limits, content["reactions_void"]), *bounded]


def _loads(peaks, limits):
    rows = [
        (
            name,
            bounded(peaks[name].normal, BOUND_STDDEVS * peaks[name].stddev, "N", limit),
            f"{peaks[name].normal / limit:.0%}",
            jump(f"{peaks[name].t_ns * 1e-9:.3f} s", peaks[name].t_ns * 1e-9),
        )
        for name, limit in zip(CONTACTS, limits)
        if name in peaks
    ]
    head = "", "greatest", "of limit", "at"
    return table(head, rows, raw=(3,)) if rows else ""


def _tries(cycles, begun):
    if not cycles:
        return ""
    rows = []
    for i, (cycle, t) in enumerate(zip(cycles, begun)):
        end, since = t + cycle["duration"], cycle["transition_time"]
        peak = cycle["peak_normal"]
        rows.append(
            (
                str(i + 1),
                jump(f"{t:.3f} s", t, end),
                cycle["outcome"],
                f"{cycle['duration']:.3f}",
                "-" if since is None else jump(f"{t + since:.3f} s", t + since),
                "-" if None in peak.values() else number(max(peak.values())),
                str(cycle["alarm_count"]),
            )
        )
    head = "try", "from", "outcome", "lasts [s]", "transition at", "peak [N]", "alarms"
    return section("tries", "Tries", table(head, rows, raw=(1, 4)))


def _model(found):
    tracks, configuration = found.tracks, found.configuration
    estimate = tracks.columns()
    tables = {"estimate": estimate, **found.inputs.tables()}
    modes = {"estimate": tracks.modes}
    truth = None
    if found.score:
        truth = Source("truth", style="truth")
        tables["truth"] = true_columns(found.score.truth, tracks.runs, estimate)
        modes = {"estimate": tracks.modes, "truth": found.score.truth.mode_changes(tracks.runs)}
    panels = [
        *estimate_panels([Source("estimate")], configuration, truth),
        *input_panels(configuration),
    ]
    drawn = model(
        with_data(panels, tables, len(modes)),
        tables,
        tracks.passed_ns,
        modes,
        found.content["alarms"],
        configuration.filter.max_gap,
    )
    return with_drawing(drawn, tracks.moments(), configuration.scene)


def _truth(score):
    if not score:
        return ""
    head, *rows = score_table(score)
    lines = [f"<p>{html(text)}</p>" for text in (*score_lines(score), *flag_lines(score))]
    return section("truth", "Against the truth", table(head, rows), *lines)


def _alarms(alarms, changes):
    if not alarms:
        return ""
    rows = [
        (jump(f"{alarm['time']:.3f} s", alarm["time"]), alarm["name"], alarm["level"])
        + (alarm["message"],)
        for alarm in alarms
    ]
    left = changes - len(alarms)
    more = f"<p>{left} more changes of alarms are not listed.</p>" if left > 0 else ""
    head = "time", "alarm", "level", "what to do"
    return section("alarms", "Alarms", table(head, rows, raw=(0,)), more, open_=len(rows) <= 20)


def _counts(content):
    messages = content["messages"]
    rows = [("messages read", str(messages["read"])), ("used", str(messages["used"]))]
    rows += [(f"dropped: {name}", str(count)) for name, count in messages["dropped"].items()]
    rows += [(name, str(count)) for name, count in messages["events"].items()]
    rows += [("estimates", str(content["outputs"]))]
    rows += [(f"contact mode {k}", f"{v:.1%}") for k, v in content["contact_mode"].items()]
    rows += [("times real time", f"{content['realtime_factor']:.1f}")]
    return section("counts", "Messages", table(("", ""), rows), open_=False)


def _settings(configuration):
    changed, kept = settings(configuration)
    head = "parameter", "value", "default", "unit"
    text = table(head, changed) if changed else "<p>All settings are the defaults.</p>"
    return (
        section("changed", "Settings that differ from the defaults", text),
        section(
            "kept", "All other settings", table((head[0], head[1], "unit"), kept), open_=False
        ),
    )


def _provenance(found):
    rows = [("made", made_at()), ("bag", str(found.path))]
    rows += [(f"SHA-256 of {name}", digest) for name, digest in hashes(found.files)]
    return section("origin", "Where this comes from", table(("", ""), [*rows, *versions()]))
