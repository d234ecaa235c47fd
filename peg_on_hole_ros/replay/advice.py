"""What to look at where a recording was hardly used, or fits its configuration badly."""

from collections.abc import Sequence

import numpy as np

from peg_on_hole_ros.bags.batch import Batch, stretches
from peg_on_hole_ros.config.configuration import BY_NAME
from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.diagnosis.guarded_looks import Failures, GuardedLook
from peg_on_hole_ros.engine.tuned import STAMP_ORDER
from peg_on_hole_ros.monitor.way_in import NOT_TOLD
from peg_on_hole_ros.replay.looped_recording import LoopedRecording, contents
from peg_on_hole_ros.replay.topic_findings import TopicOddities

MISFIT = (
    "wrench and motion do not fit each other: check sensor_xyz, the tare, payload and scene, the "
    "hole's direction, joints.delay, the order of joints.names, units (N, N m), and the stated "
    "noise"
)
MISFIT_COUNT = "innovations_too_large"
_NO_STAMPS = "those of one are all zero: its driver does not set them, and has to"
_CLOCKS = "synchronise the clocks of the drivers, or state joints.delay"
_LOOP = "they come again, as in a recording that was played in a loop"
# By the end of a reason's name; docs/counts.md has the rest.
_REMEDY_BY_REASON = {
    "missing_joint": "joints.names has to name joints of the joint states: it is {names}, the "
    "first joint state has {lacking}",
    "joints_dropped_out_of_range": "angles are in radians: degrees? the order of joints.names? a "
    "peg that points up: joints.hole_rpy",
    "outside_joint_limits": "degrees, joints mixed up, or another robot's URDF",
    "pointing_away": "half a turn in joints.peg_rpy or hole_rpy, or the robot is elsewhere",
    "length_mismatch": "the driver sends names without positions",
    "repeated_stamp": "the driver does not set stamps, or too coarsely (whole milliseconds), or "
    "sends twice; or two publish on one topic",
    "repeated_value": "the encoders, or their driver, stand still while the peg turns",
    "dropped_late": _CLOCKS,
    "dropped_ahead": _CLOCKS,
    "joints_gated": "scene, wrench.acts_on, joints.position_stddev or joints.delay is wrong, or "
    "two publish on one topic",
    "out_of_range": "N and N m: a force above 1e6 N is none",
    "unreadable": "two types on one topic, or a definition in the bag that is another's",
    "not_finite": "the driver sends NaN or infinity",
    "bad_stamp": "the driver's stamps have nanoseconds outside 0 to 1e9",
    "repeated_name": "the driver names a joint twice in one message",
    "after_last_wrench": f"the wrench ended before them; {_CLOCKS}",
    "without_orientation": "the joint states stopped, or none of them could be used any more",
    "before_joints": "joint states begin late, or their stamps are of another clock",
}
_SHARED_TOPIC = (
    "usual where another driver shares the topic: joints.names is {names}, the first joint state "
    "without all of them has {lacking}"
)
# Where others share the topic or the robot is elsewhere these are usual; half of the messages tell
# of them, and a tenth of all else.
_USUAL_REASONS = (
    "missing_joint",
    "outside_joint_limits",
    "pointing_away",
    "before_joints",
    "last_wrench",
)
# What becomes of joint states without a wrench, and of wrenches that are told of by themselves.
_OF_WRENCH = ("other_frame", "without_wrench", "last_wrench")
# Longer than a mode takes [s].
_DECLARED = 0.3
_UNKNOWN = (
    "contact mode: unknown throughout, so the wrench fits no contact of this peg: check "
    "wrench.acts_on (the sign), the tare, sensor_xyz, units (N, N m), hole_diameter - peg_diameter"
)
_NEVER_THREE_POINT = (
    "contact mode: two_point, and never three_point before, as gamma stayed below gamma0 = {:.4g} "
    "rad: if the peg rested on the rim, check hole_diameter - peg_diameter (of bore and shank, "
    "not of chamfers) and joints.hole_rpy"
)
# Between the ways of two topics to the recorder there is less [s].
_TRANSPORT = 0.05


