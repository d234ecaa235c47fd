"""A contact that would pull soon after a peg was set down: open, or friction stated too high."""

# A contact that is more probably open than not may have to be believed.
EVEN = 0.5
# A peg that has been on three contacts for so long [s] is: one that would pull after that, opens.
SETTLED = 0.03


class FirstContact:
    """
    Whether friction is to be sought below the stated one before a contact counts as open.

    With a friction stated far too high, the equations of three contacts ask one of them to pull.
    As long as friction has hardly been learnt, and the peg has not settled, that is as likely as
    a contact that has opened, and the estimate is begun anew once, from a low friction. What is
    open is so again soon after.

    Attributes
    ----------
    friction_seems_high : bool
        Until it was `sought`.

    """

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget what was: the peg is about to be set down."""
        self.friction_seems_high = False
        self._settled = False
        self._closed_at: float | None = None

    def sought(self):
        """Take note that friction is being sought below; once is enough."""
        self.friction_seems_high = False
        self._settled = True

    def update(self, t: float, mode: str, opened: float, friction_is_open: bool):
        """
        Take what was found at a time.

        Parameters
        ----------
        t : float
            [s].
        mode : str
            The contact mode that is declared.
        opened : float
            Probability that one contact is open while others carry.
        friction_is_open : bool
            See `ContactFilter.friction_is_open`.

        """
        if mode == "open":
            self.restart()
            return
        if mode == "three_point" and self._closed_at is None:
            self._closed_at = t
        for_long = self._closed_at is not None and t - self._closed_at > SETTLED
        self._settled = self._settled or for_long or not friction_is_open
        self.friction_seems_high = not self._settled and opened > EVEN
