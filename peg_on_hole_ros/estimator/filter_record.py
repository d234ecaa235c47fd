"""All memory of a filter as one typed record: scene, settings, state, scratch and estimate."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from peg_on_hole_ros.estimator.accuracy_record import SOURCES, Accuracies
from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import MOST_OPEN, State, StatePlaces, Values
from peg_on_hole_ros.mechanics.kernel import SceneScalars
from peg_on_hole_ros.typed_record import Floats, Matrix6, Record, Vector6

# An array of one FilterRecord: Python hands over an array in half a microsecond, and a record of
# so many fields in some hundred.
FilterMemory = NDArray[np.void]
OpenVector = Annotated[Floats, (MOST_OPEN,)]


class FilterRecord(Record):
    """
    All that an estimate is made of.

    What it depends on from one step to the next stands at the end, from `noise` on, see
    `snapshot`.

    Attributes
    ----------
    scratch : Scratch
    settings : Settings
    scene : ndarray
        As stated, see `scene_of`.
    places : StatePlaces
        Of the open quantities.
    walk : ndarray, shape (n,)
        Variance that each value gains in a second, beside that of the motion.
    bias_walk_in_air : ndarray, shape (6,)
        Variance that the bias gains in a second in the air, beside `walk`.
    estimated : ndarray, shape (n + 3,)
        1 for a value that is estimated; 0 for one that is considered (Schmidt): it widens all
        others, and is not corrected.
    bias_map : ndarray, shape (6, 6)
        What one unit of the sensor's bias adds to a wrench on the peg.
    friction_open : bool
        Whether friction has a spread.
    noise : ndarray, shape (6, 6)
        Covariance of a wrench on the peg.
    accuracies : Accuracies
        As stated, with the load of the last wrench, which snapshots go back to.
    wrench : ndarray, shape (6,)
        The last one on the peg, about its mass centre, peg axes [N], [N m].
    record : Estimate
        All that the last wrench has determined.
    open_mean, open_stddev : ndarray
        What is open at the next start: means and standard deviations.
    start_friction, start_friction_stddev : float
        Friction at the next start, and its standard deviation.
    refused : int
        Orientations that were refused in a row.
    friction_moved : ndarray, shape (SOURCES,)
        By what one standard deviation of each source of `accuracies` has moved friction [-].
    friction_variance, friction_least : float
        Variance of friction after the last wrench, and the least that it has been, as much larger
        as process noise has made it since [-].
    tilt_inflation : ndarray, shape (2,)
        Variance that was added to that of the tilt [rad^2], see `inflate_tilt_variance`.
    state : State

    """

    scratch: Scratch
    settings: Settings
    scene: Annotated[Floats, (len(SceneScalars._fields),)]
    places: StatePlaces
    walk: Values
    bias_walk_in_air: Vector6
    estimated: Values
    bias_map: Matrix6
    friction_open: bool
    noise: Matrix6
    accuracies: Accuracies
    wrench: Vector6
    record: Estimate
    open_mean: OpenVector
    open_stddev: OpenVector
    start_friction: float
    start_friction_stddev: float
    refused: int
    friction_moved: Annotated[Floats, (SOURCES,)]
    friction_variance: float
    friction_least: float
    tilt_inflation: Annotated[Floats, (2,)]
    state: State
