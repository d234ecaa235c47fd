"""An estimate as one typed record that monitor and messages read."""

from collections.abc import Sequence
from typing import Annotated

from peg_on_hole_ros.estimator.accuracy_record import AccuracyEffect
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, workspace
from peg_on_hole_ros.typed_record import Floats, Matrix3, Matrix6, Record, Vector3, Vector6


class SceneRecord(Record):
    """A scene as `SceneScalars`, with friction and peg diameter as they are estimated."""

    d: float
    D: float
    H_c: float
    gamma0: float
    m: float
    Ie: float
    Iz: float
    f: float
    g_x: float
    g_y: float
    g_z: float


class Motion(Record):
    """
    Angles and rates.

    Attributes
    ----------
    gamma, psi, phi : float
        [rad].
    gamma_rate, psi_rate, phi_rate : float
        [rad/s].
    covariance : ndarray, shape (6, 6)
        In this order.

    """

    gamma: float
    psi: float
    phi: float
    gamma_rate: float
    psi_rate: float
    phi_rate: float
    covariance: Matrix6


class Reactions(Record):
    """
    Normal reactions at K, B1, B2; in the hole B1 and B2 are halves of B.

    Attributes
    ----------
    normal : ndarray, shape (3,)
        [N].
    covariance : ndarray, shape (3, 3)
        [N^2].
    by_friction, by_diameter : ndarray, shape (3,)
        What an error of friction, or of the peg's diameter, makes of them; it lasts. Of one
        standard deviation [N].

    """

    normal: Vector3
    covariance: Matrix3
    by_friction: Vector3
    by_diameter: Vector3


class Slip(Record):
    """Speed of the peg's material point at a contact [m/s], and its variance [m^2/s^2]."""

    speed: float
    variance: float


class Estimate(Record):
    """
    All that is estimated by the last wrench.

    Attributes
    ----------
    scene : SceneRecord
    friction_variance : float
        [-].
    diameter_variance : float
        Of the peg's diameter [m^2].
    motion : Motion
    accelerations : ndarray, shape (3,)
        [rad/s^2].
    reactions : Reactions
    accuracy : AccuracyEffect
        What stated accuracies add to the variances of reactions and friction.
    slips : sequence of Slip
        At K, B1, B2.
    friction_scales : ndarray, shape (3,)
        Velocity scales of friction's mean direction at K, B1, B2 [m/s].
    contacts : ContactSet
        Which the last wrench was weighed with; not determined is `NONE`.
    wrench : ndarray, shape (6,)
        The last wrench on the peg, peg axes, bias taken off [N], [N m].
    wrench_noise : ndarray, shape (6, 6)
        Covariance of a wrench on the peg.
    bias_load : float
        Variance of a carried load by what is not known of the bias [N^2].
    determinant : float
        Of the six equations, over its frictionless value.
    work : ndarray
        Scratch of the kernel.

    """

    scene: SceneRecord
    friction_variance: float
    diameter_variance: float
    motion: Motion
    accelerations: Vector3
    reactions: Reactions
    accuracy: AccuracyEffect
    slips: Annotated[Sequence[Slip], (3,)]
    friction_scales: Vector3
    contacts: ContactSet
    wrench: Vector6
    wrench_noise: Matrix6
    bias_load: float
    determinant: float
    work: Annotated[Floats, workspace().shape]


@compiled
def scene_of(estimate: Estimate) -> SceneScalars:
    """Return the scene of an estimate, with friction and diameter as they are estimated."""
    s = estimate.scene
    return SceneScalars(s.d, s.D, s.H_c, s.gamma0, s.m, s.Ie, s.Iz, s.f, s.g_x, s.g_y, s.g_z)
