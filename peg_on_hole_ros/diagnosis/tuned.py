"""Tuned numbers of the looks at what is stated of wrench and joints, each with its reason."""

from typing import NamedTuple


class LookTimes(NamedTuple):
    """
    Which wrenches are looked at.

    Attributes
    ----------
    period_ns : int
        Time between two wrenches that are looked at [ns].
    first_ns : int
        Time between two of the first wrenches that are looked at, before a contact is detected
        [ns].
    first : int
        Number of these first wrenches [wrenches].

    """

    period_ns: int = 20_000_000
    first_ns: int = 4_000_000
    first: int = 10


class HypothesisPriors(NamedTuple):
    """
    Prior costs of wrong settings.

    Attributes
    ----------
    one_wrong : float
        Prior cost of the first wrong setting of a hypothesis [nats].
    more_wrong : float
        Prior cost of each further wrong setting [nats]: two wrong settings at once are rare.

    """

    one_wrong: float = 3.0
    more_wrong: float = 6.0


class WrenchBalance(NamedTuple):
    """
    The quantities that balance a wrench, and the residual that may remain.

    Attributes
    ----------
    likely_frictions : int
        Number of friction coefficients that are likely with the stated friction [coefficients].
    frictions : int
        Number of all friction coefficients that are tried, the likely ones first [coefficients]:
        only the wrench as stated may have any of them.
    reaction : float
        Prior standard deviation of a reaction [N].
    anything : float
        Prior standard deviation of a force that no hypothesis explains [N].
    unexplained : float
        Share of a load that friction, levers and the shape of the peg leave unexplained [-].

    """

    likely_frictions: int = 3
    frictions: int = 12
    reaction: float = 200.0
    anything: float = 100.0
    unexplained: float = 0.03


class LookWindow(NamedTuple):
    """
    The window of the last looks at the wrench.

    Attributes
    ----------
    kept : int
        Number of wrenches that are kept [wrenches]: those of one second.
    side : int
        Number of neighbours on each side from which the rates of one wrench are computed
        [wrenches].
    fits : float
        Sum of the squared residuals of six components below which a wrench fits [-]: a chi-squared
        variable of 6 degrees of freedom is above it once in 160.
    surprise : float
        Sum above which a wrench is surprising [-]: chance exceeds it once in 16.
    nothing : float
        Largest sum that counts [-]: a wrench above it is explained by no hypothesis.
    share : float
        Share of surprising wrenches from which on other hypotheses are tested [-].
    direction : float
        A slip has a direction if it is this far above zero [standard deviations].
    steps : int
        Number of steps from the best of the tried friction coefficients to the one with the
        smallest residual [steps].

    """

    kept: int = 50
    side: int = 2
    fits: float = 18.0
    surprise: float = 12.0
    nothing: float = 50.0
    share: float = 0.2
    direction: float = 5.0
    steps: int = 2


class RoundingSteps(NamedTuple):
    """
    In which steps a driver may round the wrench.

    Attributes
    ----------
    sizes : tuple of float
        Steps of rounding that are tried, the coarsest first [N]; 0: no rounding. Torques are
        rounded to the same number in N m.

    """

    sizes: tuple[float, ...] = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.0)


class WrongWrenchTest(NamedTuple):
    """
    When a setting of the wrench is reported.

    Attributes
    ----------
    news : int
        Wrenches of one second have errors in common [wrenches]: together they count as this many.
    doubt : float
        Least advantage of a hypothesis over the stated settings for the state "suspected" [nats].
    sure : float
        Least advantage over the stated settings for a report [nats].
    apart : float
        Least advantage over other hypotheses, to be distinguished from them [nats].
    enough : int
        Least number of wrenches that are looked at [wrenches].
    explained : float
        Least share of them that is explained [-].
    halved : float
        Largest share of the residual of the force balance that may remain [-].
    room : float
        Largest remaining residual, over the noise [-].
    often : int
        After this many unexplained wrenches in a row, only one of this many is tested in detail
        [wrenches].
    weight_known : float
        Standard deviation of the weight, as a share of it [-].
    center_known : float
        Standard deviation of the mass centre [m].
    carried : float
        Acceleration of a holder, over its stated maximum [-].
    vague : float
        A bias that may be larger than this share of the weight may be mistaken for it [-].

    """

    news: int = 8
    doubt: float = 8.0
    sure: float = 15.0
    apart: float = 5.0
    enough: int = 12
    explained: float = 0.6
    halved: float = 0.5
    room: float = 1.6
    often: int = 5
    weight_known: float = 0.02
    center_known: float = 1e-3
    carried: float = 1.0 / 3.0
    vague: float = 0.1


