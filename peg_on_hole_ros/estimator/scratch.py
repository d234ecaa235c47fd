"""Memory of one step of the estimator, as a typed record."""

from typing import Annotated

from peg_on_hole_ros.estimator.accuracy_record import AccuracyScratch
from peg_on_hole_ros.estimator.settings import MOST_MODES
from peg_on_hole_ros.estimator.state import (
    MOST_HYPOTHESES,
    MOST_WIDTH,
    ComponentVector,
    Covariance,
    Values,
)
from peg_on_hole_ros.mechanics.kernel import workspace
from peg_on_hole_ros.typed_record import Floats, Matrix3, Matrix6, Record, Vector3, Vector6

COMPONENTS = MOST_HYPOTHESES * MOST_MODES
# Sigma points of a component: its mean, and two along each column of a root.
_POINTS = 2 * MOST_WIDTH + 1


class PointScratch(Record):
    """
    Memory of methods that take a measurement at points in place of tangents.

    Attributes
    ----------
    x : ndarray, shape (2 (n + 3) + 1, n + 3)
        Sigma points; of particles the first row is the one that is weighed.
    residual : ndarray, shape (2 (n + 3) + 1, 6)
        By how much a measurement is off at each.
    root : ndarray, shape (n + 3, n + 3)
        Cholesky factor of what points are drawn from.
    prior_root : ndarray, shape (n, n)
        That of the covariance before a wrench.
    off : ndarray, shape (n + 3,)
        Of a particle from what it is compared with.
    best : ndarray, shape (3,)
        Reactions of a particle, beyond the prior ones [N].
    total : ndarray, shape (n + 3,)
        Weighted sum of the particles' distances from the tangents' mean.
    squares : ndarray, shape (n + 3, n + 3)
        Weighted sum of their products.
    reactions : ndarray, shape (3, 3)
        Weighted sum of the covariances of the reactions that go with each particle [N^2].

    """

    x: Annotated[Floats, (_POINTS, MOST_WIDTH)]
    residual: Annotated[Floats, (_POINTS, 6)]
    root: Covariance
    prior_root: Covariance
    off: Values
    best: Vector3
    total: Values
    squares: Covariance
    reactions: Matrix3


class Scratch(Record):
    """
    Memory of one step, so that none is allocated; nothing of it outlasts the step.

    Attributes
    ----------
    x, P : ndarray
        Components as they were before the wrench, or as IMM mixing makes them.
    log_likelihood : ndarray, shape (m,)
        Of the last measurement with each component.
    direction_noise_share : ndarray, shape (m,)
        How much friction of unknown direction weighs against the wrench's noise.
    evidence : ndarray, shape (hypotheses,)
        Of each friction hypothesis.
    transition : ndarray, shape (modes, modes)
        Of IMM mixing.
    residual : ndarray, shape (6,)
    jacobian : ndarray, shape (6, n + 3)
        Of the residual: residual = jacobian (truth - mean) + noise.
    noise : ndarray, shape (6, 6)
        Covariance of the residual's noise.
    wrench_noise : ndarray, shape (6, 6)
        The part of the wrench's own noise.
    direction_noise : ndarray, shape (6, 6)
        The part of friction whose direction is unknown.
    by_friction : ndarray, shape (6, 3)
        Derivative of the residual by friction, for one newton of each reaction.
    product_covariance : ndarray, shape (m, 3, 3)
        Of the products of the errors of friction and of each reaction [N^2].
    applied_jacobian : ndarray, shape (6, 11)
        Of the applied wrench, see `applied_wrench`.
    velocity_scale : ndarray, shape (3,)
        Of friction's mean direction at each contact [m/s].
    unexplained : ndarray, shape (3,)
        Share of the friction at each contact that no Jacobian explains.
    cholesky, gain, white : ndarray
        Of an update: Cholesky factor of the innovation's covariance, P times the Jacobian's
        transpose over it, and the whitened residual.
    step : ndarray, shape (n + 3,)
        What is to be added to the mean.
    before, P_before : ndarray
        A component before the first wrench of a contact.
    estimated : ndarray, shape (n + 3,)
        As of the filter, for a wrench: 0 for a value that it does not correct.
    points : PointScratch
        Of sigma points and of particles.
    work : ndarray
        Workspace of the six equations.
    product : ndarray, shape (6, 6)
        Of matrices.
    whitened : ndarray, shape (6, 6)
        Whitened columns, as rows.
    gram : ndarray, shape (3, 3)
        Products of the whitened columns of the reactions.
    column_K : ndarray, shape (6,)
        The column of N_K while friction at K is apart.
    by_diameter : ndarray, shape (6,)
        Derivative of the residual by the peg's diameter.
    accuracy : AccuracyScratch
        Of what stated accuracies make of the reactions.

    """

    x: Annotated[Floats, (COMPONENTS, MOST_WIDTH)]
    P: Annotated[Floats, (COMPONENTS, MOST_WIDTH, MOST_WIDTH)]
    log_likelihood: ComponentVector
    direction_noise_share: ComponentVector
    evidence: Annotated[Floats, (MOST_HYPOTHESES,)]
    transition: Annotated[Floats, (MOST_MODES, MOST_MODES)]
    residual: Vector6
    jacobian: Annotated[Floats, (6, MOST_WIDTH)]
    noise: Matrix6
    wrench_noise: Matrix6
    direction_noise: Matrix6
    by_friction: Annotated[Floats, (6, 3)]
    product_covariance: Annotated[Floats, (COMPONENTS, 3, 3)]
    applied_jacobian: Annotated[Floats, (6, 11)]
    velocity_scale: Vector3
    unexplained: Vector3
    cholesky: Matrix6
    gain: Annotated[Floats, (6, MOST_WIDTH)]
    white: Vector6
    step: Values
    before: Values
    P_before: Covariance
    estimated: Values
    points: PointScratch
    work: Annotated[Floats, workspace().shape]
    product: Matrix6
    whitened: Matrix6
    gram: Matrix3
    column_K: Vector6
    by_diameter: Vector6
    accuracy: AccuracyScratch
