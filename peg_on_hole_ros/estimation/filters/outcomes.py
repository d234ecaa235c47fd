"""What becomes of a filter's predictions and corrections, and its reactions."""

from enum import Enum
from typing import NamedTuple


class Correction(Enum):
    """What became of an orientation; the values are advice."""

    USED = "used"
    INFLATED = "used, after the rates' covariance was widened: the motion was not as predicted"
    GATED = "refused: further from the prediction than both covariances allow"
    RESET = "restarted from the measurement: refused too often in a row, or covariance lost"


class Prediction(Enum):
    """What became of a prediction; the values are advice."""

    CONTACT = "three-point contact dynamics"
    SLOW = "constant rates: no slip is told from none, and friction has no direction"
    DOUBTED = "constant rates: innovations of steps lean one way, and some contact slips slowly"
    RUNAWAY = "constant rates: in a rigid world the motion would run away, and the peg is held"
    HELD = "constant rates: the model that is in use leaves inertia out"
    FREE = "constant rates: no contact model is in force"
    FAILED = "constant rates: the contact equations gave no step, as at the singular set"
    LIMITED = "constant rates: no step was found within the evaluations that are allowed"


# The contact equations were to be solved, and were not.
NO_STEP = (Prediction.FAILED, Prediction.LIMITED)


class Reactions(NamedTuple):
    """
    Normal reactions at one estimate.

    Attributes
    ----------
    normal, normal_stddev : tuple of 3 float
        N_K, N_B1, N_B2 [N].
    determinant : float
        Of the six equations over its frictionless value.

    """

    normal: tuple[float, float, float]
    normal_stddev: tuple[float, float, float]
    determinant: float