class LargerUnitTest(NamedTuple):
    """
    When the noise of a wrench is that of another unit.

    Attributes
    ----------
    times : float
        Ratio of the stated noise to the measured one [-]: a kilonewton gives a thousand.
    fewest : int
        Number of wrenches after which another unit is suspected [wrenches].
    enough : int
        Number of wrenches after which it is reported [wrenches].

    """

    times: float = 100.0
    fewest: int = 8
    enough: int = 100


class LiesAcrossTest(NamedTuple):
    """
    When a peg lies across its hole.

    Attributes
    ----------
    tilt : float
        Tilt from which on a peg lies across [rad]: pegs are set on the rim at about 0.3 rad.
    near : float
        Largest distance of the lower end from the hole, over the height of the peg [-].
    looks : int
        Number of looks in a row for a report [looks].

    """

    tilt: float = 1.0
    near: float = 1.0
    looks: int = 25


class SettingFitTest(NamedTuple):
    """
    When one setting explains wrench and motion of a cycle, and what is fitted.

    Attributes
    ----------
    kept : int
        Number of looks that are kept, one every 20 ms [looks].
    silence_ns : int
        After a gap of this length the test restarts [ns].
    fewest_air : int
        Least number of looks at a peg that hangs free, before contact [looks].
    clear : float
        A peg whose lowest point is this far above the rim hangs free, whatever the wrench is [m].
    before : int
        Number of looks before the first contact that count neither as air nor as contact [looks]:
        touch-down is detected late.
    first : int
        Number of looks in contact before the first evaluation, and between two evaluations
        [looks]. If an evaluation gave no result, the next one comes after twice as many looks as
        there were.
    fewest : int
        Least number of rows that slide on the rim [looks].
    most : int
        Largest number of rows that are used [looks].
    least_load : float
        Least load on the rim [N].
    loud : float
        Least load on the rim, over the noise [standard deviations].
    above : float
        Least tilt over gamma0 on three contacts [-].
    nearest_tilt : float
        Least tilt over gamma0 at which the equations of three contacts are evaluated [-].
    slowest : float
        Least slip velocity that has a direction [m/s].
    ahead : float
        Time on both sides over which the rates of turned axes are computed as differences [s].
    unexplained : float
        Share of a load that friction, levers and inertia leave unexplained [-].
    unexplained_much : float
        Largest such share in any cell, with gears that bend and compliant contacts [-].
    zero_force : float
        Prior standard deviation of the bias of the force, which a tare with wrong settings may
        have caused [N].
    zero_torque : float
        Prior standard deviation of the bias of the torque [N m].
    friction : float
        Prior standard deviation of friction about the stated one [-].
    nothing : float
        Largest sum of squared residuals of a row that counts [-]: no setting explains such a row.
    nothings : tuple of float
        Largest sums that count in successive stages of the fit [-]: far from the solution every
        row contributes.
    steps : int
        Number of steps in each stage [steps].
    shortenings : int
        Largest number of times a step is shortened [steps].
    gained : float
        A stage ends if the gain of a step in squared residuals is smaller [-].
    delays : tuple of float
        Start values of the delay [s]: between two of them the likelihood may have a minimum.
    sure : float
        Least advantage of one kind of setting over the stated settings [nats].
    apart : float
        Least advantage over any other kind [nats].
    held_out : float
        Least advantage in one half of the contact, with the value from the other half [nats].
    explained : float
        Largest squared residual that remains, over the noise [-].
    least_mass : float
        Least change of a mass that is reported [kg].
    least_weight : float
        Least such change as a share of all that hangs at the sensor [-]: scales are that accurate.
    near_mass : float
        Largest distance of a mass from its stated place [m].
    least_place : float
        Least displacement of the sensor that is reported [m].
    least_turn : float
        Least rotation that is reported [rad].
    least_larger : float
        Least change of the logarithm of the clearance that is reported [nats].
    least_delay : float
        Least delay that is reported [s].
    far : float
        Sum of squared residuals of a row, of three components, that noise does not cause [-].
    often : float
        Share of such rows from which on no setting fits [-].
    looks : int
        Number of evaluations in a row in which no setting fits, for a report [judgements].

    """

    kept: int = 600
    silence_ns: int = 200_000_000
    fewest_air: int = 25
    clear: float = 5e-3
    before: int = 3
    first: int = 75
    fewest: int = 60
    most: int = 240
    least_load: float = 8.0
    loud: float = 12.0
    above: float = 1.05
    nearest_tilt: float = 1.02
    slowest: float = 1e-4
    ahead: float = 1e-3
    unexplained: float = 0.005
    unexplained_much: float = 0.03
    zero_force: float = 30.0
    zero_torque: float = 3.0
    friction: float = 0.3
    nothing: float = 50.0
    nothings: tuple[float, ...] = (1e4, 500.0, 50.0)
    steps: int = 4
    shortenings: int = 4
    gained: float = 0.5
    delays: tuple[float, ...] = (-0.04, -0.02, -0.01, 0.0, 0.01, 0.02, 0.03, 0.05)
    sure: float = 15.0
    apart: float = 8.0
    held_out: float = 5.0
    explained: float = 1.6
    least_mass: float = 0.03
    least_weight: float = 0.05
    near_mass: float = 0.01
    least_place: float = 5e-3
    least_turn: float = 0.01
    least_larger: float = 0.2
    least_delay: float = 4e-3
    far: float = 25.0
    often: float = 0.4
    looks: int = 2


