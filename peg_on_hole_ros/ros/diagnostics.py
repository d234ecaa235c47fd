"""What /diagnostics says once a second: rates, latency, every message's fate, filter health."""

import re
from collections import Counter
from collections.abc import Callable, Sequence

from peg_on_hole_ros.config.node_parts import NODE
from peg_on_hole_ros.messages.beside_estimates import HARDWARE_ID
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.replay.advice import MISFIT, MISFIT_COUNT
from peg_on_hole_ros.ros.log_lines import CountLines

OK, WARN, ERROR = 0, 1, 2

_INPUTS = "wrench", "joints"
# A cause is logged again once it was gone for so many reports.
_GONE_REPORTS = 10
# Reports without a message of an input until that is logged: a driver may start later.
_SILENT_REPORTS = 3
_CHECK = "check topic names, QoS and domain"

# Among the names of counts: what is not used, and what is no event to speak of.
_LOST = re.compile("_(dropped|gated)")
_OWN_ERROR = "_internal_error"
_FIGURE = re.compile(r"-?\d[\d.e+-]*")
_OVERLOAD_COUNT = "_dropped_overload"
# Of the time; what the rest goes to is not the node's own work.
_BUSY = 0.9
# What seems so many times noisier than stated is no noise: values mean something else.
_NO_NOISE = 7.0
_TOO_SLOW = (
    "too slow for this input rate: messages wait, come late or are lost, whatever the clocks "
    "show; a wrench at a lower rate, a lower markers_rate, fewer subscribers, or a faster "
    "machine"
)
_NOT_SERVED = (
    "other programs take the processor from the node: messages were lost though it had little to "
    "do with them; leave it a core of its own (taskset, chrt), stop what else runs, or state a "
    "larger qos_depth"
)
_BUSY_FOR = "{} (the node was busy for {} % of the time)"
_NOT_ALONE = (
    "{} publish on the topics of this node: another of its name, or a bag of its outputs that is "
    "played; end one, or rename one (-r __node:=NAME, -r __ns:=/NAMESPACE)"
)
# Stamps that far from the node's clock are another clock's: a latency is none [s].
_OTHER_CLOCK = 1.0
_USUAL_COUNTS = re.compile(
    "^(reset|tare|.*_used|(joints|wrench)_late|joints_reordered|went_back|wrench_reprocessed"
    "|settings_changed|expected|tare_automatic|look_failed_.*)$"
)
# Of another driver on the topic, as a gripper's, where joint states that can be used come too.
_SHARED_COUNT = "joints_dropped_missing_joint"


