"""How far estimates are from the truth; with scores of their own for determined reactions."""

from collections.abc import Callable
from math import isfinite, nan, pi, sqrt

import numpy as np

from peg_on_hole_ros.bags.truth import BOUND_STDDEVS, THREE_POINT, TWO_POINT, RecordedTruth
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.number_text import number
from peg_on_hole_ros.records import CONTACTS, SIX_QUANTITIES

# What goes below a table of errors, so that its numbers are read as they are meant.
TABLE_NOTES = (
    "inside 95 % bounds: share of the samples whose error is at most "
    f"{BOUND_STDDEVS:.2f} stated standard deviations; 95 % is right, less means bounds that are "
    "too narrow, more too wide; those of reactions allow for accuracy.*, errors of a sensor and "
    "of parts as they are bought, which a simulated truth does not have"
)
UNDETERMINED = (
    "not determined (reactions_determined = 0): the wrench does not determine these reactions, "
    "as at rest or near wedging; they are no part of the rows above"
)


class ErrorSums:
    """
    Sums over errors of the six quantities.

    Attributes
    ----------
    count : ndarray of int, shape (6,)
        Samples in which each was compared.

    """

    def __init__(self) -> None:
        self.count = np.zeros(6, int)
        self._square, self._stddev, self._mean = np.zeros(6), np.zeros(6), np.zeros(6)
        self._inside = np.zeros(6, int)

    def count_in(
        self, counted: np.ndarray, error: np.ndarray, stddev: np.ndarray, truth: np.ndarray
    ) -> None:
        """Take the errors of one stamp, those alone that are `counted`."""
        self.count += counted
        self._square += np.where(counted, error**2, 0.0)
        self._stddev += np.where(counted, stddev, 0.0)
        self._mean += np.where(counted, truth, 0.0)
        self._inside += counted & (np.abs(error) <= BOUND_STDDEVS * stddev)

    def rmse(self) -> dict[str, float | None]:
        """Return the RMS error by name [rad], [N]; None where nothing could be compared."""
        return self._each(lambda i: sqrt(self._square[i] / self.count[i]))

    def stddev(self) -> dict[str, float | None]:
        """Return the mean predicted standard deviation by name [rad], [N]."""
        return self._each(lambda i: self._stddev[i] / self.count[i])

    def mean(self) -> dict[str, float | None]:
        """Return the mean of the truth where it was compared [rad], [N]."""
        return self._each(lambda i: self._mean[i] / self.count[i])

    def coverage95(self) -> dict[str, float | None]:
        """Return the share of truth inside the 95 % bounds by name."""
        return self._each(lambda i: self._inside[i] / self.count[i])

    def _each(self, of: Callable[[int], float]) -> dict[str, float | None]:
        # A truth that is damaged may be no number, or one that no sum holds.
        found = [float(of(i)) if count else nan for i, count in enumerate(self.count)]
        rows = zip(SIX_QUANTITIES, found, strict=True)
        return {name: value if isfinite(value) else None for name, value in rows}