class InputOddities:
    """
    Collects what is odd in the joint states and wrenches of a recording, used or not.

    Parameters
    ----------
    joints : JointInput
    failures : Failures
        Looks of this one that fail are switched off, and noted there.

    Attributes
    ----------
    lacking : list of str
        Joints of the first joint state without all of `joints.names`; empty: none was.
    complete : bool
        Whether a joint state has had all of them.

    """

    def __init__(self, joints: JointInput, failures: Failures) -> None:
        self.lacking: list[str] = []
        self.complete = False
        self._needed = set(joints.names)
        self._spans: dict[str, list[int]] = {}
        own = joints.source == "peg"
        self._odd = {
            "wrench": GuardedLook("oddities", TopicOddities, failures),
            "joints": GuardedLook("oddities", lambda: TopicOddities(joints.names, own), failures),
        }
        self._loops = {
            source: GuardedLook("loops", LoopedRecording, failures)
            for source in ("wrench", "joints")
        }

    def add(self, batch: Batch, sources: dict[str, str]) -> None:
        """Take a batch; `sources` says which topics are `wrench` and `joints`."""
        for topic, source in sources.items():
            if topic not in batch.types:
                continue
            found = list(stretches(batch, topic))
            if found:
                self._add(source, found)

    def _add(self, source, found):
        places = np.concatenate([at for at, _ in found])
        t_ns = np.concatenate([stretch.t_ns for _, stretch in found])
        first, last = int(t_ns.min()), int(t_ns.max())
        span = self._spans.setdefault(source, [first, last])
        span[0], span[1] = min(span[0], first), max(span[1], last)
        if source == "joints":
            short = [(at[0], s.names) for at, s in found if not self._needed <= set(s.names)]
            self.complete |= len(short) < len(found)
            if short and not self.lacking:
                self.lacking = list(min(short)[1])
        self._odd[source](lambda look: look.add(found), None)
        held = np.concatenate([contents(stretch.values) for _, stretch in found])
        order = np.argsort(places)
        self._loops[source](lambda look: look.add(t_ns[order], held[order]), None)

    @property
    def loop(self) -> str:
        """What there is to say of stamps that come again, or nothing."""
        found = {
            source: loop(lambda look: look.seconds, 0.0) for source, loop in self._loops.items()
        }
        back = {source: seconds for source, seconds in found.items() if seconds}
        if not back:
            return ""
        seconds = max(back.values())
        if seconds * 1e9 > STAMP_ORDER.clock_jump_ns:
            fate = (
                "each round is a recording of its own, with clock_jumped_back counted at its begin"
            )
        else:
            fate = (
                f"rounds of less than {STAMP_ORDER.clock_jump_ns * 1e-9:g} s are no clock that "
                "was set back, so one of them is used, and the others count as late"
            )
        return (
            f"loop: the stamps of {' and '.join(back)} begin again, up to {seconds:.3f} s back: a "
            f"recording that was played in a loop; {fate}"
        )

    def odd(self, source: str) -> list[str]:
        """Return a line for each oddity in what those of `wrench` or `joints` hold."""
        return self._odd[source](lambda look: look.lines(), [])

    def apart(self, configuration: Configuration) -> str:
        """Return how far stamps of both are apart where none goes with another, or nothing."""
        if len(self._spans) < 2:
            return ""
        return apart(*self._spans["wrench"], *self._spans["joints"], configuration)  # type: ignore[arg-type, call-arg]


def apart(
    wrench_first: int,
    wrench_last: int,
    joints_first: int,
    joints_last: int,
    configuration: Configuration,
) -> str:
    """Return how far stamps [ns] of wrench and joint states are apart, or nothing."""
    delay = configuration.joints.delay
    for gap, where, most in (
        # No wrench is used before there is an orientation to start from.
        (joints_first - wrench_last, "after", delay),
        (wrench_first - joints_last, "before", configuration.filter.max_joint_gap + abs(delay)),
    ):
        if gap * 1e-9 > most:
            unset = wrench_last == 0 or joints_last == 0
            what = _NO_STAMPS if unset else _clocks(gap * 1e-9)
            return (
                f"the stamps of the joint states lie {gap * 1e-9:.3f} s {where} those of the "
                f"wrench, all of them, so that none goes with another; {what}"
            )
    return ""


