"""What the stream of node and replay says of a recording, and what `/diagnostics` would."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.faults.injector import Recording
from benchmarks.faults.scenes import Scene
from peg_on_hole_ros.messages.decode import Malformed, checked_joints, checked_wrench
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.ros.diagnostics import Diagnostics

# Between two reports of the diagnostics [ns].
REPORT_NS = 100_000_000
LEVELS = ("OK", "WARN", "ERROR")


class Said(NamedTuple):
    """
    What was published, a row a wrench that gave an output.

    Attributes
    ----------
    true_ns : ndarray of int, shape (n,)
        When the wrench was measured [ns].
    values, stddev : ndarray, shape (n, 6)
        Angles [rad] and reactions [N].
    mode : ndarray of str, shape (n,)
    flag, determined : ndarray of bool, shape (n,)
    jamming, loss, overload : ndarray of int, shape (n,)
        Levels.
    risk : ndarray, shape (n,)
        Of jamming; NaN where there is none.
    level, doubt : ndarray of int, shape (n,)
        Worst of the diagnostics of filter and input, and that of the filter, by the report before.
    answers : list of str
        Of calls.
    worst : list of (float, int)
        When the diagnostics came [s], and their level.
    told : dict of str to float
        Lines of the diagnostics of filter and input, and when each came first [s].
    counts : dict of str to int
    sent : dict of str to int
        Messages of `wrench` and `joints`.

    """

    true_ns: np.ndarray
    values: np.ndarray
    stddev: np.ndarray
    mode: np.ndarray
    flag: np.ndarray
    determined: np.ndarray
    jamming: np.ndarray
    loss: np.ndarray
    overload: np.ndarray
    risk: np.ndarray
    level: np.ndarray
    doubt: np.ndarray
    answers: list
    worst: list
    told: dict
    counts: dict
    sent: dict


def play(
    scene: Scene, recording: Recording, take: Callable[[OutputView], object] = lambda outputs: None
) -> Said:
    """
    Return what is said of a recording under the configuration of a scene.

    Parameters
    ----------
    scene : Scene
    recording : list of Sent
    take : callable
        Gets all that is published with each wrench.

    """
    stream = message_stream(scene.configuration, markers_rate=0.0)
    stream.take_frame(scene.frame)
    rows, answers, worst, told = [], [], [], {}
    pipeline, diagnostics = stream.pipeline, Diagnostics()
    names = scene.configuration.joints.names
    sent = {"wrench": 0, "joints": 0}
    begun, level, doubt = recording[0].true_ns, 0, 0
    due, before = begun + REPORT_NS, begun
    for sample, true_ns in recording:
        if isinstance(sample, str):
            answer = stream.on_event(sample)
            answers.append(f"{sample}: {'done' if answer.success else answer.message}")
            continue
        source = "wrench" if isinstance(sample, WrenchSample) else "joints"
        sent[source] += 1
        outputs = None
        if source == "joints":
            stream.take_joints(checked_joints(sample, names))
        elif isinstance(checked_wrench(sample), Malformed):
            stream.take_wrench(checked_wrench(sample))
        else:
            # As records: messages are made of them, one for one.
            outputs = pipeline.on_wrench(sample)
        if outputs is not None:
            take(outputs)
            rows.append((true_ns, outputs, level, doubt))
        diagnostics.received(source, 0, outputs is not None)
        if true_ns >= due:
            report, _ = diagnostics.report(
                true_ns, true_ns - before, stream.counts, pipeline.health, causes=stream.causes
            )
            due, before = true_ns + REPORT_NS, true_ns
            status = {each["name"].rpartition(" ")[2]: each for each in report["status"]}
            doubt = status["filter"]["level"]
            level = max(doubt, status["input"]["level"])
            worst.append(((true_ns - begun) * 1e-9, level))
            for name in ("filter", "input"):
                if status[name]["level"]:
                    for line in status[name]["message"].split("; "):
                        told.setdefault(line, (true_ns - begun) * 1e-9)
    # What still waits has its fate then.
    stream.on_event("reset")
    return _said(rows, answers, worst, told, dict(stream.counts), sent)


def _said(rows, answers, worst, told, counts, sent):
    outputs = [row[1] for row in rows]
    n = len(rows)
    levels = {
        name: np.array([a.level for out in outputs for a in out.alarms if a.name == name], int)
        for name in ("jamming", "contact_loss", "overload")
    }
    spread = [np.sqrt(np.maximum(np.diagonal(out.state_covariance)[:3], 0.0)) for out in outputs]
    return Said(
        true_ns=np.array([row[0] for row in rows], np.int64),
        values=np.array([[*out.state[:3], *out.normal] for out in outputs]).reshape(n, 6),
        stddev=np.array([[*s, *o.normal_stddev] for s, o in zip(spread, outputs)]).reshape(n, 6),
        mode=np.array([out.contact_mode for out in outputs], "U16"),
        flag=np.array([out.transition for out in outputs], bool),
        determined=np.array(
            [out.monitor.get("reactions_determined", 0.0) == 1.0 for out in outputs], bool
        ),
        jamming=levels["jamming"],
        loss=levels["contact_loss"],
        overload=levels["overload"],
        risk=np.array([out.monitor.get("jamming_risk", np.nan) for out in outputs]),
        level=np.array([row[2] for row in rows], int),
        doubt=np.array([row[3] for row in rows], int),
        answers=answers,
        worst=worst,
        told=told,
        counts=counts,
        sent=sent,
    )
