"""Each contact set by what a wrench that is weighed with it leaves of the reactions."""

import numpy as np
import pytest

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.settings import default_settings
from under_way import placed, press

PRESSED = (1.0, 2.0, -40.0, 0.1, 0.2, 0.0)
# Independent reactions: N_K, N_B1, N_B2; N_K and N_B, of which B1 and B2 have halves; none.
INDEPENDENT = {
    ContactSet.THREE: 3,
    ContactSet.TWO: 2,
    ContactSet.NONE: 0,
    ContactSet.UNKNOWN: 0,
}


@pytest.mark.parametrize("contact_set", ContactSet)
def test_a_wrench_determines_as_many_reactions_as_its_contacts_have(contact_set):
    # Above gamma0 = 0.0633 the rim carries, below it the hole.
    tilt = 0.05 if contact_set is ContactSet.TWO else 0.1
    kalman = placed((tilt, 0.4, -0.3), rates=(-0.1, 0.2, 1.0))
    before = kalman.x.copy(), kalman.P.copy()
    press(kalman, PRESSED, contact_set)
    reactions, _ = kalman.reactions()
    covariance = kalman.mixture.covariance[-3:, -3:]
    wide = (kalman.settings.reaction_prior * kalman.state.load) ** 2
    if not INDEPENDENT[contact_set]:
        np.testing.assert_array_equal(reactions, 0.0)
        np.testing.assert_allclose(covariance, wide * np.eye(3))
        # The mean of the mixture is a sum, so that rounding differs.
        np.testing.assert_allclose(kalman.x, before[0], rtol=1e-12)
        np.testing.assert_allclose(kalman.P, before[1], rtol=1e-9, atol=1e-20)
        return
    stddev = np.sqrt(np.diagonal(covariance))
    correlation = covariance / np.outer(stddev, stddev)
    assert np.linalg.matrix_rank(correlation, tol=1e-6) == INDEPENDENT[contact_set]
    assert (np.diagonal(covariance) < wide).all()
    assert (reactions[1] == pytest.approx(reactions[2])) == (contact_set is ContactSet.TWO)
    # What the contacts carry tells of the tilt; by the symmetry of two, of psi nothing at once.
    changed = kalman.x != before[0]
    assert changed[[0, 3]].all() and (changed.all() or contact_set is ContactSet.TWO)


def test_a_constant_that_is_none_and_modes_without_room_are_refused():
    with pytest.raises(ValueError, match="no constants of the estimator: settlng"):
        default_settings(settlng=0.1)
    with pytest.raises(ValueError, match="4 process-noise modes: at most 3"):
        default_settings(mode_stddev=(1.0,) * 4, mode_time=(1.0,) * 4, mode_rate=(0.0,) * 4)
