"""Tuned numbers of what becomes of a sample before it is a measurement, each with its reason."""

from typing import NamedTuple


class AngleFloor(NamedTuple):
    """
    How near to the upright the angles about the two axes are distinguished.

    Attributes
    ----------
    least_sine : float
        Sine of the tilt below which the turns about the peg's and the hole's axis are one for
        every sensor [-]: the floor keeps the covariance of psi and phi finite (sigma / 1e-6 is
        thousands of turns).

    """

    least_sine: float = 1e-6


class RepeatedValues(NamedTuple):
    """
    When values that repeat bit for bit under fresh stamps are no measurements.

    Attributes
    ----------
    runs : int
        Runs of one length in a row that make it a rule [runs].
    turned : float
        By so much the peg has turned away from a value that is repeated [standard deviations].
    reported : float
        A value that is repeated for longer while the peg turns is reported [s].

    """

    runs: int = 5
    turned: float = 5.0
    reported: float = 0.05


class StandingWrench(NamedTuple):
    """
    When a wrench that repeats bit for bit, in all six components, is no measurement.

    Attributes
    ----------
    fewest : int
        A value has to come more often in a row [wrenches]: of a sensor whose noise is half of its
        resolution all six components repeat so often once in 1e7 times.
    longer : int
        And so many times more often than this sensor usually repeats values [-].
    kept : float
        Noise is looked for in about so many of the latest values [values].
    turns : int
        In so many of six components steps turn back where a value shows noise [components]: of
        white noise two in three do.
    least_noise : float
        Steps that turn back by less, in stated standard deviations, are no noise [-]: a
        calculated load has rounding errors.
    noisy : float
        Share of the latest values that has to show noise [-].
    lasts : float
        Of a sensor with noise the value has to stay for longer [s]: by then one that is slower
        than its publisher has a new one, and what is not zero is true for a moment.

    """

    fewest: int = 5
    longer: int = 3
    kept: float = 16.0
    turns: int = 3
    least_noise: float = 0.1
    noisy: float = 0.5
    lasts: float = 0.1


class InnovationWindow(NamedTuple):
    """
    What innovations show of settings and of the contact mode.

    Attributes
    ----------
    mode_count : int
        The mean over so many corrections shows whether a contact mode fits [corrections].
    most_against_mode : float
        Against a mode each normalised innovation squared counts as so much at most [-]: one that
        noise has thrown is no other contact, which surprises again and again.
    settings_count : int
        Window of median and drift [corrections]: enough to distinguish `large_median` from the
        median of a chi-squared variable of 3 degrees of freedom, 2.37, by five standard deviations
        of a median (0.19).
    large_median : float
        Median above which normalised innovations squared are too large [-]; of fewer than the
        window it has to be farther above, by the root.
    fewest : int
        Of fewer there is no median [corrections].
    drift : float
        Square of the whitened sum over the window above which innovations lean one way [-]: a
        chi-squared variable of 3 degrees of freedom is above it once in 7e5 windows. Over 11 s of
        a working cycle the largest was 17, with a friction that is not as estimated after each
        turn.

    """

    mode_count: int = 20
    most_against_mode: float = 30.0
    settings_count: int = 200
    large_median: float = 3.3
    fewest: int = 60
    drift: float = 30.0


class PlausibleWrench(NamedTuple):
    """
    Sizes that no sensor in a cell measures: bytes or units of a driver that are wrong.

    Attributes
    ----------
    most_force : float
        Largest force [N].
    most_torque : float
        Largest torque [N m].

    """

    most_force: float = 1e6
    most_torque: float = 1e6


class PlausibleJoints(NamedTuple):
    """
    Bounds of joint states and of the orientation that they give.

    Attributes
    ----------
    orientation_stddev : float
        Floor of the rotation vector's standard deviation, each component [rad]: below what any
        robot resolves. Joints that turn the peg about fewer than three axes would leave a
        covariance that cannot be inverted.
    limit_margin : float
        A joint farther beyond the limits of its description is another joint, or in degrees;
        drivers do report a hair beyond them [rad].
    most_turned : float
        psi or phi of a joint that counts its turns [rad]: beyond, a double is as coarse as an
        encoder.

    """

    orientation_stddev: float = 1e-6
    limit_margin: float = 0.1
    most_turned: float = 1e6


class SaturationTest(NamedTuple):
    """
    When a component of the wrench stands at an end of what the sensor measures.

    Attributes
    ----------
    stays : int
        So many wrenches in a row in which one component has one value, bit for bit, while others
        go on [wrenches].
    fewest_runs : int
        Of so many runs away from the ends the mean is formed [runs]: sensors that round repeat
        values anywhere.
    longest_mean : float
        Mean length of these runs below which the sensor does not round [wrenches].
    small_step : float
        Some values have to differ by no more than this share of the noise, else the sensor rounds
        [standard deviations].

    """

    stays: int = 20
    fewest_runs: int = 20
    longest_mean: float = 1.5
    small_step: float = 0.5


class WrenchNoiseTest(NamedTuple):
    """
    When the noise of the wrench is more than stated.

    Attributes
    ----------
    fewest : int
        It is reported after so many wrenches, once a wrong unit had its time to be detected
        [wrenches].
    largest_share : float
        It is reported up to such a share of the most that is followed [-].
    another_unit : float
        Variances so many times the stated ones are of another unit, and are followed to twice that
        [-]: a contact that chatters has some hundred times. Such a wrench is not used.
    noisy : float
        Variances so many times the stated ones are reported, and are used [-].

    """

    fewest: int = 145
    largest_share: float = 0.75
    another_unit: float = 5e3
    noisy: float = 2.25


class LowPassLag(NamedTuple):
    """
    When a wrench behind a low-pass changes so fast that it lags behind the load.

    Attributes
    ----------
    deviations : float
        A change from one wrench to the next counts beyond so many deviations of its noise
        [standard deviations]: 5 % of changes by noise alone are beyond.
    lowest_cutoff : float
        A cut-off counts as at least this [Hz]: below it no insertion can be seen.

    """

    deviations: float = 2.0
    lowest_cutoff: float = 0.1


ANGLE_FLOOR = AngleFloor()
REPEATED_VALUES = RepeatedValues()
STANDING_WRENCH = StandingWrench()
INNOVATION_WINDOW = InnovationWindow()
PLAUSIBLE_WRENCH = PlausibleWrench()
PLAUSIBLE_JOINTS = PlausibleJoints()
SATURATION_TEST = SaturationTest()
WRENCH_NOISE_TEST = WrenchNoiseTest()
LOW_PASS_LAG = LowPassLag()


class MeasurementNumbers(NamedTuple):
    """All of them, by subject."""

    angle_floor: AngleFloor = ANGLE_FLOOR
    repeated_values: RepeatedValues = REPEATED_VALUES
    standing_wrench: StandingWrench = STANDING_WRENCH
    innovation_window: InnovationWindow = INNOVATION_WINDOW
    plausible_wrench: PlausibleWrench = PLAUSIBLE_WRENCH
    plausible_joints: PlausibleJoints = PLAUSIBLE_JOINTS
    saturation_test: SaturationTest = SATURATION_TEST
    wrench_noise_test: WrenchNoiseTest = WRENCH_NOISE_TEST
    low_pass_lag: LowPassLag = LOW_PASS_LAG
