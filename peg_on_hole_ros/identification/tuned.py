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
        Angles and rates come from local parabolas over this many neighbours on either side [joint
        states].
    quiet_width : float
        Width of the mean that removes the noise of the wrench but not its motion [s]: a guided
        motion changes little within it.
    slow_slip : float
        Slip velocity over the diameter of the hole below which a contact may stick [1/s].
    rest : float
        Within this time of a contact that may stick, friction has no single value [s].
    ample : float
        Turning rate that is recommended for a recording, over the rate that gives the slow slip
        [-].
    nearest_tilt : float
        Tilt over gamma0 below which two contacts merge, so that the load on each is not determined
        [-].
    steepest_tilt : float
        Largest tilt [rad]: beyond it the peg is nearly horizontal, and the closed forms end.
    strong_quantile : float
        Quantile of the load that counts as strong [-]: the maximum may be an impact.
    load_share : float
        A load below this share of a strong one may be the bias of the sensor while the peg hangs
        in the air [-].
    gap_periods : int
        A gap of this many median periods ends a part [periods].
    shortest_part : int
        Least length of a part [joint states]: the start of each part is not counted.

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
    Which part of a recording counts in its likelihood.

    Attributes
    ----------
    uncounted_orientations : int
        Orientations at the start of a part that only determine its initial state [joint states].
    settling : float
        Wrenches count from this time after the start of a part [s]: the estimator settles, and the
        joints may be delayed.
    knot_spacing : float
        Time between the knots of the smooth motion along which a delay shifts the angles [s]: with
        half of it, noise looks like motion.
    reaction_prior : float
        Prior standard deviation of a reaction over the load [-]: with a narrower prior, smaller
        reactions would be more likely.

    """

    uncounted_orientations: int = 8
    settling: float = 0.045
    knot_spacing: float = 0.06
    reaction_prior: float = 100.0


class FirstGuess(NamedTuple):
    """
    Uncertainty of the start of the estimator that computes the first guess.

    Attributes
    ----------
    friction_stddev : float
        Standard deviation of friction [-].
    clearance_share : float
        Standard deviation of the clearance as a share of it [-].
    small_bias_share : float
        Standard deviation of the bias of the force over the load, in a guess near the start [-].
    large_bias_share : float
        Standard deviation of the bias of the force over the load, in a guess far from the start
        [-].
    passes : int
        Each pass begins at the result of the last one [passes]: Jacobians that are evaluated far
        from the solution lead only part of the way.

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
        Largest number of iterations from the best start [iterations].
    few_iterations : int
        Largest number of iterations from a second start [iterations]: they show whether it leads
        to another solution.
    most_halvings : int
        How often a step without gain is shortened [times].
    shortening : float
        Factor by which a step without gain is shortened [-].
    least_promise : float
        The search ends when the predicted gain of a step is smaller [nats]: a tenth of a standard
        deviation in each of ten directions.
    least_gain : float
        The search ends when the gain of a step was smaller [nats]: parameters that look alike form
        long, curved ridges of the likelihood.
    explained_nis : float
        Largest mean normalised innovation squared, of three degrees of freedom, with which a run
        explains a recording [-]: a third too large.
    block : int
        Number of consecutive events whose scores are summed, to measure how much the scores vary
        [events].

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
        Joint states beyond this number are left out evenly [joint states]: they cost time and add
        little.
    piece : int
        Parts are thinned in pieces of this length [joint states].
    shortest_piece : int
        Least length of a piece that is kept [joint states]: the start of each piece is not
        counted.
    fewest_innovations : int
        Least number for a calibration [joint states]: several blocks, by which the intervals are
        widened.
    farther_tilt : float
        If the clearance is stated too small, tilts below this, over the stated gamma0, may belong
        to a peg in the hole, which no parameters of three contacts explain [-]. gamma0 varies with
        the square root of the clearance, so this covers up to twice the stated clearance.
    unexplained_nis : float
        A recording with a larger mean normalised innovation squared, of three degrees of freedom,
        determines nothing [-]: noise gives a third of it.
    turning_rate : float
        The peg turned both ways if it turned faster than this in both directions [rad/s].

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
        Limit of the delay, in both directions [s].
    least_clearance_share : float
        Lower limit of the clearance, over the stated one [-].
    most_climbs : int
        Largest number of climbs from one start [climbs].
    second_start_loss : float
        A second start is tried if its likelihood is at most this far below the best [nats].
    equal_likelihood : float
        A start whose result is less than this below the best is equally likely [nats].
    short_recording_factor : float
        Factor by which likelihoods of short recordings differ more than white noise would cause
        [-].
    change_level : float
        Probability that a parameter is reported as changed although it need not be [-].
    freed_at_once : int
        Number of fixed quantities that are freed at once if keeping them fixed costs too much
        likelihood [quantities].
    named_share : float
        In a direction that is not determined, a quantity is named if its component is at least
        this share of the largest one [-].
    usual_runs : int
        Number of runs of a typical calibration, for its progress display [runs].

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
        Two parameters with a higher correlation have nearly the same effect [-].
    shortest_sliding : float
        With a shorter time of sliding the load of the rim is not known [s]: at a touch-down it is
        zero.
    significance : float
        A contact whose slip velocity is nearer to zero may stick, and determines nothing [standard
        deviations].

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
        A sample is an outlier if its distance from the lines through its neighbours is this many
        times the usual distance [-]: of a million samples of white noise, the largest distance is
        4 times the median.
    beside : int
        The usual distance is that of the whole recording, or of this many samples on either side
        [samples]: the ringing after an impact is no outlier.

    """

    far: float = 6.0
    beside: int = 10


class NoiseBlocks(NamedTuple):
    """
    How the noise of a sensor is found in differences of neighbouring samples.

    Attributes
    ----------
    block : int
        Length of the blocks whose median is taken [samples]: the median ignores blocks with
        impacts.
    fewest_blocks : int
        Least number of blocks for a median [blocks].
    gap_periods : float
        Samples farther apart than this many median periods are not neighbours [periods].
    floor : float
        Remaining effect of motion, and of the error of the median, over the noise [-].

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
        Number of wrenches that are compared at once [wrenches]; the quietest of all such parts
        counts.
    enough : int
        Least number of parts for a report [stretches].
    apart : int
        Distance of the wrenches that count as far apart [wrenches].
    alike : float
        A low-pass filter is reported if the noise between distant wrenches is this many times the
        noise between neighbours [-].
    steepest : float
        Largest such ratio [-]: no filter of first order gives eight times.
    noisy : float
        Share of the stated noise below which there is no noise to compare [-].
    kept : int
        Number of the latest parts from which the cut-off is determined [stretches].
    as_quiet : float
        Parts whose ratio is less than this many times that of the quietest one count as quiet too
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
        Least duration of a pose [s].
    still_rate : float
        Largest turning rate of a peg at rest [rad/s].
    least_spread : float
        Least spread of the directions of gravity that determines anything in practice [-].
    center_stddev : float
        Largest standard deviation of the mass centre [m].
    significance : float
        A payload of fewer standard deviations has no mass centre [standard deviations].
    most_left : float
        If forces of still poses differ from a weight and a bias by more, they are in other axes,
        or something touches [N]: means over half a second of a noise of 5 N are that accurate.
    most_compensated : float
        If a controller subtracts the weight, forces of still poses differ by less [N]: a payload
        of 5 kg that the controller has to 4 %.

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
        Least force of a press [N].
    released_share : float
        Between two presses the force falls below this share of the least force [-].
    firm_share : float
        While the force is above this share of the largest force of the press, its direction is
        steady [-].
    shortest : float
        Least duration of a press [s].
    averaged : float
        Time over which the force is averaged [s].
    snap : float
        If a sensor is nearer to a quarter or half turn than this, it is assumed to be mounted
        exactly at it [degrees]: a careful mounting is more accurate than a hand.
    most_miss : float
        Largest error of the direction of a hand [degrees].

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
        Time at the end over which place and axis of the peg are averaged [s].
    aside : float
        Largest width of the way into the hole [clearances]: the peg has one clearance to each
        side.
    flex : float
        An arm that the hole pushes aside seems to move by up to this much more [m].
    least_depth : float
        Least depth of an inserted peg [clearances]: at this depth it is within a tenth of a radian
        of the axis of the hole.
    most_off : float
        A stated direction of the hole with a larger error, beyond what the clearance leaves open,
        is wrong [degrees]: a drawing, or teaching by hand, is more accurate.
    most_aside : float
        A stated place of the hole with a larger error is wrong [m].

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
        Root of the sum of the squared distances of the touches from one line [m]: with a smaller
        one, errors of 0.1 mm of the arm would turn the plate by more than a degree.
    stddev : float
        Standard deviation of one touch along the normal of the plate [m]: an arm reaches a place
        within about 0.1 mm.
    most_passes : int
        How often the plate and the lowest points of a leaning peg are computed from each other
        [count]; both converge within three passes.

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