class Diagnostics:
    """
    Gathers figures between two reports.

    Unlike everything else that the node publishes these depend on the clock, so a replay has
    none of them.

    Parameters
    ----------
    wrench_publishers : callable, optional
        Returns how many publish on the topic of the wrench.
    output_publishers : callable, optional
        Returns how many publish on the topics of the node, which is one of them.
    counts : dict of str to int, optional
        Every message by fate up to now: what no report is to call new.
    why_silent : callable, optional
        Returns what is odd about the publishers of `wrench` or `joints`; empty: nothing is.
    name : str
        Of the node, with its namespace: what each entry begins with.

    """

    def __init__(
        self,
        wrench_publishers: Callable[[], int] = lambda: 1,
        output_publishers: Callable[[], int] = lambda: 1,
        counts: dict[str, int] | None = None,
        why_silent: Callable[[str], str] = lambda source: "",
        name: str = NODE,
    ) -> None:
        self._name = name
        self._wrench_publishers = wrench_publishers
        self._output_publishers = output_publishers
        self._why_silent = why_silent
        self._silent_reports = dict.fromkeys(_INPUTS, 0)
        # Reports since each was seen last.
        self._causes: dict[str, int] = {}
        self._count_lines = CountLines()
        self._publish = 1
        self._received: Counter[str] = Counter()
        self._busy_ns = 0
        self._longest_ns = 0
        self._outputs = 0
        self._age_ns: int | None = None
        self._counts = dict(counts or {})
        self._shared = 0
        self._noise = 1.0

    def received(self, source: str, busy_ns: int, outputs: bool = False) -> None:
        """Note one message from `wrench` or `joints`, and how long its callback took [ns]."""
        self._received[source] += 1
        self._busy_ns += busy_ns
        self._longest_ns = max(self._longest_ns, busy_ns)
        self._outputs += outputs

    def aged(self, age_ns: int | None) -> None:
        """Note how old the latest estimate's stamp was when it was published; None: no clock."""
        self._age_ns = age_ns

    def report(
        self,
        t_ns: int,
        elapsed_ns: int,
        counts: dict[str, int],
        health: dict[str, float],
        model: str = "",
        causes: Sequence[str] = (),
        idle: str = "",
        failed_looks: Sequence[str] = (),
    ) -> tuple[dict, list[str]]:
        """
        Return the diagnostic_msgs/DiagnosticArray since the last report, and lines to log.

        Parameters
        ----------
        t_ns : int
            Stamp of the report [ns].
        elapsed_ns : int
            Since the last one, > 0 [ns].
        counts : dict of str to int
            Every message by fate since the start.
        health : dict of str to float
            Of the filter.
        model : str
            Which model of the contact is in use, and why.
        causes : sequence of str
            Settings that the data have contradicted, a line each.
        idle : str
            Why there is no estimate by the node's own decision; empty: there may be one.
        failed_looks : sequence of str
            Side looks that failed, with their errors, a line each.

        """
        new = self._new(counts)
        lost = {name: count for name, count in new.items() if _LOST.search(name)}
        load = self._busy_ns / elapsed_ns
        lost_waiting = any(name.endswith(_OVERLOAD_COUNT) for name in new)
        slow = _TOO_SLOW if load > _BUSY else _NOT_SERVED if lost_waiting else ""
        output, joined = self._output()
        silent, unheard = self._silent()
        status = [
            self._input(elapsed_ns, counts, lost, silent),
            self._timing(elapsed_ns, load, slow),
            output,
            _beside(self._filter(health, model, new, causes, idle), failed_looks),
        ]
        for each in status:
            each["name"] = f"{self._name}: {each['name']}"
        loaded = [_BUSY_FOR.format(slow, round(100 * load))] if slow else []
        found = [*joined, *unheard, *self._new_causes([*causes, *loaded, *failed_looks])]
        came = sum(self._received.values())
        counted = self._count_lines.take(new, came, elapsed_ns * 1e-9)
        self._received.clear()
        self._busy_ns = self._longest_ns = self._outputs = 0
        self._age_ns = None
        return {"header": header(t_ns), "status": status}, [*found, *counted]

    def rest(self, counts: dict[str, int]) -> list[str]:
        """Return lines to log of what came after the last report, where no other will follow."""
        return self._count_lines.rest(self._new(counts))

    def _new(self, counts):
        """Return what is new and worth telling since the last call."""
        new = {name: count - self._counts.get(name, 0) for name, count in counts.items()}
        self._counts = dict(counts)
        self._shared = new.pop(_SHARED_COUNT, 0) if new.get("joints_used", 0) > 0 else 0
        # What a late message changed may also have undone something.
        return {name: n for name, n in new.items() if n > 0 and not _USUAL_COUNTS.search(name)}

    def _new_causes(self, causes):
        """Return the causes that no report had lately; their figures may change every second."""
        before, kinds = self._causes, [_FIGURE.sub("", cause) for cause in causes]
        # One that comes and goes is the same one.
        lately = {kind: since + 1 for kind, since in before.items() if since < _GONE_REPORTS}
        self._causes = lately | dict.fromkeys(kinds, 0)
        return [cause for cause, kind in zip(causes, kinds) if kind not in before]

    def _silent(self):
        """Return why each input that is silent is so, and lines where one has long been."""
        silent, lines = {}, []
        for name in _INPUTS:
            self._silent_reports[name] += 1
            if self._received[name]:
                self._silent_reports[name] = 0
            if self._silent_reports[name]:
                silent[name] = self._why_silent(name)
            if self._silent_reports[name] == _SILENT_REPORTS:
                lines.append(f"no messages of {name}: {silent[name] or _CHECK}")
        return silent, lines

    def _input(self, elapsed_ns, counts, lost, silent):
        seconds = elapsed_ns * 1e-9
        came = Counter(self._received)
        for name in came:
            came[name] += lost.get(name + _OVERLOAD_COUNT, 0)
        values = {f"{name}_rate": came[name] / seconds for name in _INPUTS}
        publishers = self._wrench_publishers()
        if silent:
            whys = [why for why in silent.values() if why]
            text = "; ".join([f"no messages of {' and '.join(silent)}: {_CHECK}", *whys])
        elif publishers > 1:
            # Joint states of robot and gripper share a topic as a rule; wrenches of two mix.
            text = f"{publishers} publish on the topic of the wrench, which has to be one sensor's"
        elif lost:
            text = f"not used: {', '.join(f'{count} {name}' for name, count in lost.items())}"
        elif self._shared:
            text = f"all messages used, but {self._shared} joint states of another driver"
        else:
            text = "all messages used"
        bad = silent or lost or publishers > 1
        values["wrench_publishers"] = publishers
        return _status("input", WARN if bad else OK, text, values | counts)

    def _output(self):
        """Return the status of who publishes the outputs, and a line where more came to do so."""
        before, self._publish = self._publish, self._output_publishers()
        alone = self._publish <= 1
        text = "published by this node alone" if alone else _NOT_ALONE.format(self._publish)
        status = _status("output", OK if alone else WARN, text, {"publishers": self._publish})
        return status, [text] if self._publish > max(before, 1) else []

    def _filter(self, health, model, new, causes, idle):
        if any(name.endswith(_OWN_ERROR) for name in new):
            text = "an error of the program: the filter was restarted, its log has the traceback"
            return _status("filter", ERROR, text, health)
        if idle:
            return _status("filter", ERROR, idle, health)
        # What the motion contradicts is wrong, whatever else is told, until another motion fits.
        if MISFIT_COUNT in new or health.get("misfit"):
            return _status("filter", ERROR, "; ".join(causes or [MISFIT]), health)
        found = [health.get(f"{name}_noise", 1.0) for name in ("joints", "wrench")]
        # A cause that is told stays told.
        self._noise = max(self._noise, *found) if causes else 1.0
        if causes:
            level = ERROR if self._noise > _NO_NOISE else WARN
            return _status("filter", level, "; ".join(causes), health)
        running = f"running; {model}" if model else "running"
        return _status("filter", OK, running if self._outputs else "no estimate", health)

    def _timing(self, elapsed_ns, load, slow):
        received = sum(self._received.values())
        values = {
            "load": load,
            "output_rate": self._outputs / (elapsed_ns * 1e-9),
            "callback_max_s": self._longest_ns * 1e-9,
        }
        if received:
            values["callback_mean_s"] = self._busy_ns * 1e-9 / received
        if self._age_ns is not None:
            values["stamp_age_s"] = self._age_ns * 1e-9
        text = f"{slow or 'keeping up'}{self._clocks_apart()}"
        return _status("timing", WARN if slow else OK, text, values)

    def _clocks_apart(self):
        age = 0.0 if self._age_ns is None else self._age_ns * 1e-9
        if abs(age) < _OTHER_CLOCK:
            return ""
        side = "behind" if age > 0 else "ahead of"
        return f"; stamps are {abs(age):.1f} s {side} this node's clock"


def _beside(status, failed_looks):
    """Return a status with the side looks that failed, which is a warning at least."""
    if not failed_looks:
        return status
    message = "; ".join([status["message"], *failed_looks])
    return status | {"level": max(status["level"], WARN), "message": message}


def _status(name, level, message, values):
    return {
        "level": level,
        "name": name,
        "message": message,
        "hardware_id": HARDWARE_ID,
        "values": [{"key": key, "value": f"{value:.9g}"} for key, value in values.items()],
    }
