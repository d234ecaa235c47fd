"""The table of faults: what has to happen with each, declared before anything is run."""

from math import inf, isnan
from typing import NamedTuple

from benchmarks.faults.injector import TURNS

# What the motion of a scene cannot tell, and what says so instead.
SHIFTED = "orientations that are all late or off by one amount look like another motion"
SMOOTH = "a filter that delays says the same as a slower motion"


class Case(NamedTuple):
    """
    A fault and what has to happen.

    What holds for all is not stated: every message has an outcome; while the mode is not `unknown`
    and no status is ERROR, no transition flag is wrong, no jam is missed, and no ERROR of jamming
    is false. Values that count lie within their 95 % bounds in at least INSIDE of the samples from
    `within` after the begin of the fault, and after its end; where the recording without the fault
    has less in the same samples, in as many but SAMPLED.

    Attributes
    ----------
    name : str
    fault : str
        Of the injector.
    parameters : dict
    lasts : bool
        Over the whole recording; else in the part in which the peg slides.
    told : str
        Part of a line of the diagnostics; empty: nothing need be told.
    within : float
        How long after the begin of the fault [s].
    counts : tuple of str
        That are higher than in the clean recording.
    level : int
        Of the diagnostics at least.
    recovers : float
        After the end of the fault [s].
    unseen : str
        Why nothing can observe it: bounds need not hold.
    gamma : float
        Largest error of gamma, where it is unseen [rad].
    answer : str
        Of a call.
    group : str
        In the table one row stands for all of a group.

    """

    name: str
    fault: str
    parameters: dict
    lasts: bool = True
    told: str = ""
    within: float = 0.3
    counts: tuple[str, ...] = ()
    level: int = 0
    recovers: float = 0.1
    unseen: str = ""
    gamma: float = 0.0
    answer: str = ""
    group: str = ""


# Other samples of the same noise.
INSIDE, SAMPLED = 0.9, 0.03
WARN, ERROR = 1, 2
PART = {"lasts": False}
W, J, BOTH = ({"source": source} for source in ("wrench", "joints", "both"))

