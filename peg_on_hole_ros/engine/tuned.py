"""Tuned numbers of the engine: of the order of messages, and of when an estimate is one."""

from typing import NamedTuple


class StampOrder(NamedTuple):
    """
    What becomes of messages whose stamps do not rise.

    Attributes
    ----------
    clock_jump_ns : int
        A stamp that is farther behind is a clock that was set back or a bag played again, and no
        late message [ns].
    most_joint_stamps : int
        Stamps of joint states that are kept at most [stamps]: of 1.5 s, the longest reach, at
        5 kHz.

    """

    clock_jump_ns: int = 1_000_000_000
    most_joint_stamps: int = 8192


class Reprocessing(NamedTuple):
    """
    What is kept to put late messages in their place.

    A snapshot takes some 50 kB, and a fifth of the time that a wrench does.

    Attributes
    ----------
    most_wrenches : int
        Wrenches that a late message can reach back over at most [wrenches]: 1.5 s, the longest
        `filter.late_window` and the longest `joints.delay` together, at 8 kHz.
    most_waiting : int
        Orientations that wait for the wrench of their time [orientations]; at 8 kHz these are
        60 ms.
    room_for_orientations : int
        What is in use moves to the front when so many are there [orientations].
    snapshot_stride : int
        While all comes in order, a snapshot is kept before every wrench of so many [wrenches]:
        going back then begins up to seven wrenches earlier than it would have to.
    every_snapshot : int
        After a late message a snapshot is kept before each of so many [wrenches]: others follow.
    recent_snapshots : int
        The latest wrenches before which every snapshot is kept, once it was [wrenches]; of older
        ones every eighth.
    most_messages : int
        Messages that are processed at once [messages]: what comes of them is held in memory.

    """

    most_wrenches: int = 12_000
    most_waiting: int = 512
    room_for_orientations: int = 32_768
    snapshot_stride: int = 8
    every_snapshot: int = 1000
    recent_snapshots: int = 256
    most_messages: int = 4096


class Tare(NamedTuple):
    """
    Which wrenches a tare is the mean of, and when a peg hangs free and still.

    Attributes
    ----------
    least_ns : int
        A tare is a mean over so long at least [ns].
    fewest : int
        A tare is a mean of so many at least, where they are to be had [wrenches].
    oldest_ns : int
        No wrench of it is older [ns]: the peg may have touched before.
    most_recent : int
        The latest wrenches that are at hand for it [wrenches]: `least_ns` at 40 kHz.
    significance : float
        A peg turns, and a bias is implausible, beyond so much [standard deviations].
    free_ns : int
        A peg that is free and still for so long is tared, where that is asked for [ns].
    most_rates_stddev : float
        Rates that are known no better show no peg at rest [rad/s]: within `least_ns` its weight
        may turn by a tenth of itself. One joint state leaves them at the 1.7 of a start.
    parts : int
        A load may come or go while wrenches are averaged: so many parts of them have to fit, each
        alone [parts].
    untaken_ns : int
        A peg that has been at rest for so long from the start on, and has read the same, is tared
        where nobody has tared it before [ns].
    untaken_automatic_ns : int
        Where nobody asks for it, it has to be so for so long [ns].

    """

    least_ns: int = 100_000_000
    fewest: int = 100
    oldest_ns: int = 500_000_000
    most_recent: int = 4096
    significance: float = 4.0
    free_ns: int = 1_000_000_000
    most_rates_stddev: float = 1.0
    parts: int = 5
    untaken_ns: int = 1_000_000_000
    untaken_automatic_ns: int = 2_000_000_000


class KnownMotion(NamedTuple):
    """
    When the motion is known well enough to be published.

    Attributes
    ----------
    lost : float
        Without any orientation for longer, constant rates lead anywhere, and rounding does in time
        [s].
    rests_ns : int
        On contacts whose reactions have not been determined for longer a peg is at rest [ns].
    vague_tilt : float
        A tilt that is known to less than this share of gamma0 may show no transition [-]: at a
        usual 0.16 rad/s it is some 40 ms.
    near_transition : float
        Such a tilt shows none within so much of gamma0 [standard deviations].
    loaded : float
        A force that a free peg should read is there beyond so much [standard deviations of the
        stated noise].

    """

    lost: float = 5.0
    rests_ns: int = 100_000_000
    vague_tilt: float = 0.1
    near_transition: float = 3.0
    loaded: float = 3.0


class AnnouncedMotion(NamedTuple):
    """
    How long a motion that the robot's program has announced explains an alarm.

    Attributes
    ----------
    behind_ns : int
        An alarm of the motion may rise so long behind it, and is held for as long [ns].

    """

    behind_ns: int = 500_000_000


class DiagnosisStep(NamedTuple):
    """
    When the looks at the settings begin another window.

    Attributes
    ----------
    back_ns : int
        Stamps that fall by more begin another window [ns]: it holds one stretch of rising stamps.
    arrivals : int
        Runs of stamps that wait for the next wrench to be looked at, at most [runs].

    """

    back_ns: int = 100_000_000
    arrivals: int = 1024


STAMP_ORDER = StampOrder()
REPROCESSING = Reprocessing()
TARE = Tare()
KNOWN_MOTION = KnownMotion()
ANNOUNCED_MOTION = AnnouncedMotion()
DIAGNOSIS_STEP = DiagnosisStep()


class EngineNumbers(NamedTuple):
    """All of them, by subject."""

    stamp_order: StampOrder = STAMP_ORDER
    reprocessing: Reprocessing = REPROCESSING
    tare: Tare = TARE
    known_motion: KnownMotion = KNOWN_MOTION
    announced_motion: AnnouncedMotion = ANNOUNCED_MOTION
    diagnosis_step: DiagnosisStep = DIAGNOSIS_STEP
