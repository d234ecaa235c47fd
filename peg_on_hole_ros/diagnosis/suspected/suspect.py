"""What a look for a wrongly stated setting is given, and what it finds: the interface of each."""

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample
from peg_on_hole_ros.typed_record import Floats

# Parts of the interface that a look need not have.
PARTS = (
    "take_stamps",
    "take_joints",
    "take_every_wrench",
    "count",
    "take",
    "take_estimate",
    "leave_three_contacts",
    "unsure",
    "withholds",
    "zero_open_ns",
    "take_zero_jump",
    "reaction_errors",
    "explains_joints",
    "joints_variance",
)


class Stated(NamedTuple):
    """
    The settings that are used.

    Attributes
    ----------
    configuration : Configuration
    reduction : WrenchReduction
    taken_off : ndarray, shape (6,)
        What is taken off a wrench as received [N], [N m].

    """

    configuration: Configuration
    reduction: WrenchReduction
    taken_off: np.ndarray


class Standing(NamedTuple):
    """
    A wrench that repeats one value, bit for bit, and is no measurement.

    Attributes
    ----------
    since_ns : int
        Stamp at which the value came first [ns].
    zeros : bool
        Whether all its components are zero.
    turned : bool
        Whether the peg has turned meanwhile.

    """

    since_ns: int
    zeros: bool
    turned: bool


class Instant(NamedTuple):
    """
    A wrench that is looked at, with what is known at its stamp.

    Attributes
    ----------
    sample : WrenchSample
    measured : AngleMeasurement
        The latest orientation.
    standing : Standing or None
        Of a wrench that stands still; None: it does not.
    in_air : bool or None
        Whether the published contact mode is `open`; None: nothing was published.
    beside : bool
        Whether the place shows that the peg stands beside the hole, or that it stood there and has
        not been lifted since.
    misfit : bool
        Whether the innovations in contact are larger than stated.

    """

    sample: WrenchSample
    measured: AngleMeasurement
    standing: Standing | None
    in_air: bool | None
    beside: bool = False
    misfit: bool = False


class Suspect:
    """
    A look for a wrongly stated setting; each derives from this, and has of it what it needs.

    Parameters
    ----------
    stated : Stated

    Attributes
    ----------
    NAME : str
    FINDS : tuple of (str, str)
        See the package.
    OFFLINE : bool
        Whether it takes time that only a replay has.
    ADOPTS : bool
        Whether what fits is used in place of what is stated, where `wrench.adopt_found` is set.
    LASTS : bool
        Whether it looks at wrenches as received alone: other settings do not make it begin anew.
    SPANS_TARE : bool
        Whether it goes on over a tare: it keeps wrenches as received, and their zero is open.
    OF_ZERO : bool
        Whether a tare mends what it finds.
    OF_STAMPS : bool
        Whether it looks at the stamps alone: `inspect` tells what it finds as well.
    WITHOUT_WRENCH : bool
        Whether its finding stands where another look `hides` findings. Others are not given a
        wrench that stands still.
    finding : Finding or None
        What it has found; it stays until the look begins anew, or withdraws it.
    unsure : bool
        Whether nothing sure of contacts can be published now.
    withholds : bool
        Whether the reactions cannot be called determined now, though the mode can be told.
    zero_open_ns : int
        For how long the reading may have been a zero that nobody has taken; 0: it may not [ns].
    reaction_errors : ndarray, shape (settings,), or None
        What each of `records.UNOBSERVABLE_SETTINGS` would cost if it is off [N]; None: nothing is
        known of it now.
    explains_joints : bool
        Whether it has found what is odd about the values of joint states, so that neither their
        noise nor repeated ones are reported.
    joints_variance : float
        Times which the variance of an orientation is that of the stated noise [-].
    hides : bool
        Whether findings of other looks cannot be trusted now.

    """

    NAME: ClassVar[str]
    FINDS: ClassVar[tuple[tuple[str, str], ...]] = ()
    OFFLINE: ClassVar[bool] = False
    ADOPTS: ClassVar[bool] = False
    LASTS: ClassVar[bool] = False
    SPANS_TARE: ClassVar[bool] = False
    OF_ZERO: ClassVar[bool] = False
    OF_STAMPS: ClassVar[bool] = False
    WITHOUT_WRENCH: ClassVar[bool] = False
    finding: Finding | None = None
    hides: bool = False

    def __init__(self, stated: Stated) -> None:
        """Begin to look."""

    @property
    def unsure(self) -> bool:
        """See above."""
        return False

    @property
    def withholds(self) -> bool:
        """See above."""
        return False

    @property
    def zero_open_ns(self) -> int:
        """See above."""
        return 0

    @property
    def reaction_errors(self) -> Floats | None:
        """See above."""
        return None

    @property
    def explains_joints(self) -> bool:
        """See above."""
        return False

    @property
    def joints_variance(self) -> float:
        """See above."""
        return 1.0

    def findings(self) -> Sequence[Finding]:
        """Return what is to be reported; what was reported before is passed over."""
        return () if self.finding is None else (self.finding,)

    def take_zero_jump(self) -> Floats | None:
        """Return by how much the zero has jumped since this was asked last; None: it has not."""
        return None

    def forget_zero(self) -> None:
        """Forget what was found of the zero: a tare has taken it."""

    def restart(self) -> None:
        """Forget what a motion has shown."""

    def restate(self, stated: Stated) -> None:
        """Take other settings and go on, see `LASTS` and `SPANS_TARE`; others begin anew."""

    def take_stamps(self, of_wrench: np.ndarray, t_ns: np.ndarray) -> None:
        """
        Process every message that could be read, in the order in which they came.

        It decides nothing: how many come at once differs between a node and a replay.

        Parameters
        ----------
        of_wrench : ndarray of bool, shape (n,)
            Whether it is a wrench or an orientation.
        t_ns : ndarray of int64, shape (n,)
            Stamps [ns].

        """

    def take_joints(self, t_ns: np.ndarray, positions: np.ndarray) -> None:
        """
        Process every joint state that could be read, in the order in which they came.

        It decides nothing, as for `take_stamps`.

        Parameters
        ----------
        t_ns : ndarray of int64, shape (n,)
            Stamps [ns].
        positions : ndarray, shape (n, joints)
            As received, in the order of `joints.names` [rad or m]; NaN where it was not read.

        """

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process every wrench, in the order in which they came: stamps [ns], and rows (n, 6)."""

    def count(self, wrenches: int) -> None:
        """Count so many wrenches whose estimate was given."""

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process a wrench that is due; `unsure`: whether a look before this one is."""

    def take_estimate(self, t_ns: int, peg: ContactFilter, determined: bool) -> None:
        """Process an estimate on three contacts, at a stamp [ns]; `determined`: its reactions."""

    def leave_three_contacts(self) -> None:
        """Record that the peg is not on three contacts."""


def has_part(member: type[Suspect], part: str) -> bool:
    """Return whether a look has one of PARTS as its own: else it is not called for it."""
    return getattr(member, part) is not getattr(Suspect, part)
