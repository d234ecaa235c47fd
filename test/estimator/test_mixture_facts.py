"""What holds for any mixture of Gaussians, whatever is measured."""

from dataclasses import replace

import numpy as np
import pytest

from compiled_beside import ONE_LEVEL, STATED, Compiled, cell_of, run, samples, stated, with_scene
from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from simulated import truth
from tiers import nightly


def recorded(count=400):
    scene = truth("closing_with_slip")
    rows, noise = samples(scene, count=count)
    return with_scene(scene), rows, noise


@pytest.mark.parametrize(("seed", "count"), [(0, 2500), *nightly((0, 9000), (1, 9000), (2, 9000))])
def test_weights_and_covariances_over_a_long_random_run(seed, count):
    """Samples are lost, contacts come and go, now and then a wrench is 25 deviations off."""
    rng = np.random.default_rng(seed)
    recording = truth("working_cycle")
    rows, noise = samples(recording)
    cell = cell_of(with_scene(recording), noise, ("clearance", "bias", "tilt"))
    estimator, last, n = Compiled(cell, 7), None, cell.n
    for k, row in enumerate(rows[:count]):
        if last is None:
            estimator.start(row.q, row.R, *stated(cell))
            last = row.t
            continue
        if rng.random() < 0.1:
            continue
        estimator.predict(row.t - last)
        last = row.t
        if row.q is not None and rng.random() < 0.8:
            estimator.correct(row.q, row.R)
        wild = 5.0 * rng.normal(size=6) * [1, 1, 1, 0.03, 0.03, 0.03]
        u = row.u + (wild if rng.random() < 0.01 else 0.0)
        contacts = {"three_point": 3, "open": 0}.get(recording.mode[k], -1)
        estimator.weigh(u, contacts if rng.random() < 0.99 else -1)
        whole = estimator.mixture
        assert abs(whole.weight.sum() - 1.0) < 1e-12 and whole.weight.min() >= 0.0
        assert np.array_equal(whole.weight.reshape(7, 3).sum(axis=1) > 0.0, whole.alive > 0.0)
        if k % 10:
            continue
        living = [P for P, w in zip(whole.P, whole.weight) if w > 0.0]
        for P in (*living, whole.covariance):
            assert np.isfinite(P).all()
            # To rounding: what is added to both sides of the diagonal is added in other orders.
            own = np.sqrt(np.diagonal(P))
            assert own.min() > 0.0
            correlation = P / np.outer(own, own)
            assert np.abs(correlation - correlation.T).max() < 1e-9
            assert np.linalg.eigvalsh(correlation[:n, :n]).min() > 0.0


def test_a_state_that_is_put_back_goes_on_bit_for_bit():
    scene, rows, noise = recorded()
    cell = cell_of(scene, noise, tuple(STATED))
    first, second = Compiled(cell, 7), Compiled(cell, 7)
    going = run(first, rows)
    for _ in range(120):
        next(going)
    # All that is to come depends on: the other has none of the first's past, nor of its scratch.
    second.memory.state = first.state
    for name in second.scratch.dtype.names:
        second.scratch[name] = np.nan
    last = rows[119].t
    for row in rows[120:]:
        next(going)
        second.predict(row.t - last)
        last = row.t
        if row.q is not None:
            second.correct(row.q, row.R)
        second.weigh(row.u)
        assert first.state.tobytes() == second.state.tobytes()


@pytest.mark.nightly
def test_a_snapshot_of_a_held_peg_is_gone_back_to_bit_for_bit():
    scene, rows, noise = recorded(200)
    peg = ContactFilter(replace(scene, clearance_stddev=1e-5), FilterOptions(), noise)

    def go_on(rows, last):
        for row in rows:
            peg.predict(row.t - last)
            last = row.t
            nis = peg.correct(row.q, row.R)[1] if row.q is not None else 0.0
            peg.weigh(row.u, ContactSet.THREE)
            said = np.frombuffer(peg.record.tobytes(), np.int64)
            yield nis, said, peg.x.copy(), peg.P.copy(), *peg.reactions()

    first = next(k for k, row in enumerate(rows) if row.q is not None)
    peg.start(rows[first].q, rows[first].R)
    list(go_on(rows[first:100], rows[first].t))
    kept = peg.snapshot()
    once = list(go_on(rows[100:], rows[99].t))
    peg.restore(kept)
    again = list(go_on(rows[100:], rows[99].t))
    assert len(once) == 100 and not np.array_equal(once[0][1], once[-1][1])
    for a, b in zip(once, again):
        assert all(np.array_equal(p, q, equal_nan=True) for p, q in zip(a, b))


def test_a_prediction_in_two_halves_is_one_prediction():
    """
    Within a fiftieth of a standard deviation, with one level.

    An acceleration fades by exp(-dt/50 ms) at the end of a step, not within it: of what it adds to
    a rate in a millisecond that is half a percent, and what is left of it adds up to 1.3 %.
    """
    scene, rows, noise = recorded()
    cell = cell_of(scene, noise, **ONE_LEVEL)

    class Halves(Compiled):
        def predict(self, dt):
            super().predict(0.5 * dt)
            super().predict(0.5 * dt)

    apart = []
    for whole, halves in zip(run(Compiled(cell, 1), rows), run(Halves(cell, 1), rows)):
        own = np.sqrt(np.maximum(np.diagonal(whole.covariance), 1e-30))
        apart.append(
            [
                np.abs((whole.mean - halves.mean) / own).max(),
                np.abs(np.sqrt(np.diagonal(halves.covariance)) / own - 1.0).max(),
            ]
        )
    assert np.max(apart) < 0.02
