"""Tuned numbers of the set-up of a cell: what each does, its unit and why it is as it is."""

from typing import NamedTuple


class ComparedZero(NamedTuple):
    """
    When the zero of one recording contradicts that of another.

    Attributes
    ----------
    most_moved : float
        Usual drift of a bias within minutes [N].

    """

    most_moved: float = 0.5


class UnstatedPeg(NamedTuple):
    """
    The size of a peg that was not stated.

    Attributes
    ----------
    of_hole : float
        Diameter of the peg as a share of that of the hole [-]: enough clearance for any motion.
        The diameter is reported as not known.

    """

    of_hole: float = 0.99


COMPARED_ZERO = ComparedZero()
UNSTATED_PEG = UnstatedPeg()


class SetupNumbers(NamedTuple):
    """All of them, by subject."""

    compared_zero: ComparedZero = COMPARED_ZERO
    unstated_peg: UnstatedPeg = UNSTATED_PEG
