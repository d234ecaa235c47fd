"""
Tuned numbers of the monitor that are the same for every cell, each with its reason.

Those that a cell may state otherwise are parameters (`monitor.*`).
"""

from typing import NamedTuple


class ContactLossAlarm(NamedTuple):
    """
    When the alarm of a contact that is lost rises, and what it names.

    Attributes
    ----------
    warn : float
        Probability that a contact has opened, for a WARN [-].
    error : float
        Probability that a contact has opened, for an ERROR [-].
    slid : float
        A sliding peg counts as being on three contacts after the mode has been published for this
        time [s]. A peg at rest may bounce on one of them; there it takes as long as an alarm is
        held.
    clearly : float
        The alarm names one contact if it has this share of the probability that any has opened
        [-].
    entering : float
        A contact that opens within this time before gamma0 opens on the way into the hole [s].

    """

    warn: float = 0.5
    error: float = 0.95
    slid: float = 0.05
    clearly: float = 0.7
    entering: float = 0.03


class FreePegLoad(NamedTuple):
    """
    Which wrench is more than noise and the motion of a free peg.

    Attributes
    ----------
    room : float
        Limit of the squares of noise alone, over their mean [-].
    jump : float
        A load has changed if its squared distance from the mean is this many times the mean square
        of the noise [-].
    azimuth_stddev : float
        If the azimuth has a larger standard deviation, the peg is upright [rad]: its angular
        momentum, computed from the rates of azimuth and turn, would be noise.
    lift : float
        Factor by which a force out of the hole is divided [-]: such a force accelerates a peg that
        leaves the rim.

    """

    room: float = 3.0
    jump: float = 6.0
    azimuth_stddev: float = 0.1
    lift: float = 3.0


class EvidenceWeights(NamedTuple):
    """
    How evidence moves the probabilities of the contacts' hypotheses.

    Attributes
    ----------
    prior : tuple of float
        Probabilities of the hypotheses before any evidence [-]: nothing touches; all three
        contacts are closed; K, B1 or B2 is open; some other way. A peg that touches soon rests on
        all three.
    most : float
        Largest weight of one piece of evidence [nats]: no outlier decides alone.
    even_nis : float
        Running mean of the normalised innovation squared, of 3 degrees of freedom, at which the
        contact model and "some other way" are equally likely [-]; over 20 corrections its
        standard deviation is 0.5.
    nis_share : float
        Evidence for "some other way" per unit of that mean above `even_nis` [nats].
    most_misfit : float
        Largest evidence for "some other way" [nats].
    retry : float
        Time after which a rejected contact model is tried again [s].

    """

    prior: tuple[float, ...] = (0.2, 0.6, 0.05, 0.05, 0.05, 0.05)
    most: float = 3.0
    even_nis: float = 9.0
    nis_share: float = 0.5
    most_misfit: float = 1.0
    retry: float = 0.05


class CreditedReactions(NamedTuple):
    """
    Which reactions are evidence of contacts at all.

    Attributes
    ----------
    absurd : float
        Reactions beyond this many times the largest that a rim can wedge are rounding errors [-].
    pull : float
        Reactions that pull by more belong to other contacts [standard deviations].

    """

    absurd: float = 10.0
    pull: float = 3.0


class OnePoint(NamedTuple):
    """
    Whether one of two contacts in the hole carries the load alone.

    Attributes
    ----------
    prior : tuple of float
        Probabilities before any evidence of a peg that touches below gamma0 [-]: K alone, B alone,
        both. Most pegs rest on two contacts.
    reaction : float
        Prior standard deviation of a reaction that exists [N]. Of 1, 3, 10 and 20 N, this value
        distinguishes one point from two best: 98 and 99 % of the samples of 60 insertions are
        assigned right.
    tail : float
        Below this distance from zero only the asymptotic tail of the normal distribution is
        evaluated [standard deviations].

    """

    prior: tuple[float, ...] = (0.15, 0.15, 0.7)
    reaction: float = 10.0
    tail: float = -5.0


class PlaceCheck(NamedTuple):
    """
    Whether the measured place of the peg is that of its contacts.

    Attributes
    ----------
    elsewhere : float
        Standard deviation of the place of a peg that does not rest on three contacts [m]: lifted,
        or laid down.
    edge : float
        The closed forms are evaluated above gamma0 by this share, because they end at gamma0 [-].
    step : float
        Step of the tilt for the derivative of the place [rad].
    around : float
        Largest height above the rim of what stands around the hole, such as a plate with clamps
        [m]: a load higher up is attributed to the sensor.
    sure : float
        A peg is in the hole if it is deeper than this, and fits [standard deviations].

    """

    elsewhere: float = 5e-3
    edge: float = 1e-4
    step: float = 1e-6
    around: float = 5e-3
    sure: float = 4.0