class DeadComponentTest(NamedTuple):
    """
    When a component of the wrench that stays the same is dead.

    Attributes
    ----------
    suspected : int
        Number of wrenches with one value, bit for bit, after which a component is suspected,
        before any other setting can be reported [wrenches].
    reported : int
        Number of such wrenches after which the component is reported [wrenches].
    most : int
        Largest number of components, force and torque, that stay the same together [components].
        If more do, the values are no readings of a sensor: coarsely rounded, or computed without
        noise.
    alive : float
        Share of distinct values of a component that works [-].
    fine : float
        Least distance of two values of that component, over the stated noise [standard
        deviations]: coarser steps come from rounding, which may hide the noise of the other
        components too.

    """

    suspected: int = 10
    reported: int = 25
    most: int = 2
    alive: float = 0.8
    fine: float = 0.5


class DelayTrial(NamedTuple):
    """
    When another delay of the joint states is tried, and reported.

    Attributes
    ----------
    kept : int
        Number of looks that are compared with one another [looks].
    silence_ns : int
        Longest time from one look to the next [ns].
    means : int
        Number of means that represent the wrenches between two looks [means].
    every : int
        Number of looks between two evaluations [looks].
    doubled : int
        How often this number is doubled after evaluations without a result [times].
    first : float
        Delay that is tried first, in both directions from the stated one [s].
    tried : tuple of float
        Delays that are tried in the more likely direction [s].
    likelier : float
        Advantage from which on a delay is examined in detail [nats].
    sure : float
        Least advantage over the stated delay for a report [nats].
    apart : float
        Least advantage over any other setting [nats].
    least : float
        Least delay that is reported [s].
    agrees : float
        Largest difference between the delay of one second and that of the seconds before [standard
        deviations].
    finest : float
        Least standard deviation of the delay from one second, whatever its noise [s].
    known : float
        Largest standard deviation of a delay that is reported [s].
    unexplained : float
        Share of a load that friction and levers leave unexplained [-].
    nearest_tilt : float
        Least tilt over gamma0 [-].
    slides : float
        Least slip velocity, over that of a contact that may be slow [-].
    changes : float
        Least change of a rate, over its maximum, that distinguishes a delay from a rotation of the
        hole [-].
    iterations : int
        Number of iterations of a climb [iterations].

    """

    kept: int = 50
    silence_ns: int = 60_000_000
    means: int = 4
    every: int = 25
    doubled: int = 7
    first: float = 0.01
    tried: tuple[float, ...] = (0.005, 0.015, 0.02, 0.03, 0.04, 0.05, 0.06)
    likelier: float = 5.0
    sure: float = 15.0
    apart: float = 5.0
    least: float = 0.003
    agrees: float = 2.0
    finest: float = 0.001
    known: float = 0.002
    unexplained: float = 0.002
    nearest_tilt: float = 1.03
    slides: float = 2.0
    changes: float = 0.5
    iterations: int = 3


