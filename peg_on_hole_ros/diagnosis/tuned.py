"""Tuned numbers of the looks at what is stated of wrench and joints, each with its reason."""

from typing import NamedTuple


class LookTimes(NamedTuple):
    """
    Which wrenches are looked at.

    Attributes
    ----------
    period_ns : int
        Time between two of them [ns].
    first_ns : int
        Time between two of the first: before a contact is detected [ns].
    first : int
        How many those are [wrenches].

    """

    period_ns: int = 20_000_000
    first_ns: int = 4_000_000
    first: int = 10


class HypothesisPriors(NamedTuple):
    """
    What a wrong setting costs before anything is measured.

    Attributes
    ----------
    one_wrong : float
        The first of a hypothesis [nats].
    more_wrong : float
        Each beside it [nats]: two that are wrong at once are rare.

    """

    one_wrong: float = 3.0
    more_wrong: float = 6.0


class WrenchBalance(NamedTuple):
    """
    What a wrench is balanced by, and what of it may be left.

    Attributes
    ----------
    likely_frictions : int
        Frictions that are likely by what is stated [frictions].
    frictions : int
        All frictions that are tried, the likely ones first [frictions]: only the wrench as stated
        may have any other.
    reaction : float
        What a reaction may be [N].
    anything : float
        What a force that nothing explains may be [N].
    unexplained : float
        Share of a load that friction, levers and the peg's shape leave unexplained [-].

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
        Wrenches that are kept [wrenches]: those of one second.
    side : int
        Neighbours on each side that determine the rates of one [wrenches].
    fits : float
        Squares of what is left, of six components, below which a wrench fits [-]: a chi-squared
        variable of 6 degrees of freedom is above it once in 160.
    surprise : float
        Above which it surprises [-]: once in 16.
    nothing : float
        And which nothing explains [-]: it counts no more.
    share : float
        Share of wrenches that surprise from which on other hypotheses are looked at [-].
    direction : float
        A slip has a direction where it is so far above zero [standard deviations].
    steps : int
        Steps from the best of the frictions that are tried to the one that leaves least [steps].

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
        Steps that are tried, the coarsest first; 0: in none [N], [N m].

    """

    sizes: tuple[float, ...] = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.0)