class Inserted(NamedTuple):
    """
    Until when a peg that was as deep as is stated counts as inserted.

    Attributes
    ----------
    back : float
        A peg counts as inserted until it has come back by this much, so that the mode of a peg
        that rests at the stated depth does not flicker with the noise of its joints [standard
        deviations of the depth].

    """

    back: float = 2.0


class PlateTest(NamedTuple):
    """
    Whether a load is that of a plate on the lowest point of the peg.

    Attributes
    ----------
    prior : float
        Prior probability of a plate for a peg that may be on the rim or in the hole [-]: most pegs
        touch the hole.
    least : float
        Probabilities of a plate up to this count as zero [-]: they reduce no probability of
        contacts of the hole.
    no_way : float
        Prior probability of a plate for a peg that has come from the air below gamma0, while no
        observation shows that it is in the hole [-].
    steepest : float
        Largest friction of a plate [-]: a force that leans more comes from a wall.
    edge : float
        Radius or chamfer of the lower edge of a peg [m].
    azimuth_stddev : float
        If the azimuth has a larger standard deviation, the lowest point of the peg is not known
        [rad].
    memory : float
        Time in which evidence repeats itself, and over which the load is averaged [s]: while a peg
        is laid on the rim, its load leans like that of a plate for about 0.1 s.
    doubt : float
        Evidence against a plate beyond this counts at once [nats]: noise alone gives less.

    """

    prior: float = 0.005
    least: float = 0.02
    no_way: float = 0.5
    steepest: float = 0.4
    edge: float = 1e-3
    azimuth_stddev: float = 0.3
    memory: float = 0.04
    doubt: float = 2.0


class WallsTest(NamedTuple):
    """
    Whether a load is one that rim and wall cannot carry, by Whitney's diagram.

    Attributes
    ----------
    sure : float
        Friction, tilt and clearance are shifted by this many standard deviations in favour of the
        walls, and so is the load by its noise [standard deviations].
    share : float
        Error of the load as a share of the push [-]: the peg accelerates, and the diagram assumes
        a small tilt.

    """

    sure: float = 2.0
    share: float = 0.1


class WayIn(NamedTuple):
    """
    Whether a peg below gamma0 has a way into the hole.

    Attributes
    ----------
    lasts : float
        Contact with the hole counts as a way into it after this time [s].
    plate : float
        The probability of a plate also has to be at most this [-].

    """

    lasts: float = 0.1
    plate: float = 0.05


class ModeDwell(NamedTuple):
    """
    When a contact mode is declared again.

    Attributes
    ----------
    confirmed : float
        A motion that orientations have refuted is accepted again after it has been consistent for
        this time [s]. A wrong setting is refuted every 25 ms, and must not get a declared mode in
        between.

    """

    confirmed: float = 0.05


class KnownQuantities(NamedTuple):
    """
    When reactions are declared determined, and estimated friction is declared known.

    If friction is too high, reactions are estimated too low and with too small a standard
    deviation. A limit on the standard deviation alone would select wrong reactions.

    Attributes
    ----------
    over_spread : float
        Least ratio of the sum of the three reactions to the standard deviation of each [-]: no
        standard deviation is more than a third of their mean.
    over_friction : float
        Least ratio of the sum of the three reactions to the part of each standard deviation that
        friction causes [-]: no more than a sixth of their mean.
    gives : float
        Compression of loaded surfaces, which changes the clearance [m]: 100 N compress a contact
        of steel by 1 um. Friction that was estimated on the rim has an error of that share of the
        clearance, however long it was estimated.

    """

    over_spread: float = 9.0
    over_friction: float = 18.0
    gives: float = 2e-6


class FrictionStepTest(NamedTuple):
    """
    When friction has stepped.

    Attributes
    ----------
    interval : float
        Friction is compared with its value one to two such intervals before [s]: longer than the
        estimate needs to follow a step.
    least : float
        Least difference [-]: errors of the model change friction by about 0.01.
    significance : float
        Least difference over the uncertainty of both values [standard deviations].
    known_share : float
        Friction is compared only if its standard deviation is at most this share of it [-].

    """

    interval: float = 0.2
    least: float = 0.02
    significance: float = 4.0
    known_share: float = 0.05


class RateTrend(NamedTuple):
    """
    How the trend of a rate is followed.

    Attributes
    ----------
    tremble : float
        White noise of the rates in addition to the trend [rad/s per root of a second]: the
        vibration of a holder.
    jump : float
        Limit of a jump of the rate, as at touch-down and when the peg sticks [squared standard
        deviations]: chance exceeds it once in 2000 times.

    """

    tremble: float = 0.002
    jump: float = 12.0