class FreeAirTest(NamedTuple):
    """
    What the wrench of a peg in the air shows of weight, zero and axes.

    Attributes
    ----------
    kept : int
        Number of wrenches that are compared at once [wrenches].
    span_ns : int
        Least time that they span [ns].
    sure : float
        A mean that is farther from zero is not noise [standard deviations].
    stated : float
        Such a mean also has to be farther from the stated bias than this [standard deviations].
    same : float
        Largest variance of a reading that stays the same, over that of the noise [-].
    likelier : float
        Least advantage of another setting for a report [nats].
    along : float
        Least share of a force along gravity if the force is a weight [-].
    weight_known : float
        Standard deviation of the weight, as a share of it [-].
    center_known : float
        Standard deviation of the mass centre [m].
    carried : float
        Share of the acceleration of the holder that lasts [-].

    """

    kept: int = 50
    span_ns: int = 700_000_000
    sure: float = 6.0
    stated: float = 3.0
    same: float = 1.6
    likelier: float = 15.0
    along: float = 0.98
    weight_known: float = 0.03
    center_known: float = 2e-3
    carried: float = 0.3


class BurstsTest(NamedTuple):
    """
    When wrenches come in bursts.

    Attributes
    ----------
    kept : int
        Number of stamps that are compared at once [stamps].
    fewest : int
        Least number of steps between stamps for a report [steps].
    bursts : int
        Least number of pauses between bursts [pauses].
    close : float
        Stamps of one burst are closer than this share of the mean period [-].
    size : int
        Least number of wrenches in a burst [wrenches]: a thread that wakes late makes pairs.
    period_ns : int
        Least time from one burst to the next [ns]: shorter bursts hardly change a reaction.
    share : float
        Least share of the steps and of the bursts with this pattern [-].

    """

    kept: int = 256
    fewest: int = 60
    bursts: int = 9
    close: float = 0.25
    size: int = 3
    period_ns: int = 4_000_000
    share: float = 0.9


class EncoderStep(NamedTuple):
    """
    When values of joints lie on a grid.

    Attributes
    ----------
    distances : int
        Least number of distances between distinct values [distances]: this many are whole
        multiples of the smallest by chance in one case of a million.
    distinct : float
        Largest number of distinct values of a joint, as a share of its messages [-]: a joint that
        moves by less than a step from message to message repeats each value.
    off : float
        Largest difference of a distance from a whole number of steps [-]. Steps of several joints
        that agree to this belong to one grid.
    rounding : float
        Values closer than this are equal [rad].

    """

    distances: int = 4
    distinct: float = 0.7
    off: float = 0.02
    rounding: float = 1e-9


class CoarseJointsTest(NamedTuple):
    """
    When joint states come in steps that are wider than their noise.

    Attributes
    ----------
    kept : int
        Number of joint states that are compared at once [messages].
    fewest : int
        Least number of joint states for a report [messages].
    every : int
        The test runs once in this many looks of 20 ms, because encoders do not change [looks].

    """

    kept: int = 256
    fewest: int = 20
    every: int = 10


class TwinJointsTest(NamedTuple):
    """
    When joint states are of two motions that take turns.

    Attributes
    ----------
    kept : int
        Number of joint states that are compared at once [messages]: 0.13 s at 500 Hz, in which a
        motion is a parabola.
    kept_steps : int
        Number of joint states in which steps of an encoder are looked for [messages].
    rounds : int
        How often each message is assigned to one of the motions [rounds].
    fewest : int
        Least number of messages of the rarer motion [messages].
    turns : int
        Least number of changes from one motion to the other [changes]: a step, and a vibration far
        below the message rate, have fewer.
    clear : float
        Least distance of the motions, over the residual of each [-]: the halves of one normal
        distribution have 2.7, those of a sine 4.1.
    grid : float
        Least distance of the motions in steps of the encoders [steps]: a joint between two steps
        toggles.
    every : int
        The test runs once in this many looks of 20 ms, because publishers do not change [looks].

    """

    kept: int = 64
    kept_steps: int = 256
    rounds: int = 3
    fewest: int = 8
    turns: int = 16
    clear: float = 6.0
    grid: float = 1.5
    every: int = 10


