"""
Tuned numbers of what is identified from whole recordings, each with its reason.

Steps, ranges and useful accuracies of each calibrated quantity are the table of `quantities`.
"""

from typing import NamedTuple


class SteadySliding(NamedTuple):
    """
    Which joint states of a recording slide steadily on three contacts.

    Attributes
    ----------
    half_window : int
        Angles and rates come from local parabolas over so many neighbours on either side [joint
        states].
    quiet_width : float
        Width of the mean over the wrench that leaves its motion without its noise [s]: a guided
        motion changes little within it.
    slow_slip : float
        Below this slip, over the hole's diameter, a contact may stick [1/s].
    rest : float
        Within this time of a contact that may stick friction has no one value [s].
    ample : float
        Of the turning rate that gives the slow slip, what is advised to be recorded [-].
    nearest_tilt : float
        Nearer to the transition than this, over gamma0, two contacts merge, and the split of the
        load between them is lost [-].
    steepest_tilt : float
        Beyond it the peg lies, and the closed forms end [rad].
    strong_quantile : float
        Quantile of the load that counts as strong [-]: the maximum may be an impact.
    load_share : float
        A load below this share of a strong one may be a sensor's bias on a peg in the air [-].
    gap_periods : int
        A silence of so many median periods ends a part [periods].
    shortest_part : int
        A part has at least so many [joint states]: the start of each counts for nothing.

    """

    half_window: int = 10
    quiet_width: float = 0.04
    slow_slip: float = 0.04
    rest: float = 0.025
    ample: float = 1.25
    nearest_tilt: float = 1.03
    steepest_tilt: float = 1.4
    strong_quantile: float = 0.9
    load_share: float = 0.2
    gap_periods: int = 8
    shortest_part: int = 40


class CountedEvents(NamedTuple):
    """
    What of a recording counts in its likelihood.

    Attributes
    ----------
    uncounted_orientations : int
        Orientations at the begin of a part that only determine where it starts [joint states].
    settling : float
        Wrenches count from so long after the begin of a part [s]: the estimator's own settling,
        and what a delay may be.
    knot_spacing : float
        Time between the knots of the smooth motion that a delay moves the angles along [s]: with
        half as much noise looks like motion.
    reaction_prior : float
        Prior standard deviation of a reaction over the load [-]: with a near one, the smaller
        reactions would be likelier.

    """

    uncounted_orientations: int = 8
    settling: float = 0.045
    knot_spacing: float = 0.06
    reaction_prior: float = 100.0


class FirstGuess(NamedTuple):
    """
    How far off a start may be for the estimator that gives the first guess.

    Attributes
    ----------
    friction_stddev : float
        Standard deviation of friction [-].
    clearance_share : float
        Standard deviation of the clearance as a share of it [-].
    small_bias_share : float
        Standard deviation of the bias of the force over the load, in a guess near the start [-].
    large_bias_share : float
        The same in a guess that goes far [-].
    passes : int
        Each pass begins where the one before ended: Jacobians that are evaluated far off lead
        only so near [passes].

    """

    friction_stddev: float = 0.2
    clearance_share: float = 0.2
    small_bias_share: float = 0.05
    large_bias_share: float = 0.2
    passes: int = 2


class Scoring(NamedTuple):
    """
    When Fisher's scoring ends, and how its scores are summed.

    Attributes
    ----------
    most_iterations : int
        Bound of the iterations from the best start [iterations].
    few_iterations : int
        Bound from a second start [iterations]: it is enough to see that it leads elsewhere.
    most_halvings : int
        How often a step that gains nothing is shortened [times].
    shortening : float
        To which share a step that gains nothing is shortened [-].
    least_promise : float
        The search ends where a step promises less [nats]: a tenth of a standard deviation in each
        of ten directions.
    least_gain : float
        The search ends where a step gained less [nats]: ridges of what looks alike are long and
        bent.
    explained_nis : float
        Mean normalised innovation squared, of three degrees of freedom, up to which a run explains
        a recording [-]: a third too large.
    block : int
        So many events in a row are summed to see how much the scores vary [events].

    """

    most_iterations: int = 15
    few_iterations: int = 6
    most_halvings: int = 6
    shortening: float = 0.4
    least_promise: float = 0.05
    least_gain: float = 0.1
    explained_nis: float = 4.0
    block: int = 50


