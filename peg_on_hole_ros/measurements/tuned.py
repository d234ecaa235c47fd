"""Tuned numbers of what becomes of a sample before it is a measurement, each with its reason."""

from typing import NamedTuple


class AngleFloor(NamedTuple):
    """
    How near to the upright the angles about the two axes are distinguished.

    Attributes
    ----------
    least_sine : float
        Sine of the tilt below which no sensor can distinguish turns about the axes of peg and hole
        [-]: the floor keeps the covariance of psi and phi finite (sigma / 1e-6 is thousands of
        turns).

    """

    least_sine: float = 1e-6


class RepeatedValues(NamedTuple):
    """
    When values that repeat bit for bit under fresh stamps are no measurements.

    Attributes
    ----------
    runs : int
        Number of consecutive runs of equal length after which repeats count as a rule [runs].
    turned : float
        The repeats are no measurements if the peg has turned away from the repeated value by this
        much [standard deviations].
    reported : float
        A value that repeats for longer while the peg turns is reported [s].

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
        A value has to repeat more often than this in a row [wrenches]: for a sensor whose noise is
        half of its resolution, all six components repeat so often once in 1e7 times.
    longer : int
        The value also has to repeat this many times more often than is usual for this sensor [-].
    kept : float
        Number of the latest values in which noise is looked for [values].
    turns : int
        A value shows noise if the steps of this many of the six components reverse [components]:
        in white noise two of three steps do.
    least_noise : float
        Smaller reversing steps, over the stated standard deviation, are not noise [-]: a computed
        load has rounding errors.
    noisy : float
        Share of the latest values that has to show noise [-].
    lasts : float
        If the sensor has noise, the value has to stay for longer [s]: by then a sensor that is
        slower than its publisher has a new value. A value other than zero may be true for a
        moment.

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
        Number of corrections in the mean that shows whether a contact mode fits [corrections].
    most_against_mode : float
        Largest normalised innovation squared that one correction counts as evidence against a mode
        [-]: a single outlier is no other contact, because another contact gives large innovations
        again and again.
    settings_count : int
        Window of median and drift [corrections]: large enough to distinguish `large_median` from
        the median of a chi-squared variable of 3 degrees of freedom, 2.37, by five standard
        deviations of a median (0.19).
    large_median : float
        Median above which normalised innovations squared are too large [-]. If the window is not
        full, the limit is higher, by the square root of the count.
    fewest : int
        Least number of corrections for a median [corrections].
    drift : float
        Square of the whitened sum over the window above which the innovations have a common
        direction [-]: a chi-squared variable of 3 degrees of freedom is above it once in 7e5
        windows. In 11 s of a working cycle, in which the friction after each turn differs from the
        estimate, the largest value was 17.

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
        Floor of the standard deviation of each component of the rotation vector [rad]: below the
        resolution of any robot. Joints that turn the peg about fewer than three axes would
        otherwise leave a singular covariance.
    limit_margin : float
        A joint value farther beyond the limits of the description belongs to another joint or is
        in degrees [rad]; drivers do report values slightly beyond the limits.
    most_turned : float
        Largest psi or phi of a joint that counts its turns [rad]: beyond it, a double is as coarse
        as an encoder.

    """

    orientation_stddev: float = 1e-6
    limit_margin: float = 0.1
    most_turned: float = 1e6


class SaturationTest(NamedTuple):
    """
    When a component of the wrench is at a limit of the sensor.

    Attributes
    ----------
    stays : int
        Number of consecutive wrenches in which one component has the same value, bit for bit,
        while other components change [wrenches].
    fewest_runs : int
        Number of runs away from the ends that are averaged [runs]: a sensor that rounds repeats
        values anywhere in its range.
    longest_mean : float
        Mean length of these runs below which the sensor does not round [wrenches].
    small_step : float
        Some values have to differ by less than this share of the noise [standard deviations];
        otherwise the sensor rounds.

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
        The noise is reported after this many wrenches, when there was time to detect a wrong unit
        [wrenches].
    largest_share : float
        Noise up to this share of the largest variance that the filter can follow is reported [-].
    another_unit : float
        Variances that are this many times the stated ones are another unit, and are followed up to
        twice that [-]: a contact that vibrates has some hundred times the stated variance. Such a
        wrench is not used.
    noisy : float
        Variances that are this many times the stated ones are reported, and are used [-].

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
        A change from one wrench to the next counts if it exceeds this many standard deviations of
        the noise [standard deviations]: noise alone exceeds it in 5 % of the changes.
    lowest_cutoff : float
        Least cut-off frequency in the computation [Hz]: below it no insertion is visible.

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
