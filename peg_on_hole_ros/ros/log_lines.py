"""Which counts are logged: what is new for a user, at most once in ten seconds."""

from collections import Counter

# Between two lines of counts [s]; `/diagnostics` has them every second.
LOG_PERIOD = 10.0
# A count is logged again where its share of the messages has grown so many times.
_GROWN = 10.0
# Single ones are usual, and ask nothing of anybody; from this share of the messages on they do.
_USUAL_SHARE = 0.01
_SINGLE = {"joints_gated", "wrench_spike", "joints_dropped_repeated_value", "joints_gap"}
# Each of these comes with a line that names its cause.
_EXPLAINED = {
    "setting_contradicted", "setting_adopted", "contact_doubted", "contact_may_be_plate",
    "reactions_withheld", "joints_noisy", "wrench_noisy", "wrench_stands_still",
    "wrench_saturated", "innovations_too_large",
}  # fmt: skip


class CountLines:
    """Makes lines of counts from one report to the next."""

    def __init__(self) -> None:
        self._since = LOG_PERIOD
        self._messages = 0
        self._window: Counter[str] = Counter()
        self._untold: Counter[str] = Counter()
        self._told: dict[str, float] = {}

    def take(self, new: dict[str, int], messages: int, seconds: float) -> list[str]:
        """
        Take what was counted since the last report; return what is to be logged now.

        Parameters
        ----------
        new : dict of str to int
        messages : int
            How many came meanwhile.
        seconds : float
            Since the last report [s].

        """
        self._window.update(new)
        self._untold.update(new)
        self._messages += messages
        self._since += seconds
        if self._since < LOG_PERIOD:
            return []
        shares = {name: n / max(self._messages, n) for name, n in self._window.items()}
        told = [name for name, share in shares.items() if self._is_news(name, share)]
        self._told |= {name: shares[name] for name in told}
        self._window, self._messages = Counter(), 0
        if not told:
            return []
        self._since = 0.0
        return _lines({name: self._untold.pop(name) for name in told})

    def rest(self, new: dict[str, int]) -> list[str]:
        """Return what is left to log, where no other report will follow."""
        self._untold.update(new)
        left, self._untold = self._untold, Counter()
        return _lines({name: n for name, n in left.items() if name not in _EXPLAINED})

    def _is_news(self, name, share):
        if name in _EXPLAINED or (name in _SINGLE and share < _USUAL_SHARE):
            return False
        return name not in self._told or share >= _GROWN * self._told[name]


def _lines(counts):
    return [
        f"{name.replace('_', ' ')}: {count} time{'' if count == 1 else 's'}"
        for name, count in counts.items()
    ]