class CalibratedRecording(NamedTuple):
    """
    How much of a recording is calibrated with, and what it has to explain.

    Attributes
    ----------
    most_joint_states : int
        More are left out, evenly [joint states]: they cost time and add little.
    piece : int
        Parts are thinned by pieces of so many [joint states].
    shortest_piece : int
        What is kept of a piece at least [joint states]: the start of each counts for nothing.
    fewest_innovations : int
        A calibration needs so many [joint states]: some blocks of them, by which the intervals
        are widened.
    farther_tilt : float
        With a clearance that is stated too small, tilts nearer than this, over the stated gamma0,
        may be those of a peg in the hole, which no parameters of three contacts explain; gamma0
        goes with the root of the clearance: up to twice the stated one [-].
    unexplained_nis : float
        A recording with a larger mean normalised innovation squared, of three degrees of freedom,
        determines nothing [-]: three times what noise leaves.
    turning_rate : float
        A peg that turned faster both ways turned both ways [rad/s].

    """

    most_joint_states: int = 2000
    piece: int = 1000
    shortest_piece: int = 100
    fewest_innovations: int = 250
    farther_tilt: float = 1.5
    unexplained_nis: float = 9.0
    turning_rate: float = 0.1


class CalibrationSearch(NamedTuple):
    """
    How the likeliest parameters are searched for, and which of them change.

    Attributes
    ----------
    most_friction : float
        Upper limit of friction [-].
    most_delay : float
        Limit of the delay, to both sides [s].
    least_clearance_share : float
        Lower limit of the clearance, over the stated one [-].
    most_climbs : int
        Climbs from one start at most [climbs].
    second_start_loss : float
        A second start is tried where it is no more below the best [nats].
    equal_likelihood : float
        A start that ends lower than the best by less is as likely [nats].
    short_recording_factor : float
        Likelihoods of short recordings differ by so many times what white noise would give [-].
    change_level : float
        Chance that something changes where nothing has to [-].
    freed_at_once : int
        Of what stayed as it was, so many are set free at once, where keeping it costs too much
        likelihood [quantities].
    named_share : float
        Of a direction that is not determined, the share of its longest part from which a quantity
        is named [-].
    usual_runs : int
        Runs of a usual calibration, for its progress [runs].

    """

    most_friction: float = 2.0
    most_delay: float = 0.1
    least_clearance_share: float = 0.05
    most_climbs: int = 4
    second_start_loss: float = 1000.0
    equal_likelihood: float = 2.0
    short_recording_factor: float = 2.0
    change_level: float = 0.05
    freed_at_once: int = 2
    named_share: float = 0.3
    usual_runs: int = 250


class ObservedMotion(NamedTuple):
    """
    What of a motion determines parameters, and which of them look alike.

    Attributes
    ----------
    alike : float
        Correlated by more, two parameters look nearly the same [-].
    shortest_sliding : float
        From less sliding the load of the rim is not known [s]: at a touch-down it is nothing.
    significance : float
        A contact that is slower may stick, and determines nothing [standard deviations].

    """

    alike: float = 0.7
    shortest_sliding: float = 0.1
    significance: float = 3.0


class SpikeTest(NamedTuple):
    """
    Which samples of a recording are outliers.

    Attributes
    ----------
    far : float
        So many times farther off the lines through its neighbours than samples usually are [-]:
        of a million samples of white noise the farthest is 4 times as far off as the median.
    beside : int
        What is usual is that of the whole recording, or of so many on either side [samples]: an
        impact that rings is no outlier.

    """

    far: float = 6.0
    beside: int = 10


class NoiseBlocks(NamedTuple):
    """
    How the noise of a sensor is found in differences of neighbouring samples.

    Attributes
    ----------
    block : int
        The median over blocks of so many ignores the blocks with impacts [samples].
    fewest_blocks : int
        Of fewer there is no median [blocks].
    gap_periods : float
        Samples farther apart than so many median periods are not neighbours [periods].
    floor : float
        What is left of a motion, and of the median's own error, over the noise [-].

    """

    block: int = 100
    fewest_blocks: int = 3
    gap_periods: float = 1.5
    floor: float = 0.01


class LowPassTest(NamedTuple):
    """
    When the noise of the wrench is that of a low-pass.

    Attributes
    ----------
    stretch : int
        Wrenches that are looked at together; the quietest of all such stretches counts
        [wrenches].
    enough : int
        Of fewer stretches nothing is reported [stretches].
    apart : int
        Wrenches so many behind one another are apart [wrenches].
    alike : float
        How many times the noise of those apart is that of neighbours, where they are alike [-].
    steepest : float
        And no more times: no filter of first order makes it eight times [-].
    noisy : float
        Share of the stated noise below which there is none to compare [-].
    kept : int
        The cut-off is found in the last so many stretches [stretches].
    as_quiet : float
        Those whose noise is alike by less than so many times that of the quietest are as quiet
        [-].

    """

    stretch: int = 500
    enough: int = 3
    apart: int = 8
    alike: float = 2.0
    steepest: float = 7.5
    noisy: float = 0.005
    kept: int = 64
    as_quiet: float = 2.0


