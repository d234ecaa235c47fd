"""The one error type that impossible input raises, and a remedy that several of them name."""

# How many times its limit a value is, at least, that is taken for one of another unit.
WRONG_PREFIX_RATIO = 5.0


class PegOnHoleError(ValueError):
    """
    Input that cannot be used: the message says value, unit, allowed range and remedy.

    Attributes
    ----------
    exit_code : int
        What the command line returns: 2 for bad arguments or configuration, 3 for an unusable bag.

    """

    exit_code = 2


class BagError(PegOnHoleError):
    """A bag that cannot be read or lacks what the estimator needs."""

    exit_code = 3


class BagDamaged(PegOnHoleError):
    """A bag that is cut off or damaged: what could be read has been used and written."""

    exit_code = 4

    def __init__(self, damage: str) -> None:
        super().__init__(f"{damage}; what lies before has been used")


def wrong_prefix_remedy(value: float, unit: str, low: float, high: float) -> str:
    """
    Return the remedy where a value seems to be in thousandths, as mm for m; else empty.

    A thousandth of it is in range, and it is `WRONG_PREFIX_RATIO` times the limit or more.
    """
    far = (
        value > WRONG_PREFIX_RATIO * high
        if value > high
        else value < -WRONG_PREFIX_RATIO * abs(low)
    )
    if not unit or not far or not low <= value / 1000 <= high:
        return ""
    return f"{value / 1000:g} {unit} would be: the units look slipped by 1000"
