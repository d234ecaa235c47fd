"""Tuned numbers of the engine: of the order of messages, and of when an estimate is one."""

from typing import NamedTuple


class StampOrder(NamedTuple):
    """
    How messages whose stamps do not rise are treated.

    Attributes
    ----------
    clock_jump_ns : int
        A stamp that lies farther back comes from a clock that was set back, or from a bag that is
        played again, and not from a late message [ns].
    most_joint_stamps : int
        Largest number of stamps of joint states that are kept [stamps]: those of 1.5 s, the
        longest reach, at 5 kHz.

    """

    clock_jump_ns: int = 1_000_000_000
    most_joint_stamps: int = 8192


class Reprocessing(NamedTuple):
    """
    Memory for the reprocessing of late messages.

    A snapshot takes some 50 kB and a fifth of the computing time of a wrench.

    Attributes
    ----------
    most_wrenches : int
        Largest number of wrenches over which a late message can reach back [wrenches]: 1.5 s, the
        longest `filter.late_window` and the longest `joints.delay` together, at 8 kHz.
    most_waiting : int
        Number of orientations that can wait for the wrench at their time [orientations]; at 8 kHz
        these are 60 ms.
    room_for_orientations : int
        When this many orientations are stored, those in use are moved to the front [orientations].
    snapshot_stride : int
        While all messages come in order, a snapshot is kept before one wrench of this many
        [wrenches]: reprocessing then begins up to seven wrenches earlier than necessary.
    every_snapshot : int
        For this many wrenches after a late message, a snapshot is kept before each one [wrenches]:
        other late messages usually follow.
    recent_snapshots : int
        Number of the latest wrenches before which every snapshot is kept, once it was made
        [wrenches]; of older ones every eighth is kept.
    most_messages : int
        Largest number of messages that are processed in one call [messages]: their results are
        kept in memory.

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
        Least time over which a tare is averaged [ns].
    fewest : int
        Least number of wrenches in a tare, if they are available [wrenches].
    oldest_ns : int
        Largest age of a wrench in a tare [ns]: the peg may have touched before.
    most_recent : int
        Number of the latest wrenches that are kept for a tare [wrenches]: `least_ns` at 40 kHz.
    significance : float
        A peg turns, and a bias is implausible, beyond this limit [standard deviations].
    free_ns : int
        A peg that is free and still for this time is tared, if automatic tares are enabled [ns].
    most_rates_stddev : float
        If the standard deviation of the rates is larger, the peg is not known to be at rest
        [rad/s]: within `least_ns` its weight may turn by a tenth of itself. After one joint state
        it is 1.7 rad/s.
    parts : int
        Number of parts of the averaged wrenches that have to fit, each alone [parts]: a load may
        come or go meanwhile.
    untaken_ns : int
        A requested tare is accepted if the peg has been at rest, with constant readings, for this
        time from the start on, and was never tared before [ns].
    untaken_automatic_ns : int
        Least such time for an automatic tare [ns].

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
        Longest time without an orientation [s]: after it, constant rates lead to any angle, and so
        do rounding errors.
    rests_ns : int
        A peg whose contacts have had no determined reactions for longer is at rest [ns].
    vague_tilt : float
        If the standard deviation of the tilt is above this share of gamma0, the tilt may not show
        a transition [-]: at a usual 0.16 rad/s the share is some 40 ms.
    near_transition : float
        Such a tilt shows no transition within this distance of gamma0 [standard deviations].
    loaded : float
        The force that a free peg should read counts as present beyond this limit [standard
        deviations of the stated noise].

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
        An alarm from an announced motion may rise until this time after the motion, and is held
        for as long [ns].

    """

    behind_ns: int = 500_000_000


class DiagnosisStep(NamedTuple):
    """
    When the looks at the settings begin another window.

    Attributes
    ----------
    back_ns : int
        Stamps that fall by more begin a new window [ns]: each window has rising stamps only.
    arrivals : int
        Largest number of batches of stamps that wait for the next wrench [runs].

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