class Score(ErrorSums):
    """
    Compares estimates with truth one stamp after the other; takes a replay's output as it comes.

    Angles count wherever there is truth. Reactions count where truth is three-point contact with
    known reactions, the estimate declares it, and calls the reactions determined.

    Parameters
    ----------
    truth : RecordedTruth

    Attributes
    ----------
    undetermined : ErrorSums
        Of the reactions that the estimate does not call determined.
    unstated : int
        Samples among these in which it states no number at all.

    """

    def __init__(self, truth: RecordedTruth) -> None:
        super().__init__()
        self.truth = truth
        self.undetermined, self.unstated = ErrorSums(), 0
        self._flag: bool | None = None
        self._flag_right = self._flag_count = 0
        self.rises_ns: list[int] = []

    def take(self, columns: OutputColumns) -> None:
        """Take the outputs of stamps that rise."""
        values = np.hstack([columns["state"][:, :3], columns.normal])
        stddev = np.hstack([columns["state_stddev"][:, :3], columns["normal_stddev"]])
        flags = columns["transition"].tolist()
        rows = zip(columns.t_ns.tolist(), values, stddev, columns.modes, flags, columns.determined)
        for t_ns, value, spread, mode, flag, determined in rows:
            self.row(t_ns, value, spread, mode, flag, bool(determined))

    def row(
        self,
        t_ns: int,
        values: np.ndarray,
        stddev: np.ndarray,
        mode: str,
        flag: bool | None,
        determined: bool = True,
    ) -> None:
        """
        Take one estimate.

        Parameters
        ----------
        t_ns : int
            [ns]
        values, stddev : ndarray, shape (6,)
            gamma, psi, phi [rad], N_K, N_B1, N_B2 [N]; a reaction may be NaN.
        mode : str
            Contact mode as declared.
        flag : bool or None
            Transition as declared.
        determined : bool
            Whether it calls the reactions determined.

        """
        if flag and self._flag is False:
            self.rises_ns.append(t_ns)
        self._flag = flag
        truth = self.truth.at(t_ns)
        if truth is None:
            return
        true_mode = self.truth.mode_at(t_ns)
        error = values - truth
        error[:3] -= 2 * pi * np.round(error[:3] / (2 * pi))
        compared = true_mode == mode == THREE_POINT and bool(np.isfinite(truth[3:]).all())
        stated = bool(np.isfinite(values[3:]).all())
        angles = np.arange(6) < 3
        self.count_in(angles | (compared and stated and determined), error, stddev, truth)
        if compared and not (stated and determined):
            self.undetermined.count_in(~angles & stated, error, stddev, truth)
            self.unstated += not stated
        if flag is not None and true_mode in (THREE_POINT, TWO_POINT):
            self._flag_count += 1
            self._flag_right += flag == (true_mode == TWO_POINT)

    def flag_agreement(self) -> float | None:
        """Return the share of three- and two-point contact in which the flag is right."""
        return self._flag_right / self._flag_count if self._flag_count else None

    def flag_delays(self) -> list[float | None]:
        """
        Return how long after each true transition the flag rose [s]; negative: before it.

        None where it did not rise nearer to this transition than to another.
        """
        true_ns = self.truth.transitions_ns()
        delays: list[float | None] = []
        for t in true_ns:
            nearest = [
                rise for rise in self.rises_ns if min(true_ns, key=lambda s: abs(s - rise)) == t
            ]
            delays.append(min(((r - t) * 1e-9 for r in nearest), key=abs) if nearest else None)
        return delays


def undetermined_content(score: Score) -> dict:
    """Return what the summary has of reactions that are not determined."""
    errors = score.undetermined
    return {
        "samples": int(errors.count[3]) + score.unstated,
        "rmse": {name: errors.rmse()[name] for name in CONTACTS},
        "coverage95": {name: errors.coverage95()[name] for name in CONTACTS},
    }


def score_table(score: Score) -> list[tuple[str, ...]]:
    """Return heading and rows of the comparison as texts; determined reactions come first."""
    rows: list[tuple[str, ...]] = [
        ("", "unit", "RMS error", "mean stddev", "inside 95 % bounds", "samples")
    ]
    rows += [_row(score, i, "") for i in range(6)]
    if score.unstated or score.undetermined.count.any():
        rows += [
            _row(score.undetermined, i, ", not determined", score.unstated) for i in (3, 4, 5)
        ]
    return rows


def _row(errors, i, end, unstated=0):
    name = SIX_QUANTITIES[i]
    label, unit, factor = (name, "mrad", 1e3) if i < 3 else (f"N_{name}{end}", "N", 1.0)
    rmse, stddev, coverage = (
        column[name] for column in (errors.rmse(), errors.stddev(), errors.coverage95())
    )
    samples = str(errors.count[i] + unstated)
    if rmse is None:
        return label, unit, "-", "-", "-", samples
    sizes = number(factor * rmse), number(factor * stddev)
    return label, unit, *sizes, f"{coverage:.1%}", samples


def score_lines(score: Score) -> list[str]:
    """Return what the rows of `score_table` mean, a line each."""
    undetermined = score.unstated or score.undetermined.count.any()
    return [TABLE_NOTES, *([UNDETERMINED] if undetermined else [])]


def flag_lines(score: Score) -> list[str]:
    """Return what there is to say about the transition flag, a line each."""
    agreement = score.flag_agreement()
    lines = []
    # Without a transition a flag that never rises is right by saying nothing.
    said = score.truth.transitions_ns() or score.rises_ns
    if agreement is not None and said:
        lines.append(f"transition flag right in {agreement:.2%} of three- and two-point contact")
    start = int(score.truth.t_ns[0])
    for t, delay in zip(score.truth.transitions_ns(), score.flag_delays()):
        when = f"true transition at {(t - start) * 1e-9:.3f} s: "
        if delay is None:
            lines.append(when + "not flagged")
        else:
            side = "after" if delay >= 0 else "before"
            lines.append(when + f"flagged {abs(delay) * 1e3:.0f} ms {side} it")
    extra = len(score.rises_ns) - sum(delay is not None for delay in score.flag_delays())
    if extra:
        lines.append(f"the flag rose {extra} more time{'s' if extra > 1 else ''}")
    if not score.truth.transitions_ns():
        lines.append("there is no transition in the truth")
    return lines