class ClockDriftTest(NamedTuple):
    """
    When the clocks of wrench and joint states drift apart.

    Attributes
    ----------
    block_ns : int
        Length of a block whose median counts [ns]: the time for which many messages are under way.
    fewest : int
        Least number of joint states in a block [joint states].
    blocks : int
        Least number of blocks for a report [blocks].
    most_blocks : int
        When there are this many blocks, every second one is kept [blocks].
    apart : float
        Least drift apart for a report [s]: from here on reactions become wrong.
    straight : float
        Largest distance of the blocks from a line, as a share of the drift [-].

    """

    block_ns: int = 200_000_000
    fewest: int = 5
    blocks: int = 8
    most_blocks: int = 64
    apart: float = 0.005
    straight: float = 0.15


class ClockStepTest(NamedTuple):
    """
    When stamps that jump are those of a clock that was set.

    Attributes
    ----------
    kept : int
        Number of messages that are compared at once [messages].
    around : int
        Number of messages before and after a jump without another jump [messages].
    fewest : int
        Least number of joint states among these [joint states].
    least_ns : int
        Least jump [ns]: delays in a network are usually shorter.
    near : float
        Largest difference between the jump and what the stamps of the other input show, as a share
        of the jump [-].
    both_ns : int
        If both clocks jump back by more, the filter restarts and counts it [ns].
    again_ns : int
        A recording that is played again begins within this time of its first stamp [ns].
    settles_ns : int
        After this time no result depends on stamps before the jump [ns].
    most : int
        Largest number of steps that are reported [steps].

    """

    kept: int = 2048
    around: int = 25
    fewest: int = 5
    least_ns: int = 50_000_000
    near: float = 0.2
    both_ns: int = 1_000_000_000
    again_ns: int = 50_000_000
    settles_ns: int = 1_000_000_000
    most: int = 6


class OscillationTest(NamedTuple):
    """
    When the wrench oscillates at one frequency.

    Attributes
    ----------
    stretch_ns : int
        Length of the part in which a frequency is looked for [ns]: it separates two frequencies
        that are 8 Hz apart.
    fewest : int
        Least number of wrenches in a part [wrenches].
    stretches : int
        An oscillation is reported after this many parts in a row with one frequency [stretches].
    lasts : int
        An oscillation has ended after this many parts in a row without it [stretches]: a
        touch-down hides it for a moment.
    first_bin : int
        First bin that is examined [bins]: lower bins contain the motion.
    beside : int
        Distance in bins from which on a bin does not belong to a line [bins].
    above : float
        Least power of a line, over the median of all bins [-].
    narrow : float
        Least power of a line, over that of the bins beside it [-].
    same : float
        Frequencies that differ by less than this share are equal [-].
    counts : float
        Amplitude over the stated noise above which the oscillation counts as noise [-]. It is
        above the root of two, the amplitude over the noise that any oscillation has if the noise
        includes it. A smaller one adds less than half to the noise.
    loud : float
        Amplitude over the stated noise above which no contact is declared until the load was
        averaged over whole periods [-].
    mean_s : float
        Least time over which the load is averaged, in whole periods [s].
    slight : float
        A load below this share of a strong oscillation is not reported [-]: little of the
        oscillation remains in the mean, and white noise of its size may or may not be a slight
        contact.
    mains : tuple of float
        Frequencies of the mains, and twice these [Hz].

    """

    stretch_ns: int = 250_000_000
    fewest: int = 50
    stretches: int = 3
    lasts: int = 6
    first_bin: int = 3
    beside: int = 3
    above: float = 30.0
    narrow: float = 8.0
    same: float = 0.03
    counts: float = 1.5
    loud: float = 4.0
    mean_s: float = 0.025
    slight: float = 0.33
    mains: tuple[float, ...] = (50.0, 60.0, 100.0, 120.0)