class WrongWrenchTest(NamedTuple):
    """
    When a setting of the wrench is reported.

    Attributes
    ----------
    news : int
        Wrenches of one second have their news in common: together they count as so many
        [wrenches].
    doubt : float
        A hypothesis is likelier than what is stated by so much, for doubt [nats].
    sure : float
        And to be reported [nats].
    apart : float
        And likelier than others, to be distinguished from them [nats].
    enough : int
        Wrenches that have to be looked at [wrenches].
    explained : float
        Share of them that is explained [-].
    halved : float
        Share of what was not balanced that may stay so [-].
    room : float
        How far above the noise it may stay [-].
    often : int
        Wrenches in a row that are not explained after which only each of so many is looked at
        closely [wrenches].
    weight_known : float
        Share of the weight to which it is known [-].
    center_known : float
        To which the mass centre is known [m].
    carried : float
        A holder's acceleration, over the most that it is stated to have [-].
    vague : float
        A zero that may be larger than this share of the weight may be taken for it [-].

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
        It is so many times less than stated [-]: of a kilonewton a thousand times.
    fewest : int
        Wrenches from which on it is suspected [wrenches].
    enough : int
        And from which on it is told [wrenches].

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
        Tilt from which on it does [rad]: pegs are set on at some 0.3.
    near : float
        Its lower end is so near to the hole, over the peg's height [-].
    looks : int
        For so many looks in a row [looks].

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
        Looks that are kept, 20 ms each [looks].
    silence_ns : int
        A silence of so long begins anew [ns].
    fewest_air : int
        Looks at a peg that hangs free, before contact [looks].
    clear : float
        A peg whose lowest point is so far above the rim hangs free, whatever the wrench [m].
    before : int
        Looks before the first contact that count for neither [looks]: touch-down is told late.
    first : int
        Looks in contact before the first judgement, and from one to the next [looks]; twice as
        many as there are by then, where one decided nothing.
    fewest : int
        Rows that slide on the rim, at least [looks].
    most : int
        And at most, of all that there are [looks].
    least_load : float
        A load on the rim, at least [N].
    loud : float
        And so many times the noise [standard deviations].
    above : float
        Tilt over gamma0, at least, of three contacts [-].
    nearest_tilt : float
        Tilt over gamma0 of what is taken for three contacts, at least [-].
    slowest : float
        Below it a slip has no direction [m/s].
    ahead : float
        Time on both sides by which rates of turned axes are taken [s].
    unexplained : float
        Share of a load that friction, levers and inertia leave unexplained [-].
    unexplained_much : float
        And that any cell may have, with gears that bend and contacts that give [-].
    zero_force : float
        Spread of the force's zero, which a tare by wrong settings may have moved so far [N].
    zero_torque : float
        The same of the torque's [N m].
    friction : float
        Spread of friction about the stated one [-].
    nothing : float
        Squares of what is left of a row that nothing explains [-]: it counts no more.
    nothings : tuple of float
        The same on the way there [-]: from afar every row pulls.
    steps : int
        Steps on each [steps].
    shortenings : int
        Shortenings of a step [steps].
    gained : float
        Of less than this in squares the way ends [-].
    delays : tuple of float
        Delays to begin from [s]: between them there may be a hill.
    sure : float
        A kind is likelier than what is stated by so much [nats].
    apart : float
        And than any other [nats].
    held_out : float
        And, found in one half of the contact, in the other [nats].
    explained : float
        It leaves at most so many times the squares of the noise [-].
    least_mass : float
        The least mass that is told [kg].
    least_weight : float
        And as a share of all that hangs [-]: scales are that good.
    near_mass : float
        A mass lies where another is stated, to so much [m].
    least_place : float
        The least way of the sensor that is told [m].
    least_turn : float
        The least turn [rad].
    least_larger : float
        The least change of the logarithm of the clearance [nats].
    least_delay : float
        The least delay [s].
    far : float
        Squares of what is left of a row, of three components, that no noise makes [-].
    often : float
        In so large a share of the rows nothing fits [-].
    looks : int
        In so many judgements in a row [judgements].

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
        Wrenches with one value, bit for bit, after which it is suspected, before any other
        setting can be reported [wrenches].
    reported : int
        And after which it is reported itself [wrenches].
    most : int
        Components that stay together at most, force and torque [components]. Where more do, what
        comes is no sensor's reading: coarsely rounded, or calculated without noise.
    alive : float
        Share of distinct values of a component that is alive [-].
    fine : float
        Least distance of two of its values, over the stated noise [standard deviations]: coarser
        steps are those of a rounding that may hide the noise of the others as well.

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
        Looks that are compared with one another [looks].
    silence_ns : int
        Time from one to the next at most [ns].
    means : int
        Means that stand for the wrenches from one to the next [means].
    every : int
        Looks between two judgements [looks].
    doubled : int
        Twice as many after each that decides nothing, up to so often [times].
    first : float
        Delay that is tried first, to both sides of the stated one [s].
    tried : tuple of float
        Delays that are tried to the likelier side [s].
    likelier : float
        From so much on one is looked at closely [nats].
    sure : float
        It has to be likelier than what is stated by so much [nats].
    apart : float
        And than any other setting [nats].
    least : float
        The least that is reported [s].
    agrees : float
        What one second makes of it and what the seconds before do lie apart by no more
        [standard deviations].
    finest : float
        A second tells it no better than this, whatever its noise: a standard deviation [s].
    known : float
        It is reported once it is known to this: a standard deviation [s].
    unexplained : float
        Share of a load that friction and levers leave unexplained [-].
    nearest_tilt : float
        Nearest tilt, over gamma0 [-].
    slides : float
        Slips are so many times one that may be slow [-].
    changes : float
        The change of a rate, over its most, that makes a delay differ from a turn of the hole
        [-].
    iterations : int
        Iterations of a climb [iterations].

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
        Wrenches that are looked at together [wrenches].
    span_ns : int
        The time that they span at least [ns].
    sure : float
        A mean that is farther off is no noise [standard deviations].
    stated : float
        Nor the zero as it is stated [standard deviations].
    same : float
        Variance, over that of the noise, of what stays the same [-].
    likelier : float
        How much likelier it is [nats].
    along : float
        Share of a force that lies along gravity where it is a weight [-].
    weight_known : float
        Share of the weight to which it is known [-].
    center_known : float
        To which the mass centre is known [m].
    carried : float
        Share of the holder's acceleration that lasts [-].

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
        Stamps that are looked at together [stamps].
    fewest : int
        Of fewer steps between them nothing is told [steps].
    bursts : int
        Pauses between bursts, at least [pauses].
    close : float
        Stamps of one burst are closer than this share of the mean period [-].
    size : int
        Wrenches of a burst, at least [wrenches]: a thread that wakes late makes pairs.
    period_ns : int
        Time from one burst to the next, at least [ns]: less hardly moves a reaction.
    share : float
        Share of the steps and of the bursts that has to be so [-].

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
        Distances between distinct values, at least [distances]: so many are whole multiples of
        the least by chance in one of a million.
    distinct : float
        Distinct values of a joint, at most this share of its messages [-]: slower than a step
        from one message to the next, it comes to each several times.
    off : float
        A distance is a whole number of steps but for so much, and steps of joints that agree to
        this are one grid's [-].
    rounding : float
        Values closer than this are one [rad].

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
        Joint states that are looked at together [messages].
    fewest : int
        Of fewer nothing is told [messages].
    every : int
        It is looked at once in so many looks of 20 ms [looks]: encoders stay what they are.

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
        Joint states that are looked at together [messages]: 0.13 s at 500 Hz, in which a motion
        is a parabola.
    kept_steps : int
        Joint states in which steps of an encoder are looked for [messages].
    rounds : int
        Each message is assigned so many times [rounds].
    fewest : int
        Messages of the rarer motion, at least [messages].
    turns : int
        Changes from one to the other, at least [changes]: a step, and a vibration far below the
        rate of the messages, make fewer.
    clear : float
        The motions are apart by more than so many times what is left of each [-]: halves of one
        normal distribution are by 2.7, those of a sine by 4.1.
    grid : float
        Motions of encoders with steps are apart by more than so many [steps]: a joint between two
        steps toggles.
    every : int
        It is looked at once in so many looks of 20 ms [looks]: who publishes goes on.

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
    When the clocks of wrench and joint states part.

    Attributes
    ----------
    block_ns : int
        Time of a block whose median counts [ns]: as long as many messages are under way.
    fewest : int
        Joint states of a block, at least [joint states].
    blocks : int
        Of fewer nothing is told [blocks].
    most_blocks : int
        Of so many every second one is kept [blocks].
    apart : float
        They have parted by so much, at least [s]: where reactions begin to be off.
    straight : float
        And lie on a line, but for this share of that [-].

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
        Messages that are looked at together [messages].
    around : int
        Messages before and behind a jump, without another [messages].
    fewest : int
        Joint states of these, at least [joint states].
    least_ns : int
        The least jump [ns]: what comes late over a network is less as a rule.
    near : float
        What the stamps of the other input show agrees with the jump but for this share of it [-].
    both_ns : int
        Both clocks jumped back by more: the filter begins anew, and counts it [ns].
    again_ns : int
        A recording that is played again begins within so much of its first stamp [ns].
    settles_ns : int
        Nothing rests on stamps of before so much later [ns].
    most : int
        Steps that are told [steps].

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
        Time that is looked at together [ns]: two frequencies 8 Hz apart are two.
    fewest : int
        Wrenches in it, at least [wrenches].
    stretches : int
        It is told after so many in a row of one frequency [stretches].
    lasts : int
        And is over after so many without it: a touch-down drowns it for a moment [stretches].
    first_bin : int
        The first bin that is looked at [bins]: a motion has the ones below.
    beside : int
        Bins so far apart are none of one line's [bins].
    above : float
        Power of a line, over the median of all bins, at least [-].
    narrow : float
        And over that of the bins beside it [-].
    same : float
        Frequencies that differ by less than this share are one [-].
    counts : float
        Amplitude over the stated noise above which it counts as noise [-]: more than the root of
        two, which is left of any over the noise with it. Slighter, that is not half as much again.
    loud : float
        And above which no contact is sure until then [-].
    mean_s : float
        The load is a mean over whole periods of so long at least [s].
    slight : float
        A load below this share of a loud one is none that is told [-]: of the mean little is
        left of it, and white noise of its size may be a slight contact as well as none.
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
    When what a peg at rest reads at first may be a zero that nobody has taken.

    Attributes
    ----------
    force : float
        A component of the force beyond it is no zero [N]: sensors of collaborative robots are some
        newtons off where nobody has tared them.
    torque : float
        The same of the torque [N m].
    turned : float
        A peg that has turned by so much is not at rest [standard deviations]: 1 mrad at the usual
        0.1 mrad, 6 ms of a closing at 0.16 rad/s.
    recent : int
        The mean of the latest so many looks is compared with those before [looks].
    changed : float
        A load that differs by so much has changed [standard deviations].
    sure : float
        A reading differs from the weight beyond so many deviations of its mean [standard
        deviations].
    least_noise : float
        A sensor whose readings differ by less is simulated, and has no zero [standard deviations
        of the stated noise].
    noise_ns : int
        By then a sensor has shown its noise [ns].
    silence_ns : int
        After a silence that is longer a peg at rest is looked at anew [ns].
    reported_ns : int
        What has been open for so long is reported [ns]: what else a wrench may mean is found
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
    When a wrench that stands still is reported; when it does: `measurements.standing_wrench`.

    Attributes
    ----------
    zeros_ns : int
        Zeros where a weight hangs at the sensor [ns]: with diagnostics of 1 Hz that is soon, and a
        message that was lost is none.
    held_ns : int
        Another value of a sensor with noise [ns]: a driver that bridges a lost packet by the last
        value is in order.

    """

    zeros_ns: int = 150_000_000
    held_ns: int = 500_000_000