class FollowedMotion(NamedTuple):
    """
    The motion of a held peg, which moves as smoothly as its holder.

    Attributes
    ----------
    turn_share : float
        Ratio of the process noise of turning to that of tilting, and of the quick tilt to the
        steady one [-].
    longest : float
        Longest time of a forecast [s].
    calm : float
        Time after a jump of the tilt from which on it counts as a motion [s].

    """

    turn_share: float = 10.0
    longest: float = 30.0
    calm: float = 0.01


class TransitionFlag(NamedTuple):
    """
    The flag of the transition, and its forecast.

    Attributes
    ----------
    left : float
        A peg that has been in the air above gamma0 for this time has left the rim [s].
    clearance_share : float
        Least standard deviation of an estimated clearance in a forecast, as a share of the stated
        one [-]: the information of the past motion is correlated with friction and with the motion
        ahead.

    """

    left: float = 0.2
    clearance_share: float = 0.05


class InsertionDepth(NamedTuple):
    """
    When the tilt of a peg in the hole determines its depth.

    Attributes
    ----------
    sure : float
        Tilt and reactions have to be above zero by this much [standard deviations]: a peg that
        leans on one wall may be at any depth.
    surface : float
        Least standard deviation of a diameter of two loaded surfaces [m].

    """

    sure: float = 3.0
    surface: float = 1e-6


class RestInHole(NamedTuple):
    """
    How a peg that is pushed slides down the hole, and whether it rests.

    Attributes
    ----------
    speed : float
        Usual speed of a sliding peg along the hole [m/s].
    changes : float
        Usual acceleration along the hole [m/s^2].
    lasts : float
        Time for which an acceleration lasts [s].
    begins : float
        Prior probability that the peg rests [-]: most pegs are on their way.
    upright : float
        Smaller tilts count as zero [rad].
    least : float
        Least probability of rest and of motion [-]: each may begin at any time.

    """

    speed: float = 0.04
    changes: float = 0.1
    lasts: float = 0.1
    begins: float = 0.25
    upright: float = 1e-6
    least: float = 0.01


class PushMeans(NamedTuple):
    """
    The push on a peg, over what friction can hold; docs/jamming.md, "Stall", has the definition.

    Attributes
    ----------
    quick : float
        Time constant of the quicker of two running means, which show whether the push grows at all
        [s]: slower than its trend, and steadier.
    slow : float
        Time constant of the slower running mean [s].
    more : float
        Least growth of the push, or least excess over the usual push, as a share of what friction
        can carry [-].
    more_stddev : float
        Standard deviation of that share [-].
    usual : float
        Time over which the usual push of a motion is averaged [s].
    moved : float
        Least duration of the motion with whose push the present push is compared [s].
    total_over : float
        Time over which the sum of the reactions is averaged [s].
    edge : float
        The closed forms are evaluated above gamma0 by this share, because they end at gamma0 [-].

    """

    quick: float = 0.01
    slow: float = 0.04
    more: float = 0.15
    more_stddev: float = 0.03
    usual: float = 0.2
    moved: float = 0.03
    total_over: float = 0.01
    edge: float = 1e-4


class WedgingAhead(NamedTuple):
    """
    Where the determinant is evaluated along the way to the hole.

    Attributes
    ----------
    dry_slip : float
        Slip velocity at which dry friction has its full value [m/s]: slower than any motion of a
        cell and faster than rounding errors.
    presliding_slip : float
        Slip velocity at which friction has its full value in the forecast [m/s]: near gamma0 K
        hardly slides, and a slow peg passes where a faster one wedges. Real contacts yield by some
        micrometres before they slide.
    points : int
        Number of tilts ahead at which the determinant is evaluated [places].
    end : float
        Distance of the last of them from gamma0, as a share of gamma0 [-].
    determinant_stddev : float
        Standard deviation of the determinant [-]: real contacts are not rigid.

    """

    dry_slip: float = 1e-9
    presliding_slip: float = 1e-5
    points: int = 6
    end: float = 3e-3
    determinant_stddev: float = 0.03


class StallAhead(NamedTuple):
    """
    The course of push and tilt that leads to a stall.

    A peg on a compliant holder slides where holder and friction balance: its tilt follows the
    holder's program, less what the holder gives way to the push, tilt = program + c push. The
    push is known a hundred times better than the tilt's rate, so c and the push's trend show when
    the closing ends. docs/jamming.md, "Stall", derives it.

    Attributes
    ----------
    changes : float
        Time in which the push can change by what friction can carry [s].
    memory : float
        Time for which the acceleration of the push lasts [s].
    program : float
        Random walk of the rate of the program [rad/s per root of a second].
    gives_way : float
        Prior standard deviation of how far the holder yields under a push as large as what
        friction can carry [rad].
    push_jump : float
        A larger innovation of the push is a jump [squared standard deviations].
    tilt_jump : float
        A larger innovation of the tilt is a jump [squared standard deviations].
    calm : float
        Time after a jump without a forecast [s].

    """

    changes: float = 0.14
    memory: float = 0.2
    program: float = 0.005
    gives_way: float = 0.02
    push_jump: float = 40.0
    tilt_jump: float = 20.0
    calm: float = 0.01