class UntakenZeroTest(NamedTuple):
    """
    When the first reading of a peg at rest may be a bias without a tare.

    Attributes
    ----------
    force : float
        A larger component of the force is no bias [N]: sensors of collaborative robots have some
        newtons before a tare.
    torque : float
        A larger component of the torque is no bias [N m].
    turned : float
        A peg that has turned by more is not at rest [standard deviations]: 1 mrad with the usual
        orientation noise of 0.1 mrad, 6 ms of a closing at 0.16 rad/s.
    recent : int
        The mean of this many of the latest looks is compared with the ones before [looks].
    changed : float
        A load that differs by more has changed [standard deviations].
    sure : float
        A reading differs from the weight if its mean is farther away than this [standard
        deviations].
    least_noise : float
        A sensor whose readings differ by less is simulated and has no bias [standard deviations of
        the stated noise].
    noise_ns : int
        Time after which a sensor has shown its noise [ns].
    silence_ns : int
        After a longer gap the test of a peg at rest restarts [ns].
    reported_ns : int
        Time after which an unexplained reading is reported [ns]: other explanations are found
        before.

    """

    force: float = 10.0
    torque: float = 0.25
    turned: float = 4.0
    recent: int = 5
    changed: float = 6.0
    sure: float = 4.0
    least_noise: float = 0.02
    noise_ns: int = 30_000_000
    silence_ns: int = 1_000_000_000
    reported_ns: int = 500_000_000


class StandingWrenchTest(NamedTuple):
    """
    When a constant wrench is reported; `measurements.standing_wrench` detects it.

    Attributes
    ----------
    zeros_ns : int
        Time after which zeros are reported if a weight hangs at the sensor [ns]: early enough for
        diagnostics at 1 Hz, and longer than one lost message.
    held_ns : int
        Time after which another constant value of a sensor with noise is reported [ns]: a driver
        that repeats the last value for a lost packet is in order.

    """

    zeros_ns: int = 150_000_000
    held_ns: int = 500_000_000


class WrenchStep(NamedTuple):
    """
    What a step of the wrench from one message to the next is.

    Attributes
    ----------
    changes : float
        A component that changes by more is examined [standard deviations of the stated noise, or
        of what is found].
    line : float
        Time on both sides over which a line is fitted to the readings [s]: loads change linearly
        for about this long.
    fewest : int
        Least number of readings for a line [wrenches].
    first : int
        Number of readings after a step that first show it [wrenches].
    less : float
        Largest reading after a tare, over the force before it [-]: the remaining force is what the
        load has changed since the readings that were averaged.
    gap : float
        A time between wrenches that is this many times the usual one is a gap [-].
    straight : float
        A load whose distance from a line is larger does not change linearly [standard deviations].
    taken : float
        Longest time over which a driver averages its bias [s].
    missed : float
        Error of the lines at the ends of a step, as a share of the step, if the load bends there
        [-].
    sure : float
        A reading differs from the expected one beyond this limit [standard deviations].

    """

    changes: float = 6.0
    line: float = 0.03
    fewest: int = 8
    first: int = 4
    less: float = 0.7
    gap: float = 1.5
    straight: float = 1.5
    taken: float = 0.1
    missed: float = 0.05
    sure: float = 4.0


class ZeroJumpTest(NamedTuple):
    """
    When a step of the wrench is a step of the bias.

    Attributes
    ----------
    kept_ns : int
        Time of the wrenches that are examined [ns].
    sure : float
        A reading differs from the expected one beyond this limit [standard deviations].
    stays_ns : int
        A change that stays for this time is a jump [ns]: a motion that reverses with 0.3 rad/s^2
        has turned by 1.5 mrad in it.
    looks : int
        Number of orientations that are kept [looks]: those of 0.24 s.
    fewest_looks : int
        Least number of orientations on each side of a step [looks].
    turned : float
        The motion has changed if the peg is this far from the angle to which it would have turned
        [standard deviations].
    rate : float
        The motion has also changed if this distance is more than this share of what the peg has
        turned [-].
    in_air : int
        Number of looks over which the reading of a free peg is averaged [looks]: one second.
    settles_ns : int
        Time after a jump in which no contact is declared [ns]: the estimate restarts and has to
        determine the contacts again.

    """

    kept_ns: int = 250_000_000
    sure: float = 4.0
    stays_ns: int = 100_000_000
    looks: int = 12
    fewest_looks: int = 3
    turned: float = 15.0
    rate: float = 0.3
    in_air: int = 50
    settles_ns: int = 400_000_000


