"""Refusal of NaN and infinity in states and wrenches."""

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.errors import PegOnHoleError


def require_finite(name: str, unit: str, value: ArrayLike, parts: int | None = None) -> np.ndarray:
    """
    Return a value as floats, its first axis of a given length.

    Parameters
    ----------
    name, unit : str
        For the message.
    value : array_like
    parts : int, optional
        Length that the first axis must have.

    Raises
    ------
    PegOnHoleError
        Where it is not numbers, not finite, or not of that length.

    """
    try:
        value = np.asarray(value, float)
    except (TypeError, ValueError):
        raise PegOnHoleError(f"{name} = {value!r} is not numbers in {unit}") from None
    if parts is not None and (value.ndim == 0 or value.shape[0] != parts):
        raise PegOnHoleError(
            f"{name} has shape {value.shape}, not ({parts}, ...): components come first"
        )
    if not np.all(np.isfinite(value)):
        where = np.argwhere(~np.isfinite(value))[0]
        shown = value if value.size <= 6 else value[tuple(where)]
        raise PegOnHoleError(
            f"{name} = {shown} {unit} is not finite: give {parts or 'all'} numbers"
        )
    return value