ARRIVAL = [
    Case("no messages for a while", "gap", BOTH, **PART, counts=("gap",)),
    Case("no wrench for a while", "gap", W, **PART, counts=("gap",)),
    Case("no joint states for a while", "gap", J, **PART),
    Case("a third of the messages lost in bursts", "burst_loss", {"share": 0.3}),
    Case("each message twice", "duplicate", {}, counts=("wrench_dropped_repeated_stamp",)),
    Case("up to 5 ms of delay", "reorder", {}, counts=("wrench_late", "joints_late")),
    Case("1 % of wrenches 80 ms late", "late", W, counts=("wrench_dropped_late",), level=WARN),
    Case("1 % of joint states 80 ms late", "late", J, counts=("joints_dropped_late",), level=WARN),
    Case("half the rate", "rate_halved", {}),
    Case("played in a loop", "loop", {}),
    Case("recorder paused while the peg is set down again", "set_again", {}, **PART),
    Case("1 % of wrenches stamped 0", "stamps_zero", W, counts=("wrench_dropped_late",)),
    Case("1 % of joint states stamped 0", "stamps_zero", J, counts=("joints_dropped_late",)),
    Case("1 % of wrenches stamped 80 ms ahead", "stamps_off", W, counts=("wrench_dropped_ahead",)),
    Case("1 % of joint states stamped 80 ms ahead", "stamps_off", J, counts=("joints_reordered",)),
    Case("1 % of wrenches stamped 80 ms back", "stamps_off", {**W, "by_ms": -80.0},
         counts=("wrench_dropped_late",)),
    Case("stamps in steps of 4 ms", "stamps_coarse", {},
         counts=("wrench_dropped_repeated_stamp",)),
    Case("both clocks jump ahead by 5 s", "clock_jump", {}, **PART, counts=("motion_lost",)),
    Case("both clocks jump back by 5 s", "clock_jump", {"by_s": -5.0}, **PART,
         counts=("clock_jumped_back",)),
    # For good: no orientation belongs to a wrench any more.
    Case("clock of joint states jumps ahead by 5 s", "clock_jump", J, **PART,
         counts=("joints_gap",), recovers=inf),
    Case("joint states stamped 5 ms late", "delay", {}, unseen=SHIFTED, gamma=1.5e-3),
    Case("joint states stamped 20 ms late", "delay", {"by_ms": 20.0}, unseen=SHIFTED, gamma=4e-3),
]  # fmt: skip
VALUES = [
    *(
        Case(f"wrench noise x {n}", "noise", {**W, "times": float(n)}, told="wrench.force_stddev")
        for n in (3, 5, 10)
    ),
    *(
        Case(f"joint noise x {n}", "noise", {**J, "times": float(n)},
             told="joints.position_stddev")
        for n in (3, 5, 10)
    ),
    Case("encoders stand still", "frozen", J, **PART, told="joint states that do not change",
         within=0.15, level=WARN),
    Case("the sensor stands still", "frozen", W, **PART, told="wrenches that do not change",
         within=0.15, level=WARN),
    Case("encoders and sensor stand still", "frozen", BOTH, **PART, told="do not change",
         within=0.15, level=WARN),
    *(
        Case(f"each wrench {n} times", "zero_order_hold", {**W, "times": n},
             told=f"each comes {n} times")
        for n in (4, 10)
    ),
    Case("each joint state 5 times", "zero_order_hold", {**J, "times": 5},
         told="each comes 5 times"),
    Case("low-pass filter of 20 Hz on the wrench", "low_pass", W, unseen=SMOOTH, gamma=1e-3),
    Case("low-pass filter of 20 Hz on the angles", "low_pass", J, unseen=SMOOTH, gamma=2e-3),
    Case("5 % of wrenches NaN", "not_a_number", W, counts=("wrench_dropped_malformed_not_finite",),
         level=WARN),
    Case("5 % of joint states NaN", "not_a_number", J,
         counts=("joints_dropped_malformed_not_finite",), level=WARN),
    Case("spikes of 50 N", "spikes", {"size": 50.0}),
    Case("spikes of 500 N", "spikes", {"size": 500.0}, counts=("wrench_spike",)),
    Case("bias drifts by 0.7 N/s across the peg", "drift", {}, **PART),
    Case("bias of 5 N along the peg for a while", "bias_step", {}, **PART),
    Case("bias of 5 N along the peg", "bias_step", {}),
    Case("bias of 2 N and 0.1 N m across the peg", "bias_step",
         {"force": (2.0, 0, 0), "torque": (0, 0.1, 0)}),
    Case("saturates at 20 N, 1 N m", "saturation", {}, level=WARN),
    Case("wrench in steps of 0.1 N, 0.1 N m", "quantisation", {}, told="comes in steps"),
    Case("wrench with the other sign", "sign", {}, told="set wrench.acts_on"),
    *(Case(f"axes {n} of 23", "axes", {"turn": n}, told="set wrench.sensor_rpy",
           group="sensor axes turned in one of 23 ways") for n in range(len(TURNS) - 1)),
    Case("wrench in the axes of the base", "base_axes", {}, told="set wrench.axes"),
    Case("weight subtracted, or not subtracted although so stated", "compensated_gravity", {},
         told="set wrench.gravity"),
    Case("force in kN", "unit", {"force": 1e-3}, told="unit of the force read as kN"),
    Case("force in pounds", "unit", {"force": 0.2248}, level=WARN),
    Case("torque in N mm", "unit", {"torque": 1e3}, told="unit of the torque read as N mm"),
    Case("angles in degrees", "unit", {"angle": 57.29578}, counts=("joints_dropped_out_of_range",),
         level=WARN),
    Case("gamma and psi exchanged", "joints_permuted", {}, level=WARN),
    Case("psi and phi exchanged", "joints_permuted", {"order": (0, 2, 1)}, level=WARN),
    Case("gamma stands still", "joint_frozen", {}, **PART, level=WARN),
    Case("phi stands still", "joint_frozen", {"joint": 2}, **PART, level=WARN),
    Case("gamma wrong by 2 mrad for a while", "joint_offset", {}, **PART, unseen=SHIFTED,
         gamma=2.5e-3),
    Case("gamma wrong by 2 mrad", "joint_offset", {}, unseen=SHIFTED, gamma=2.5e-3),
    Case("tare in contact", "call", {"what": "tare"}, **PART, counts=("tare_refused",),
         answer="nothing taken"),
    Case("reset in contact", "call", {"what": "reset"}, **PART, counts=("reset",), answer="done"),
]  # fmt: skip
CASES = [*ARRIVAL, *VALUES]
# The recording as it was: the same bounds.
CLEAN = Case("no fault", "", {})
BY_NAME = {case.name: case for case in (CLEAN, *CASES)}


# What is short of it, in words.
ALWAYS = {
    "flag": "{} samples with a wrong transition flag",
    "jam": "{} samples without the jam",
    "false_jam": "{} samples with a false ERROR of jamming",
    "lost": "{} messages without an outcome",
}
SHARES = ("angles", "reactions", "angles_after", "reactions_after")


def shortfalls(case: Case, figures: dict) -> dict[str, str]:
    """
    Return what has to happen with a case and did not, by kind.

    Parameters
    ----------
    case : Case
    figures : dict
        Fields of a Score.

    """
    found = {kind: text.format(figures[kind]) for kind, text in ALWAYS.items() if figures[kind]}
    times = [t for line, t in figures["told"].items() if case.told and case.told in line]
    if case.told and min(times, default=99.0) > case.within + 1e-6:
        found["told"] = f"reported after {min(times):.1f} s" if times else "not reported"
    missing = [name for name in case.counts if not figures["counts"].get(name)]
    if missing:
        found["counts"] = f"no {', '.join(missing)}"
    if figures["level"] < case.level:
        found["level"] = f"diagnostics {('OK', 'WARN', 'ERROR')[figures['level']]}"
    if case.answer and not any(case.answer in text for text in figures["answers"]):
        found["answer"] = "another answer"
    if case.unseen:
        if figures["gamma"] > case.gamma:
            found["gamma"] = f"gamma off by {figures['gamma'] * 1e3:.1f} mrad"
        return found
    for name in SHARES:
        least = min(INSIDE, figures["clean"][name] - SAMPLED)
        # NaN: nothing was said that counts; of the recording as it was, nothing to go by.
        if figures[name] < (INSIDE if isnan(least) else least):
            found[name] = f"{name.replace('_', ' ')} inside {figures[name]:.0%}"
    if not case.lasts and figures["recovered"] > case.recovers:
        found["back"] = f"back after {figures['recovered']:.2g} s"
    return found
