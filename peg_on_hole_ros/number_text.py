"""Numbers with their units as texts: three digits, a prefix in place of a power of ten."""

from math import floor, isfinite, log10

DIGITS = 3
NOT_DETERMINED = "not determined"
# Below so much of a unit its prefixes are used.
_WITH_PREFIX_BELOW = 0.01
# The largest prefix of which a value is so much is taken.
_SHARE_OF_PREFIX = 0.1
# Less than so much of the smallest one is written as zero.
_LEAST = 1e-3
# Prefixes of units that have any, from the largest.
_PREFIXED: dict[str, tuple[tuple[float, str], ...]] = {
    "m": ((1e-3, "mm"), (1e-6, "um")),
    "rad": ((1e-3, "mrad"),),
    "s": ((1e-3, "ms"), (1e-6, "us")),
    "rad/s": ((1e-3, "mrad/s"),),
    "m/s": ((1e-3, "mm/s"), (1e-6, "um/s")),
    "kg": ((1e-3, "g"), (1e-6, "mg")),
    "N": ((1e-3, "mN"),),
    "N m": ((1e-3, "mN m"),),
    "Hz": ((1e-3, "mHz"),),
}


def number(value: float | None, digits: int = DIGITS) -> str:
    """
    Return a number to so many digits, without a power of ten.

    What is no number, or none that is finite, is `NOT_DETERMINED`.
    """
    if value is None or not isfinite(value):
        return NOT_DETERMINED
    if not value:
        return "0"
    places = digits - 1 - floor(log10(abs(value)))
    # Rounding may carry, as of 0.9996 to 1.
    rounded = round(float(value), places)
    text = f"{rounded:.{max(places, 0)}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def quantity(value: float | None, unit: str, digits: int = DIGITS) -> str:
    """
    Return a value with its unit, as `0.28 N`, `0.0354 mrad` or `83 us`.

    Parameters
    ----------
    value : float or None
        In `unit`.
    unit : str
        Empty: the value has none.
    digits : int

    """
    if value is None or not isfinite(value):
        return NOT_DETERMINED
    factor, name = prefixed(value, unit)
    scaled = value / factor
    return f"{'0' if abs(scaled) < _LEAST else number(scaled, digits)} {name}".rstrip()


def prefixed(value: float, unit: str) -> tuple[float, str]:
    """Return factor and name of the unit with the prefix in which a value is written."""
    if abs(value) >= _WITH_PREFIX_BELOW or not value:
        return 1.0, unit
    found = 1.0, unit
    for found in _PREFIXED.get(unit, ()):
        if abs(value) >= _SHARE_OF_PREFIX * found[0]:
            break
    return found


def bounded(
    value: float | None, bound: float | None, unit: str, most: float = float("inf")
) -> str:
    """
    Return a value with its bound, as `464 ± 180 N`.

    Parameters
    ----------
    value, bound : float or None
        In `unit`.
    unit : str
    most : float
        With a larger bound the value is not determined.

    """
    if value is None or bound is None or not isfinite(value):
        return NOT_DETERMINED
    if not isfinite(bound) or bound > most:
        return NOT_DETERMINED
    factor, name = prefixed(max(abs(value), abs(bound)), unit)
    return f"{number(value / factor)} ± {number(bound / factor, 2)} {name}".rstrip()
