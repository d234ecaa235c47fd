"""The noise of orientations as their innovations show it, where it is more than is stated."""

from math import exp, log

from peg_on_hole_ros.mechanics.kernel import compiled

# What white innovations of three values differ by from one to the next, squared and halved.
_WHITE = 6.0


@compiled
def follow_noise(s, o):
    """
    Follow by how much the variance of orientations is more than stated.

    Consecutive innovations are compared: what pushes them one way, as a wrong setting of the
    wrench does, is not noise. All are, whether the filter believes them or not.

    Parameters
    ----------
    s : State
        With the innovation of the last orientation.
    o : Settings

    """
    change = 0.0
    for i in range(3):
        change += (s.innovation[i] - s.innovation_before[i]) ** 2
        s.innovation_before[i] = s.innovation[i]
    # The first after a start has none before it.
    if not change >= 0.0:
        return
    surplus = min(change / _WHITE, o.noise_step) - 1.0 - o.noise_margin / s.noise[0]
    more = log(s.noise[0]) + surplus / o.noise_count
    s.noise[0] = exp(min(max(more, 0.0), log(o.noise_most)))
