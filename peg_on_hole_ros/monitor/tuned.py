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
        The same for an ERROR [-].
    slid : float
        A peg that slides is on three contacts once that has been published for so long [s]. One at
        rest may bounce on one of them: there it takes as long as an alarm is held.
    clearly : float
        One contact is named if it holds this share of the probability that any has opened [-].
    entering : float
        A contact that opens sooner than so before gamma0 opens on the way into the hole [s].

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
        Squares of noise alone stay below so many times their mean [-].
    jump : float
        A load that is off the mean by so many times the mean square of the noise has changed [-].
    azimuth_stddev : float
        An azimuth that is known no better is that of a peg that stands upright [rad]: what the
        rates of azimuth and turn make of its angular momentum is noise.
    lift : float
        A force out of the hole counts as one over so much [-]: a peg that leaves the rim is
        accelerated so.

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
        What contacts change to before any evidence [-]: nothing touches; all three are closed;
        K, B1 or B2 is open; some other way. A peg that touches soon rests on all three.
    most : float
        One piece of evidence counts no more [nats]: no outlier decides alone.
    even_nis : float
        Running mean of the normalised innovation squared, of 3 degrees of freedom, at which the
        contact model and "some other way" are equally likely [-]; over 20 corrections its
        standard deviation is 0.5.
    nis_share : float
        How much of it above that counts for another way [nats].
    most_misfit : float
        It counts no more [nats].
    retry : float
        A model of contact that was given up is tried again after this time [s].

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
        Reactions beyond so many times the largest that a rim can wedge are rounding [-].
    pull : float
        Reactions that pull by more are those of other contacts [standard deviations].

    """

    absurd: float = 10.0
    pull: float = 3.0


class OnePoint(NamedTuple):
    """
    Whether one of two points in the hole carries alone.

    Attributes
    ----------
    prior : tuple of float
        K alone, B alone, both, before any evidence, of a peg that touches below gamma0 [-]: most
        rest on two.
    reaction : float
        What a reaction that is there may be, before it is looked at [N]. Of 1, 3, 10 and 20 N
        this parts one point from two best: 98 and 99 % of the samples of 60 insertions are
        assigned right.
    tail : float
        Beyond so many deviations below zero the tail alone counts [standard deviations].

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
        A peg that does not rest on three contacts is anywhere about there [m]: lifted, or laid
        down.
    edge : float
        The closed forms are taken above gamma0 by this share [-]: they end at gamma0.
    step : float
        Of the tilt, for the slope of the place [rad].
    around : float
        What stands around the hole, as a plate with clamps, may be higher than the rim by so much
        [m]: a load higher up is the sensor's.
    sure : float
        A peg is in the hole where it is deeper than this, and fits [standard deviations].

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
        It counts as inserted until it has come back by so much [standard deviations of the
        depth]: a peg that rests at the stated depth does not flicker by the noise of its joints.

    """

    back: float = 2.0


class PlateTest(NamedTuple):
    """
    Whether a load is that of a plate on the lowest point of the peg.

    Attributes
    ----------
    prior : float
        Probability of a plate, before any load, of a peg that may be on the rim or in the hole
        [-]: most touch the hole.
    least : float
        A probability up to this is none [-]: it takes nothing from contacts of the hole.
    no_way : float
        The same of a peg that has come from the air below gamma0, where nothing shows it in the
        hole [-].
    steepest : float
        Largest friction of a plate [-]: a force that is more aslant is a wall's.
    edge : float
        A lower edge is rounded, or chamfered, by so much [m].
    azimuth_stddev : float
        An azimuth known no better shows no lowest point [rad].
    memory : float
        Time in which evidence repeats itself, and over which the load is averaged [s]: the press
        of a peg that is laid on the rim leans for some 0.1 s as a plate's does.
    doubt : float
        Evidence against a plate beyond this counts at once [nats]: noise shows less of it.

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
        Friction, tilt and clearance may be off by so many of their standard deviations, in favour
        of the walls, and the load by as many of its noise [standard deviations].
    share : float
        Of the push, which an accelerating peg and the diagram's small tilt leave open [-].

    """

    sure: float = 2.0
    share: float = 0.1


class WayIn(NamedTuple):
    """
    Whether a peg below gamma0 has a way into the hole.

    Attributes
    ----------
    lasts : float
        Contact with the hole counts as a way once it has lasted so long [s].
    plate : float
        And once a plate is no more probable than this [-].

    """

    lasts: float = 0.1
    plate: float = 0.05


class ModeDwell(NamedTuple):
    """
    When a contact mode is declared again.

    Attributes
    ----------
    confirmed : float
        A motion that orientations have refuted is believed again once it has gone on for so long
        [s]. A wrong setting is refuted every 25 ms, and must not be declared a mode in between.

    """

    confirmed: float = 0.05


class KnownQuantities(NamedTuple):
    """
    When reactions are declared determined, and friction that was learnt is known.

    With a friction that is too high reactions come out too low, and too sure, so that a limit on
    their spread alone picks those that are wrong.

    Attributes
    ----------
    over_spread : float
        The sum of three reactions is at least so many times any one's spread [-]: no spread is
        more than a third of their mean.
    over_friction : float
        The same of what friction makes of any [-]: no more than half of that.
    gives : float
        Loaded surfaces leave the clearance open by so much [m]: 100 N press a contact of steel in
        by 1 um. Friction that was learnt on the rim is off by that share, however long it was
        learnt.

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
        Friction is compared with that of one to two such intervals ago [s]: longer than the
        estimate needs to follow a step.
    least : float
        By how much it has to differ [-]; what errors of the model do to friction is some 0.01.
    significance : float
        And by how much beside what both are uncertain by [standard deviations].
    known_share : float
        Only a friction that is known to such a share of it is compared [-].

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
        White noise of the rates beside it: what a holder trembles [rad/s per root of a second].
    jump : float
        A jump of the rate, as at touch-down and where the peg sticks [squared standard
        deviations]: 1 of 2000 by chance.

    """

    tremble: float = 0.002
    jump: float = 12.0


class FollowedMotion(NamedTuple):
    """
    The motion of a held peg, which moves as smoothly as its holder.

    Attributes
    ----------
    turn_share : float
        How much quicker turning is than tilting, and the quick tilt than the steady one [-].
    longest : float
        A forecast further ahead has no meaning [s].
    calm : float
        A jump of the tilt is followed for so long before it counts as a motion [s].

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
        A peg that has been in the air above gamma0 for so long has left the rim [s].
    clearance_share : float
        The spread of an estimated clearance is at least this share of the stated one in a forecast
        [-]: what the motion so far shows of it is correlated with friction and with the motion
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
        Tilt and reactions have to be above zero by so much [standard deviations]: a peg that
        leans on one wall may be at any depth.
    surface : float
        No diameter is that of two loaded surfaces to better than this [m].

    """

    sure: float = 3.0
    surface: float = 1e-6


class RestInHole(NamedTuple):
    """
    How a peg that is pushed slides down the hole, and whether it rests.

    Attributes
    ----------
    speed : float
        It slides at about this speed [m/s].
    changes : float
        And changes it by so much [m/s^2].
    lasts : float
        For so long [s].
    begins : float
        A peg of which nothing is known rests with this probability [-]: most are on their way.
    upright : float
        Smaller tilts are none [rad].
    least : float
        Nothing is surer than this probability [-]: rest and motion may begin at any time.

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
        Time of the quicker of two running means, which show whether the push grows at all [s]:
        slower than its trend, and steadier.
    slow : float
        Time of the slower one [s].
    more : float
        A push grows, or is more than usual, by this share of what friction can hold [-].
    more_stddev : float
        It is known to that share [-].
    usual : float
        What push is usual for a motion is its mean over this time [s].
    moved : float
        A push is compared with that of a motion that has lasted this long [s].
    total_over : float
        The sum of the reactions is its mean over this time [s].
    edge : float
        The closed forms are taken above gamma0 by this share [-]: they end at gamma0.

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
    How the determinant is looked at along the way to the hole.

    Attributes
    ----------
    dry_slip : float
        Slip at which dry friction is full [m/s]: slower than any motion a cell makes and faster
        than rounding.
    presliding_slip : float
        Slip at which friction is full ahead [m/s]: near gamma0 K hardly slides, and a slow peg
        creeps through where a faster one wedges. Real contacts give way by some micrometres
        before they slide.
    points : int
        Places on the way [places].
    end : float
        The last of them, above gamma0 as a share [-].
    determinant_stddev : float
        How far the determinant of rigid contact is that of a real one [-].

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
        A push changes within this time by what friction can hold [s].
    memory : float
        Its trend lasts for that [s].
    program : float
        What the program's rate may change by itself [rad/s per root of a second].
    gives_way : float
        How far the holder gives way under a push as large as what friction can hold [rad].
    push_jump : float
        Beyond it a push has jumped [squared standard deviations].
    tilt_jump : float
        Beyond it a tilt has [squared standard deviations].
    calm : float
        Just after a jump nothing leads anywhere [s].

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
        A reaction changes within this time by as much as it is [s].
    memory : float
        What its rate changes lasts for that [s].
    least : float
        It is at least this share of its limit for that, so that one from nothing can grow [-].
    uncertain : float
        A trend goes on as it is but for this share of what its acceleration adds [-].
    jump : float
        Beyond it a reaction has jumped [squared standard deviations].
    known : float
        One that is known to less than this share shows no course [-].
    off : float
        One that is known to less than that share is as far off for a while [-].
    nothing : float
        So far over: certainly not [standard deviations].
    loaded : float
        A trend of the load takes this long to part from its begin [s].

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
        The load beyond the diagram counts by its mean over this time [s].

    """

    beyond_over: float = 0.01


class PresentState(NamedTuple):
    """
    Which present state the advice on the way on is planned from.

    Attributes
    ----------
    sure : float
        A turn counts where it is so far from zero [standard deviations].
    least_clearance : float
        Least clearance, over the stated one [-].

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