def shifted(wrench_offset: float, joints_offset: float, delay: float) -> str:
    """
    Return how far stamps lie apart where messages came together, or nothing.

    Parameters
    ----------
    wrench_offset, joints_offset : float
        Log time less stamp, in the mean [s].
    delay : float
        `joints.delay` [s]: stamps that lie apart by it are as stated.

    """
    ahead = wrench_offset - joints_offset
    if abs(ahead) <= _TRANSPORT or abs(ahead - delay) <= _TRANSPORT:
        return ""
    stated = f" (joints.delay is {delay:g} s)" if delay else ""
    return (
        f"stamps lie {abs(ahead):.3f} s {'ahead of' if ahead > 0 else 'behind'} those of wrenches "
        f"that were recorded at the same time{stated}; {_clocks(abs(ahead))}"
    )


def _clocks(seconds):
    """Return what to do about stamps that lie so far apart [s]."""
    return _CLOCKS if seconds <= BY_NAME["joints.delay"].high else _CLOCKS.partition(",")[0]


def remedy(dropped: dict[str, int], names: Sequence[str], seen: InputOddities) -> str:
    """
    Return the remedy for the commonest reason of dropped messages that has one.

    Parameters
    ----------
    dropped : dict of str to int
    names : sequence of str
        `joints.names`.
    seen : InputOddities

    """
    for reason in sorted(dropped, key=lambda reason: ("before" in reason, -dropped[reason])):
        for end, text in _REMEDY_BY_REASON.items():
            if reason.endswith(end):
                if end == "missing_joint" and seen.complete:
                    text = _SHARED_TOPIC
                if _CLOCKS in text and seen.loop:
                    text = _LOOP
                return text.format(names=list(names), lacking=seen.lacking)
    return "docs/counts.md has the remedy for each reason"


def lines(
    result: dict,
    read: dict[str, int],
    configuration: Configuration,
    seen: InputOddities,
    causes: list[str] | None = None,
    joints_explained: bool = False,
) -> list[str]:
    """
    Return a line for each thing that makes a replay's numbers doubtful.

    Parameters
    ----------
    result : dict
        What `--summary` has of the replay.
    read : dict of str to int
        Messages in the bag of `wrench` and `joints`.
    configuration : Configuration
    seen : InputOddities
    causes : list of str, optional
        Settings that the data have contradicted; they take the place of guesses.
    joints_explained : bool
        Whether these say what is odd about the values of joint states.

    """
    told = list(causes or ())
    # Joint states for which no wrench is left are its matter.
    ended = "wrench_dropped_other_frame" in result["messages"]["dropped"]
    for source, count in read.items():
        dropped = {k: n for k, n in result["messages"]["dropped"].items() if k.startswith(source)}
        if joints_explained:
            dropped.pop("joints_dropped_repeated_value", None)
        if ended:
            dropped = {k: n for k, n in dropped.items() if not k.endswith(_OF_WRENCH)}
        lost, odd = sum(dropped.values()), {}
        if 2 * lost <= count:
            odd = {
                k: n
                for k, n in dropped.items()
                if 10 * n > count and not k.endswith(_USUAL_REASONS)
            }
        if 2 * lost > count or odd:
            what = remedy(odd or dropped, configuration.joints.names, seen)
            told.append(f"{lost} of {count} messages of {source} were not used: {what}")
    unknown = configuration.monitor.modes and result["contact_mode"].get("unknown") == 1.0
    # A mode takes its time to be declared.
    if unknown and result["duration"] > _DECLARED and not told and not causes:
        told.append(_UNKNOWN)
    shares = result["contact_mode"]
    known = 1.0 - shares.get("unknown", 0.0)
    if shares.get("two_point", 0.0) > 0.5 * known and not shares.get("three_point"):
        told.append(_NEVER_THREE_POINT.format(configuration.scene.gamma0))
    misfit = result["messages"]["events"].get(MISFIT_COUNT)
    undecided = result["messages"]["events"].get("contact_may_be_plate")
    placed = configuration.joints.place_stddev is not None
    told += [NOT_TOLD] if undecided and not placed and NOT_TOLD not in told else []
    odd_lines = [
        f"{source}: {line}"
        for source in read
        if not (joints_explained and source == "joints")
        for line in seen.odd(source)
    ]
    told += [line for line in odd_lines if line not in told]
    told += [seen.loop] if seen.loop else []
    return [*told, *([f"{MISFIT_COUNT}: {MISFIT}"] if misfit and not causes else [])]
