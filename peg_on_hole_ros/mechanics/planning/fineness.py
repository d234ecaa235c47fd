"""How finely a motion is looked for: to be planned, or to be told at once while the peg moves."""

from typing import NamedTuple


class Fineness(NamedTuple):
    """
    Numbers of what is looked at.

    Attributes
    ----------
    frictions : int
        Over six standard deviations; odd.
    closings, turns, tilts : int
        Of the candidates.
    ramp, stage : int
        Samples of a stretch whose rates change, and of one whose rates do not.
    chatter : bool
        Whether it is looked for in all candidates and at all frictions; if not, at three frictions
        in those that are judged with their ramps.
    shares : tuple of float
        Of the allowed probabilities that candidates are asked for, before ramps are looked at.
    tried : int
        How many are looked at for each share.

    """

    frictions: int
    closings: int
    turns: int
    tilts: int
    ramp: int
    stage: int
    chatter: bool
    shares: tuple[float, ...]
    tried: int


PLANNED = Fineness(13, 6, 12, 70, 9, 50, True, (1.0, 0.7, 0.4, 0.1, 0.0), 4)
AT_ONCE = Fineness(7, 2, 8, 16, 5, 14, False, (1.0, 0.1), 1)