class RimMotionTest(NamedTuple):
    """
    What the path of a peg on the rim shows of hole and clearance.

    Attributes
    ----------
    kept : int
        Number of orientations that are compared at once [orientations].
    period_ns : int
        Time between two of them [ns].
    silence_ns : int
        After a gap of this length the test restarts [ns].
    every : int
        Number of orientations between two evaluations [orientations].
    share : float
        A path contradicts the settings if this share of it is left unexplained [-].
    noisy : float
        The unexplained part also has to be this many times the noise [-].
    explained : float
        A setting explains the path if it leaves at most this share of the unexplained part [-].
    surely : float
        Largest share that a peg that leans in its tool leaves [-]: a wrong zero of a joint leaves
        more.
    surely_way : float
        Largest share that a displaced lower end leaves [-]: exchanged joints leave more.
    at_noise : float
        A setting also explains the path if it leaves at most this many times the noise [-].
    often : int
        Number of evaluations in a row in which a setting nearly explains the path, and none
        explains it well, for a report [looks].
    apart : float
        Largest share of what any other setting leaves [-].
    least_lean : float
        Least lean of a hole that a motion shows [rad].
    most_lean : float
        Largest lean of a hole or a peg [rad].
    least_turn : float
        Least lean of a peg in its tool that a motion shows [rad].
    least_way : float
        Least displacement of the lower end that is reported [m].
    most_way : float
        Largest displacement [m]: no tool is longer.
    least_larger : float
        Least change of the logarithm of the clearance that is reported [nats].
    most_larger : float
        Largest change of the logarithm of the clearance [nats]: the outer diameters of chamfers of
        1 mm turn 0.2 mm into 4.2 mm.
    steps : int
        Number of steps of the fit, and of times that each is shortened [steps].
    small : float
        Step of the differences from which the Jacobians of the fit are computed [-].

    """

    kept: int = 50
    period_ns: int = 20_000_000
    silence_ns: int = 200_000_000
    every: int = 10
    share: float = 0.05
    noisy: float = 6.0
    explained: float = 0.35
    surely: float = 0.28
    surely_way: float = 0.05
    at_noise: float = 1.5
    often: int = 5
    apart: float = 0.6
    least_lean: float = 0.07
    most_lean: float = 1.0
    least_turn: float = 0.02
    least_way: float = 5e-3
    most_way: float = 1.0
    least_larger: float = 0.35
    most_larger: float = 4.0
    steps: int = 8
    small: float = 1e-4


class StatedGravityTest(NamedTuple):
    """
    When gravity as stated contradicts the robot's description.

    Attributes
    ----------
    most_off : float
        Largest angle between both directions at which they agree [degree]: the direction of a base
        on a floor, or of a hole that was measured by hand, is accurate to one or two degrees.

    """

    most_off: float = 3.0


class LateWrenchTest(NamedTuple):
    """
    When wrenches repeat earlier ones, and when they are in time again.

    Attributes
    ----------
    kept : int
        Number of wrenches among which a repeated one is looked for [wrenches]: 4 s at 1 kHz.
    fewest : int
        Least number of repeated wrenches in a row, and of wrenches in between [wrenches]: coarse
        values that toggle repeat sooner.
    joints : int
        Number of joint states in a row that repeat as well if a recording is played again
        [messages].
    turned : float
        Change of the tilt from one look to the next above which the motion counts [rad].
    fits : int
        The wrenches are in time again after the motion agrees with them in this many looks of 20
        ms [looks].
    fits_again : int
        This many looks are sufficient if the motion disagreed before, which shows that it would
        disagree again [looks].

    """

    kept: int = 4096
    fewest: int = 20
    joints: int = 5
    turned: float = 5e-4
    fits: int = 50
    fits_again: int = 3