class LoadAhead(NamedTuple):
    """
    The course of reactions that leads to a limit.

    Attributes
    ----------
    changes : float
        Time in which a reaction can change by its own value [s].
    memory : float
        Time for which the acceleration of a reaction lasts [s].
    least : float
        Least value of a reaction in this computation, as a share of its limit, so that a reaction
        can grow from zero [-].
    uncertain : float
        Uncertainty of the forecast, as a share of what the estimated acceleration adds [-].
    jump : float
        A larger innovation of a reaction is a jump [squared standard deviations].
    known : float
        A reaction with a larger standard deviation, as a share of it, corrects no trend [-].
    off : float
        Largest standard deviation of the present reaction that is added to the forecast, as a
        share of the reaction [-].
    nothing : float
        Value that stands for a load that certainly stays below its limit [standard deviations].
    loaded : float
        Time after which the trend of a new load is used [s].

    """

    changes: float = 0.2
    memory: float = 0.1
    least: float = 0.1
    uncertain: float = 0.5
    jump: float = 40.0
    known: float = 1.0 / 3.0
    off: float = 0.1
    nothing: float = -40.0
    loaded: float = 0.015


class StuckInHole(NamedTuple):
    """
    When the load of a peg in the hole is one that jams it, by Whitney's diagram.

    Attributes
    ----------
    beyond_over : float
        Time over which the load beyond the diagram is averaged [s].

    """

    beyond_over: float = 0.01


class PresentState(NamedTuple):
    """
    From which present state the advice is planned.

    Attributes
    ----------
    sure : float
        A turn counts if its rate is this far from zero [standard deviations].
    least_clearance : float
        Least clearance in the plan, over the stated one [-].

    """

    sure: float = 3.0
    least_clearance: float = 0.05


CONTACT_LOSS_ALARM = ContactLossAlarm()
FREE_PEG_LOAD = FreePegLoad()
EVIDENCE_WEIGHTS = EvidenceWeights()
CREDITED_REACTIONS = CreditedReactions()
ONE_POINT = OnePoint()
PLACE_CHECK = PlaceCheck()
INSERTED = Inserted()
PLATE_TEST = PlateTest()
WALLS_TEST = WallsTest()
WAY_IN = WayIn()
MODE_DWELL = ModeDwell()
KNOWN_QUANTITIES = KnownQuantities()
FRICTION_STEP = FrictionStepTest()
RATE_TREND = RateTrend()
FOLLOWED_MOTION = FollowedMotion()
TRANSITION_FLAG = TransitionFlag()
INSERTION_DEPTH = InsertionDepth()
REST_IN_HOLE = RestInHole()
PUSH_MEANS = PushMeans()
WEDGING_AHEAD = WedgingAhead()
STALL_AHEAD = StallAhead()
LOAD_AHEAD = LoadAhead()
STUCK_IN_HOLE = StuckInHole()
PRESENT_STATE = PresentState()


class MonitorNumbers(NamedTuple):
    """All of them, by subject."""

    contact_loss_alarm: ContactLossAlarm = CONTACT_LOSS_ALARM
    free_peg_load: FreePegLoad = FREE_PEG_LOAD
    evidence_weights: EvidenceWeights = EVIDENCE_WEIGHTS
    credited_reactions: CreditedReactions = CREDITED_REACTIONS
    one_point: OnePoint = ONE_POINT
    place_check: PlaceCheck = PLACE_CHECK
    inserted: Inserted = INSERTED
    plate_test: PlateTest = PLATE_TEST
    walls_test: WallsTest = WALLS_TEST
    way_in: WayIn = WAY_IN
    mode_dwell: ModeDwell = MODE_DWELL
    known_quantities: KnownQuantities = KNOWN_QUANTITIES
    friction_step: FrictionStepTest = FRICTION_STEP
    rate_trend: RateTrend = RATE_TREND
    followed_motion: FollowedMotion = FOLLOWED_MOTION
    transition_flag: TransitionFlag = TRANSITION_FLAG
    insertion_depth: InsertionDepth = INSERTION_DEPTH
    rest_in_hole: RestInHole = REST_IN_HOLE
    push_means: PushMeans = PUSH_MEANS
    wedging_ahead: WedgingAhead = WEDGING_AHEAD
    stall_ahead: StallAhead = STALL_AHEAD
    load_ahead: LoadAhead = LOAD_AHEAD
    stuck_in_hole: StuckInHole = STUCK_IN_HOLE
    present_state: PresentState = PRESENT_STATE
