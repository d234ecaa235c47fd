"""What a diagnosis has found."""

from collections.abc import Iterable
from typing import NamedTuple

# Beginning of the text where another clearance fits.
CLEARANCE_OFF = "the clearance is not the stated one: set hole_diameter - peg_diameter to"


class Finding(NamedTuple):
    """
    A setting that the data contradict, and what would fit them.

    Attributes
    ----------
    text : str
        What is wrong, a colon, what to set or to do; then how that is known, behind `; with it`
        or in further sentences. A report has what stands before the colon as its headline.
    found : dict of str to object
        Fields of WrenchInput with the values that fit; empty: there is no such setting.
    of : str
        What it is about: wrench, joints or scene.
    voids : bool
        Whether reactions mean nothing where all is as stated.
    alone : bool
        Whether one setting is wrong; several that fit together are reported, never adopted.
    hint : bool
        Whether it is only the likeliest of what was tried: told where nothing else is found, as
        what else is wrong can look like it.

    """

    text: str
    found: dict[str, object]
    of: str = "wrench"
    voids: bool = False
    alone: bool = True
    hint: bool = False


def listed(values: Iterable[float], decimals: int) -> str:
    """Return values of a setting as a parameters file has them, without a minus zero."""
    return str([round(float(x), decimals) + 0.0 for x in values])
