"""The frame_id of the wrench: what comes under another name is another sensor, or other axes."""

from peg_on_hole_ros.safe_text import shown

# More names tell no more.
_NAMES_SHOWN = 4


class WrenchFrames:
    """
    Tells wrenches of the first frame_id from those of others, which are not used.

    An empty frame_id names no frame, and fits any.

    Parameters
    ----------
    follows : bool
        Whether frame_id counts (`wrench.sensor_pose: frame_id`); else all fit.

    """

    def __init__(self, follows: bool) -> None:
        self._follows = follows
        self._first, self._begun_ns = "", 0
        self._others: dict[str, int] = {}
        self._since_ns = 0

    def begin(self, frame: str, t_ns: int) -> None:
        """Take frame_id and stamp [ns] of a wrench; the first that names a frame counts."""
        if not self._first and frame:
            self._first, self._begun_ns = frame, t_ns

    def is_other(self, frame: str) -> bool:
        """Return whether a frame_id is another than the first."""
        return self._follows and bool(frame) and frame != (self._first or frame)

    def note(self, frame: str, t_ns: int) -> None:
        """Note a wrench of another frame_id."""
        if not self._others:
            self._since_ns = t_ns
        if frame in self._others or len(self._others) < _NAMES_SHOWN:
            self._others[frame] = self._others.get(frame, 0) + 1

    def line(self, latest_ns: int | None) -> str:
        """
        Return what there is to say; empty: nothing.

        Parameters
        ----------
        latest_ns : int or None
            Stamp of the latest wrench that was used [ns].

        """
        if not self._others:
            return ""
        others = ", ".join(f"{shown(frame)} ({count})" for frame, count in self._others.items())
        since = f"{(self._since_ns - self._begun_ns) * 1e-9:.3f} s"
        if latest_ns is not None and latest_ns > self._since_ns:
            return (
                f"frame_id is {others} in messages between those of {shown(self._first)}: two "
                "publish on one topic, and the first alone is used; give each a topic of its own"
            )
        return (
            f"frame_id is {others} since {since}, {shown(self._first)} before: these are in "
            "other axes or of another sensor, and not used; have the driver keep one frame, or "
            "restart the node with the frame that is right"
        )
