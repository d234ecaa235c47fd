"""Tuned numbers of the set-up of a cell: what each does, its unit and why it is as it is."""

from typing import NamedTuple


class ComparedZero(NamedTuple):
    """
    When the zero of one recording contradicts that of another.

    Attributes
    ----------
    most_moved : float
        So much a zero of usual drift moves within minutes [N].

    """

    most_moved: float = 0.5


class UnstatedPeg(NamedTuple):
    """
    What stands for a peg of which nobody has stated the size.

    Attributes
    ----------
    of_hole : float
        Its diameter as a share of the hole's [-]: room enough for any motion; it is told as not
        known.

    """

    of_hole: float = 0.99


COMPARED_ZERO = ComparedZero()
UNSTATED_PEG = UnstatedPeg()


class SetupNumbers(NamedTuple):
    """All of them, by subject."""

    compared_zero: ComparedZero = COMPARED_ZERO
    unstated_peg: UnstatedPeg = UNSTATED_PEG
