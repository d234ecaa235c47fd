"""How far stamps of joint states are ahead of the wrench that came last before each of them."""

import numpy as np


class Leads:
    """
    Goes through messages in the order in which they came.

    Where both come at once the way that they took is the same to some milliseconds, whatever it
    is: what their stamps differ by is between the clocks that made them.
    """

    def __init__(self) -> None:
        self._last_ns: int | None = None

    def of(self, of_wrench: np.ndarray, t_ns: np.ndarray) -> np.ndarray:
        """
        Return the wrench before each joint state, and how far that is ahead of it.

        Parameters
        ----------
        of_wrench : ndarray of bool, shape (n,)
        t_ns : ndarray of int64, shape (n,)
            Stamps [ns].

        Returns
        -------
        ndarray of int64, shape (m, 2)
            Stamps of the wrenches and leads [ns]; none of joint states before the first wrench.

        """
        places = np.where(of_wrench, np.arange(len(t_ns)), -1)
        before = np.maximum.accumulate(places) if len(places) else places
        joints = np.flatnonzero(~of_wrench)
        wrench_ns = t_ns[np.maximum(before[joints], 0)]
        first = before[joints] < 0
        if self._last_ns is None:
            joints, wrench_ns = joints[~first], wrench_ns[~first]
        else:
            wrench_ns = np.where(first, self._last_ns, wrench_ns)
        if of_wrench.any():
            self._last_ns = int(t_ns[before[-1]])
        return np.column_stack([wrench_ns, t_ns[joints] - wrench_ns])