class WrenchStep(NamedTuple):
    """
    What a step of the wrench from one message to the next is.

    Attributes
    ----------
    changes : float
        A component that changes by more is looked at [standard deviations of the stated noise, or
        of what is found].
    line : float
        A line is drawn through what is read for so long on both sides [s]: loads go on straight
        for about so long.
    fewest : int
        Through so many at least [wrenches].
    first : int
        So many behind a step show it at first [wrenches].
    less : float
        A sensor that is zeroed reads at most so much of the force before [-]: the rest is what the
        load has changed since the readings whose mean was taken.
    gap : float
        Wrenches that take so many times as long as usual have a gap [-].
    straight : float
        A load that leaves more than so much of a line does not go on straight [standard
        deviations].
    taken : float
        A driver takes the mean of up to so long as its zero [s].
    missed : float
        Share of a step by which lines miss its ends where the load bends [-].
    sure : float
        What is read differs from what it should be beyond so much [standard deviations].

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
    When a step of the wrench is one of the sensor's zero.

    Attributes
    ----------
    kept_ns : int
        Wrenches that are looked at [ns].
    sure : float
        What is read differs from what it should be beyond so much [standard deviations].
    stays_ns : int
        What stays for so long has jumped [ns]: a motion that reverses with 0.3 rad/s^2 has turned
        by 1.5 mrad then.
    looks : int
        Orientations that are kept [looks]: of 0.24 s.
    fewest_looks : int
        So many have to be there on each side of a step [looks].
    turned : float
        A peg that is off from where it would have turned by so much turns otherwise [standard
        deviations].
    rate : float
        Or by so much of what it has turned [-].
    in_air : int
        What a free peg reads is the mean over about so many looks [looks]: a second.
    settles_ns : int
        For so long behind it no contact is told [ns]: until the estimate, which begins anew, has
        told the contacts again.

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
        Orientations that are looked at together [orientations].
    period_ns : int
        So far apart [ns].
    silence_ns : int
        A silence of so long begins anew [ns].
    every : int
        Orientations between two looks [orientations].
    share : float
        A path is off that leaves so much of itself unexplained [-].
    noisy : float
        And so many times the noise [-].
    explained : float
        One that explains it leaves this share of that [-].
    surely : float
        A peg that leans leaves this share of that, or less [-]: a joint's zero leaves more.
    surely_way : float
        And a lower end that is elsewhere this one [-]: joints that are mixed up leave more.
    at_noise : float
        Or so many times the noise [-].
    often : int
        Looks in a row of which one explains it nearly, and none surely [looks].
    apart : float
        And this share of what any other leaves [-].
    least_lean : float
        A hole that leans by less is detected by no motion [rad].
    most_lean : float
        Nor does one that leans by more fit [rad]; nor a peg.
    least_turn : float
        A peg that leans by less in its tool is detected by no motion [rad].
    least_way : float
        A lower end that is nearer to where it is stated is not told [m].
    most_way : float
        Nor one that is so far away: no tool is [m].
    least_larger : float
        The same of the logarithm of the clearance over the stated one [nats].
    most_larger : float
        And of its most [nats]: diameters of chamfers of 1 mm make 4.2 mm of 0.2 mm.
    steps : int
        Steps of the fit, and shortenings of each [steps].
    small : float
        Step for the slopes of the fit [-].

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
        Angle between the two up to which they agree [degree]: a base that stands on a floor, or
        the direction of a hole that was measured by hand, is off by one or two.

    """

    most_off: float = 3.0


class LateWrenchTest(NamedTuple):
    """
    When wrenches of before come once more, and when they are in time again.

    Attributes
    ----------
    kept : int
        Wrenches among which one is looked for [wrenches]: 4 s at 1 kHz.
    fewest : int
        So many in a row have to be those of before, and so many lie between [wrenches]: coarse
        values that toggle come again sooner.
    joints : int
        Joint states in a row that come again as well: a recording is played once more [messages].
    turned : float
        Tilt from one look to the next above which the motion counts [rad].
    fits : int
        They are in time once the motion fits them in so many looks of 20 ms [looks].
    fits_again : int
        Or in so many since it did not, which shows that it would not [looks].

    """

    kept: int = 4096
    fewest: int = 20
    joints: int = 5
    turned: float = 5e-4
    fits: int = 50
    fits_again: int = 3


class UnobservableTest(NamedTuple):
    """
    When what is stated is refuted, and which setting it is stays open.

    Attributes
    ----------
    period_ns : int
        Between two looks [ns]: wrenches between have their news in common.
    refuted : float
        The stated friction has to be refuted by so much [nats].
    looks : int
        In so many looks in a row [looks].

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