class StillPoseTest(NamedTuple):
    """
    Which poses of a free peg determine payload and bias.

    Attributes
    ----------
    shortest : float
        A pose lasts at least so long [s].
    still_rate : float
        A peg that turns faster is not still [rad/s].
    least_spread : float
        A spread of gravity's direction that is smaller determines nothing in practice [-].
    center_stddev : float
        The mass centre has to be known to so much [m].
    significance : float
        A payload below so many of its standard deviations has no mass centre [standard
        deviations].
    most_left : float
        Forces of still poses that are so far from a weight and a zero are in other axes, or
        something touches [N]: means over half a second of a noise of 5 N are that near.
    most_compensated : float
        Where a controller takes the weight off, forces of still poses differ by less [N]: a
        payload of 5 kg that it knows to 4 %.

    """

    shortest: float = 0.2
    still_rate: float = 0.01
    least_spread: float = 0.05
    center_stddev: float = 0.005
    significance: float = 4.0
    most_left: float = 0.3
    most_compensated: float = 2.0


class HandPress(NamedTuple):
    """
    What a press of a hand is, which finds the axes of a sensor.

    Attributes
    ----------
    least_force : float
        A press is at least so strong [N].
    released_share : float
        Between two presses the force falls below this share of the least [-].
    firm_share : float
        Where the force is above this share of the press's largest, the hand is firm, and so is its
        direction [-].
    shortest : float
        A press lasts at least so long [s].
    averaged : float
        The force is a mean over so long [s].
    snap : float
        Nearer to a quarter or half turn, a sensor is mounted at it [degrees]: one that is mounted
        with care is off by less than a hand is.
    most_miss : float
        By so much a hand may miss its directions [degrees].

    """

    least_force: float = 5.0
    released_share: float = 0.5
    firm_share: float = 0.7
    shortest: float = 0.3
    averaged: float = 0.05
    snap: float = 20.0
    most_miss: float = 30.0


class InsertedEnd(NamedTuple):
    """
    When the end of a recording shows a peg in its hole.

    Attributes
    ----------
    averaged : float
        The peg's place and axis at the end are means over so long [s].
    aside : float
        The way into the hole is so many clearances wide at most [clearances]: the peg has one
        to each side.
    flex : float
        An arm that is pushed aside by the hole seems to move by up to so much more [m].
    least_depth : float
        The peg has gone in by so many clearances at least [clearances]: it is within a tenth of
        a radian of the hole's axis then.
    most_off : float
        A hole that is stated farther off than that, beyond what the clearance leaves open, is
        stated wrongly [degrees]: what is read from a drawing or taught by hand is nearer.
    most_aside : float
        The same of its place [m].

    """

    averaged: float = 0.1
    aside: float = 2.0
    flex: float = 1e-4
    least_depth: float = 10.0
    most_off: float = 0.5
    most_aside: float = 3e-3


class TouchedPlateFit(NamedTuple):
    """
    Which touches show how a plate lies.

    Attributes
    ----------
    least_spread : float
        Root of the sum of squares of how far the touches lie from one line [m]: of nearer ones an
        arm's errors of 0.1 mm would turn the plate by more than a degree.
    stddev : float
        Of one touch along the plate's normal [m]: an arm comes to a place within some 0.1 mm.
    most_passes : int
        Times that the plate and the lowest points of a leaning peg are found from each other
        [count]; both settle within three.

    """

    least_spread: float = 0.005
    stddev: float = 1e-4
    most_passes: int = 5


STEADY_SLIDING = SteadySliding()
COUNTED_EVENTS = CountedEvents()
FIRST_GUESS = FirstGuess()
SCORING = Scoring()
CALIBRATED_RECORDING = CalibratedRecording()
CALIBRATION_SEARCH = CalibrationSearch()
OBSERVED_MOTION = ObservedMotion()
SPIKE_TEST = SpikeTest()
NOISE_BLOCKS = NoiseBlocks()
LOW_PASS_TEST = LowPassTest()
STILL_POSE_TEST = StillPoseTest()
HAND_PRESS = HandPress()
INSERTED_END = InsertedEnd()
TOUCHED_PLATE = TouchedPlateFit()


class IdentificationNumbers(NamedTuple):
    """All of them, by subject."""

    steady_sliding: SteadySliding = STEADY_SLIDING
    counted_events: CountedEvents = COUNTED_EVENTS
    first_guess: FirstGuess = FIRST_GUESS
    scoring: Scoring = SCORING
    calibrated_recording: CalibratedRecording = CALIBRATED_RECORDING
    calibration_search: CalibrationSearch = CALIBRATION_SEARCH
    observed_motion: ObservedMotion = OBSERVED_MOTION
    spike_test: SpikeTest = SPIKE_TEST
    noise_blocks: NoiseBlocks = NOISE_BLOCKS
    low_pass_test: LowPassTest = LOW_PASS_TEST
    still_pose_test: StillPoseTest = STILL_POSE_TEST
    hand_press: HandPress = HAND_PRESS
    inserted_end: InsertedEnd = INSERTED_END
    touched_plate: TouchedPlateFit = TOUCHED_PLATE