class UnobservableTest(NamedTuple):
    """
    When the stated settings are refuted, but the wrong one cannot be determined.

    Attributes
    ----------
    period_ns : int
        Time between two looks [ns]: wrenches in between have errors in common.
    refuted : float
        Evidence against the stated friction that is needed [nats].
    looks : int
        Number of looks in a row with this evidence [looks].

    """

    period_ns: int = 50_000_000
    refuted: float = 8.0
    looks: int = 3


LOOK_TIMES = LookTimes()
HYPOTHESIS_PRIORS = HypothesisPriors()
WRENCH_BALANCE = WrenchBalance()
LOOK_WINDOW = LookWindow()
ROUNDING_STEPS = RoundingSteps()
WRONG_WRENCH_TEST = WrongWrenchTest()
BURSTS_TEST = BurstsTest()
ENCODER_STEP = EncoderStep()
COARSE_JOINTS_TEST = CoarseJointsTest()
TWIN_JOINTS_TEST = TwinJointsTest()
CLOCK_DRIFT_TEST = ClockDriftTest()
CLOCK_STEP_TEST = ClockStepTest()
DEAD_COMPONENT_TEST = DeadComponentTest()
LARGER_UNIT_TEST = LargerUnitTest()
LIES_ACROSS_TEST = LiesAcrossTest()
SETTING_FIT_TEST = SettingFitTest()
DELAY_TRIAL = DelayTrial()
FREE_AIR_TEST = FreeAirTest()
OSCILLATION_TEST = OscillationTest()
STANDING_WRENCH_TEST = StandingWrenchTest()
LATE_WRENCH_TEST = LateWrenchTest()
UNTAKEN_ZERO_TEST = UntakenZeroTest()
WRENCH_STEP = WrenchStep()
ZERO_JUMP_TEST = ZeroJumpTest()
RIM_MOTION_TEST = RimMotionTest()
STATED_GRAVITY_TEST = StatedGravityTest()
UNOBSERVABLE_TEST = UnobservableTest()


class DiagnosisNumbers(NamedTuple):
    """All of them, by subject."""

    look_times: LookTimes = LOOK_TIMES
    hypothesis_priors: HypothesisPriors = HYPOTHESIS_PRIORS
    wrench_balance: WrenchBalance = WRENCH_BALANCE
    look_window: LookWindow = LOOK_WINDOW
    rounding_steps: RoundingSteps = ROUNDING_STEPS
    wrong_wrench_test: WrongWrenchTest = WRONG_WRENCH_TEST
    bursts_test: BurstsTest = BURSTS_TEST
    encoder_step: EncoderStep = ENCODER_STEP
    coarse_joints_test: CoarseJointsTest = COARSE_JOINTS_TEST
    twin_joints_test: TwinJointsTest = TWIN_JOINTS_TEST
    clock_drift_test: ClockDriftTest = CLOCK_DRIFT_TEST
    clock_step_test: ClockStepTest = CLOCK_STEP_TEST
    dead_component_test: DeadComponentTest = DEAD_COMPONENT_TEST
    larger_unit_test: LargerUnitTest = LARGER_UNIT_TEST
    lies_across_test: LiesAcrossTest = LIES_ACROSS_TEST
    setting_fit_test: SettingFitTest = SETTING_FIT_TEST
    delay_trial: DelayTrial = DELAY_TRIAL
    free_air_test: FreeAirTest = FREE_AIR_TEST
    oscillation_test: OscillationTest = OSCILLATION_TEST
    standing_wrench_test: StandingWrenchTest = STANDING_WRENCH_TEST
    late_wrench_test: LateWrenchTest = LATE_WRENCH_TEST
    untaken_zero_test: UntakenZeroTest = UNTAKEN_ZERO_TEST
    wrench_step: WrenchStep = WRENCH_STEP
    zero_jump_test: ZeroJumpTest = ZERO_JUMP_TEST
    rim_motion_test: RimMotionTest = RIM_MOTION_TEST
    stated_gravity_test: StatedGravityTest = STATED_GRAVITY_TEST
    unobservable_test: UnobservableTest = UNOBSERVABLE_TEST
