"""The truth of a simulated bag on the time of a replay's outputs."""

import numpy as np

from peg_on_hole_ros.bags.truth import Truth
from peg_on_hole_ros.messages.passed_time import Run
from peg_on_hole_ros.report.thinning import thinned
from peg_on_hole_ros.report.tracks import MOST_DRAWN, QUANTITIES, named


def true_columns(
    truth: Truth, runs: list[Run], estimate: dict[str, np.ndarray], most: int = MOST_DRAWN
) -> dict[str, np.ndarray]:
    """
    Return `t` [s] and QUANTITIES as they truly were.

    Parameters
    ----------
    truth : Truth
    runs : list of Run
        Of the outputs.
    estimate : dict of str to ndarray
        Columns of the outputs: the turns of the truth are drawn beside theirs.
    most : int
        Rows to return.

    """
    times, rows = [], []
    for run in runs:
        inside = (run.first_ns <= truth.t_ns) & (truth.t_ns <= run.last_ns)
        if not inside.any():
            continue
        t_ns, values = run.passed(truth.t_ns[inside]), truth.values[inside].copy()
        for i, name in ((1, "psi"), (2, "phi")):
            if name in estimate:
                beside = np.interp(t_ns[0] * 1e-9, estimate["t"], estimate[name])
                values[:, i] += 2 * np.pi * np.round((beside - values[0, i]) / (2 * np.pi))
        times.append(t_ns)
        rows.append(values)
    if not times:
        return {"t": np.empty(0)}
    return named(*thinned(np.concatenate(times), np.concatenate(rows), most), QUANTITIES)
