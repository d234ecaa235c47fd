"""The estimator by filterpy on the numpy model: slow and readable, what the step answers to."""

import itertools

import numpy as np
from filterpy.common import Q_continuous_white_noise
from filterpy.kalman import IMMEstimator, KalmanFilter
from numpy.typing import ArrayLike

import reference_equations as model
from peg_on_hole_ros.estimator.state import (
    ACCELERATION,
    FRICTION,
    OPEN_BEGIN,
    RATE,
    places_of,
)
from peg_on_hole_ros.estimator.tuned import STILL_TURN
from reference_equations import Cell, Linear

_ANGLES, _RATES, _ACCELERATIONS = slice(0, 3), slice(RATE, RATE + 3), slice(ACCELERATION, 9)


class Component(KalmanFilter):
    """
    One friction with one level of acceleration.

    Parameters
    ----------
    cell : Cell
    level, time, friction_walk : float
        See `Settings`.

    """

    P: np.ndarray

    def __init__(self, cell: Cell, level: float, time: float, friction_walk: float) -> None:
        super().__init__(dim_x=cell.n + 3, dim_z=6)
        self.cell, self.level, self.time, self.dt = cell, level, time, 0.0
        learnt = cell.learnt[FRICTION] and cell.walk[FRICTION]
        self.friction_walk, self.least = friction_walk * bool(learnt), 0.0
        self.on_three = False
        self.along = max(level, cell.settings.mode_stddev[cell.settings.modes // 2])
        self.x = np.zeros(cell.n + 3)

    def predict(self, u: np.ndarray | None = None) -> None:
        """Predict over the time `dt` by filterpy's equations."""
        dt = self.dt
        self.F = np.eye(self.dim_x)
        self.F[_ANGLES, _RATES] = self.F[_RATES, _ACCELERATIONS] = dt * np.eye(3)
        self.F[_ANGLES, _ACCELERATIONS] = dt**2 / 2 * np.eye(3)
        self.F[_ACCELERATIONS, _ACCELERATIONS] = np.exp(-dt / self.time) * np.eye(3)
        s, c = np.sin((self.F @ self.x)[0]), np.cos((self.F @ self.x)[0])
        around = np.array([[0, 0, 0], [0, 1, -c], [0, -c, 1]]) / max(s**2, 1e-8)
        density = np.eye(3) + self.cell.settings.around_axes**2 * around
        driven = Q_continuous_white_noise(3, dt, 2 * self.level**2 / self.time)
        self.Q = np.zeros_like(self.P)
        self.Q[:9, :9] = np.kron(driven, density)
        known = np.arange(FRICTION, self.cell.n)
        self.Q[known, known] = self.cell.walk[FRICTION:] * dt
        self.Q[FRICTION, FRICTION] += self.on_three * self.friction_walk**2 * dt
        super().predict()
        for i in self.still():
            for place in (RATE + i, ACCELERATION + i):
                self.x[place] = 0.0
                self.P[place] = self.P[:, place] = 0.0

    def correct(
        self,
        measured: Linear,
        point: np.ndarray | None = None,
        learnt: np.ndarray | None = None,
        least: float = 0.0,
    ) -> float:
        """
        Correct by a measurement that was made linear at a point, the mean if None is given.

        What is only considered has no share in filterpy's gain; friction has one that leaves its
        variance at least at what is given. Returns the log likelihood.
        """
        x, P, E, R = self.x, self.P, measured.E, measured.R
        self.dim_z, self._I = len(R), np.eye(self.dim_x)
        self.update(measured.residual + E @ (x if point is None else point), R, E)
        share = np.array(self._by_wrench() if learnt is None else learnt)
        told = (self.K @ self.S @ self.K.T)[FRICTION, FRICTION]
        if P[FRICTION, FRICTION] - told < least and told > 0.0:
            above = np.clip((P[FRICTION, FRICTION] - least) / told, 0.0, 1.0)
            share[FRICTION] *= 1 - np.sqrt(1 - above)
        K = share[:, None] * self.K
        self.x = x + K @ self.y
        left = self._I - K @ E
        self.P = left @ P @ left.T + K @ R @ K.T
        self.x[FRICTION] = max(self.x[FRICTION], 0.0)
        # filterpy's own takes S for singular: it holds reactions and torques, 1e-11 apart.
        return -0.5 * (self.y @ self.SI @ self.y + np.linalg.slogdet(self.S)[1])

    def _by_wrench(self):
        learnt = self.cell.learnt.copy()
        learnt[: self.cell.n] *= self.cell.settings.wrench_moves
        return learnt

    def still(self) -> list[int]:
        """Return which angles do not move."""
        settings = self.cell.settings
        return [i for i, moves in ((1, settings.psi_moves), (2, settings.phi_moves)) if not moves]

    def forget_turn(self, i: int) -> None:
        """Let an angle be where an orientation has it."""
        self.P[i] = self.P[:, i] = 0.0
        self.P[i, i] = STILL_TURN.stddev**2

    def forget(self, reaction: float, acceleration: float) -> None:
        """Take reactions as new, and accelerations that never fade; within deviations."""
        new = {self.cell.n: reaction}
        if np.isinf(self.time):
            new[ACCELERATION] = acceleration
        for first, stddev in new.items():
            values = slice(first, first + 3)
            self.P[values] = self.P[:, values] = 0.0
            self.P[values, values] = stddev**2 * np.eye(3)

    def keep_reactions(self) -> None:
        """Keep the covariances of reactions, and of friction with them, as a wrench left them."""
        n = self.cell.n
        self.with_reactions = (self._frictions() @ self.P)[:, n:]
        self.reactions = self.P[n:, n:].copy()

    def _frictions(self):
        at, n = places_of(self.cell.open_quantities).friction_k, self.cell.n
        friction = np.zeros((3, n + 3))
        friction[:, FRICTION] = 1.0
        if at >= 0:
            friction[0, at] = 1.0
        return friction

    def products(self) -> np.ndarray:
        """Return the covariance of the products of the errors of friction and each reaction."""
        own = self._frictions() @ self.P @ self._frictions().T
        # Isserlis.
        return own * self.reactions + self.with_reactions * self.with_reactions.T

    def halve(self, reaction: float) -> None:
        """Let the last two reactions be halves of one."""
        halves = slice(self.cell.n + 1, None)
        self.x[halves] = self.x[halves].mean()
        self.P[halves, halves] = reaction**2 / 4

    def weigh(
        self,
        u: np.ndarray,
        load: float,
        friction_force2: np.ndarray,
        products: np.ndarray,
        contacts: int,
        dt: float,
        passes: int,
        wider: float = 1.0,
    ) -> tuple[float, ...]:
        """
        Correct by the contacts' equations, with the covariance of products.

        Returns log likelihood, the volume that reactions span, doubt of direction, NIS.
        """
        late = max(self.cell.settings.direction_time / max(dt, 1e-4), 1.0)
        look = self.cell, u, load, friction_force2
        x, P = self.x.copy(), self.P.copy()
        for _ in range(passes):
            point = self.x
            if contacts == 3:
                found = model.contact(look[0], point, P, *look[1:])
            else:
                found = model.two_points(look[0], point, P, *look[1:], self.along)
            measured, unknown, turned, by_friction = found
            unknown = unknown + by_friction @ products @ by_friction.T
            least = (turned * max(point[FRICTION], self.cell.scene.friction)) ** 2
            self.least = least
            self.x, self.P = x.copy(), P.copy()
            noise = wider * measured.R + late * unknown
            value = self.correct(Linear(measured.residual, measured.E, noise), point, least=least)
        doubt = np.trace(np.linalg.solve(wider * measured.R, unknown))
        by_reactions = measured.E[:, self.cell.n :][:, :contacts]
        seen = by_reactions.T @ np.linalg.solve(measured.R, by_reactions)
        volume = 0.5 * np.linalg.slogdet(seen)[1]
        return value, volume, doubt, self.y @ self.SI @ self.y


class ReferenceEstimator:
    """
    A mixture of components, as the compiled step has it.

    Parameters
    ----------
    cell : Cell
    frictions : int
        How many are followed.

    Attributes
    ----------
    frictions : list of list of Component
        Of each friction its levels.
    weight : ndarray, shape (frictions, levels)
    alive : ndarray of bool, shape (frictions,)

    """

    def __init__(self, cell: Cell, frictions: int) -> None:
        self.cell, self.told = cell, 1.0
        self.levels = int(cell.settings.modes)
        settings = cell.settings
        modes = [of[: self.levels] for of in (settings.mode_stddev, settings.mode_time)]
        modes.append([0.0] * (self.levels - 1) + [settings.top_friction_walk * (self.levels > 1)])
        self.frictions = [[Component(cell, *of) for of in zip(*modes)] for _ in range(frictions)]
        self.weight = np.zeros((frictions, self.levels))
        self.alive = np.ones(frictions, bool)
        self.load, self.friction_force2, self.spiked = None, np.zeros(3), 0
        self.noises: list = [1.0, 1.0]
        self.innovation: np.ndarray | None = None
        self.orientations: list[np.ndarray] = []
        self.since_start, self.since_wrench, self.in_contact = 0.0, 0.0, False
        self.on_three = False

    def start(
        self,
        q: np.ndarray,
        R: np.ndarray,
        rate_stddev: float,
        friction: float,
        friction_stddev: float,
        open_mean: ArrayLike,
        open_stddev: ArrayLike,
    ) -> None:
        """Start from an orientation; parameters as for `start.start_mixture`."""
        o, several = self.cell.settings, len(self.frictions) > 1
        at = np.linspace(-o.reach, o.reach, len(self.frictions)) if several else np.zeros(1)
        width = 0.5 * (at[1] - at[0]) if several else 1.0
        values = np.maximum(friction + at * friction_stddev, 0.0)
        self.alive = values > 0.0
        self.alive[-1] = True
        own = np.exp(-0.5 * at**2) * self.alive
        self.weight = np.tile(own[:, None] / self.levels, self.levels)
        if several and self.levels > 1 and o.top_waits:
            self.weight[:, -1] = 1e-9 * own
        self.weight /= self.weight.sum()
        variances = np.repeat(np.square([rate_stddev, self._untold()]), 3)
        for f, levels in zip(values, self.frictions):
            for component in levels:
                n = self.cell.n
                component.x = np.concatenate([q, np.zeros(6), [f], open_mean, np.zeros(3)])
                component.P = np.zeros((n + 3, n + 3))
                component.P[_ANGLES, _ANGLES] = R
                rest = [*variances, (width * friction_stddev) ** 2, *np.square(open_stddev)]
                component.P[range(RATE, n), range(RATE, n)] = rest
                self._share_offsets(component, q, R)
        self.told, self.load, self.in_contact = 1.0, None, False
        self.spiked, self.start_rates2, self.innovation = 0, rate_stddev**2, None
        self.since_start = self.since_wrench = 0.0
        self.air: list[list] = [[]]

    def _untold(self):
        """Return the deviation of accelerations that no wrench has told of."""
        o = self.cell.settings
        return min(o.mode_stddev[max(self.levels - 2, 0)], 1.0 / o.settling)

    def _share_offsets(self, component, q, R):
        """Let the angles be as uncertain as tilt and delay leave them."""
        n, P = self.cell.n, component.P
        measured = model.orientation(self.cell, component.x, q, R)
        E, spread = measured.E[:, OPEN_BEGIN:n], P[OPEN_BEGIN:n, OPEN_BEGIN:n].copy()
        P[_ANGLES, _ANGLES] += E @ spread @ E.T
        P[_ANGLES, OPEN_BEGIN:n] = -E @ spread
        P[OPEN_BEGIN:n, _ANGLES] = P[_ANGLES, OPEN_BEGIN:n].T
        at = places_of(self.cell.open_quantities).delay
        if at >= 0:
            delay = P[at, at]
            P[_ANGLES, _ANGLES] += delay * np.diag(np.diagonal(P)[_RATES])
        component.x[_ANGLES] += measured.residual

    def predict(self, dt: float) -> None:
        """Mix the levels by filterpy's interacting multiple models, and move all on by dt [s]."""
        self.since_start += dt
        self.since_wrench += dt
        for g, levels in self._living():
            for component in levels:
                component.dt, component.on_three = dt, self.on_three
            if self.levels == 1:
                levels[0].predict()
                continue
            held = self.weight[g].sum()
            mixture = IMMEstimator(levels, self.weight[g] / held, self._changes(min(dt, 0.002), g))
            mixture.predict()
            self.weight[g] = held * mixture.cbar

    def _living(self):
        return [(g, levels) for g, levels in enumerate(self.frictions) if self.alive[g]]

    def _changes(self, time, g):
        """Return the probabilities of changes from a level (row) to another, shape (m, m)."""
        o, m = self.cell.settings, self.levels
        M = time * (
            np.triu(np.tile(o.mode_rate[:m], (m, 1)), 1)
            + (o.mode_rate[1] if m > 1 else 0.0) * np.tri(m, k=-1)
        )
        if o.top_waits and self.alive.sum() > 1:
            M[:, -1] = 0.0
        if self.weight[g, -1] < o.least_inherited * self.weight[g].sum():
            M[-1] = 0.0
        return M + np.diag(1 - M.sum(axis=1))

    def correct(self, q: np.ndarray, R: np.ndarray) -> None:
        """Correct by an orientation q [rad] with covariance R [rad^2]."""
        found, learnt = np.zeros(self.weight.shape), self.cell.learnt.copy()
        for _, levels in self._living():
            for component in levels:
                for i in component.still():
                    component.forget_turn(i)
        self._follow_noise(q, R)
        R = self.noise * R
        # Reactions stay those of the last wrench: where the next is made linear.
        learnt[self.cell.n :] = 0.0
        for g, levels in self._living():
            for j, component in enumerate(levels):
                measured = model.orientation(self.cell, component.x, q, R)
                found[g, j] = component.correct(measured, learnt=learnt, least=component.least)
        self._reweigh(found)

    def _follow_noise(self, q, R):
        """Follow by how much orientations are noisier than stated, by the mixture's innovation."""
        n = self.cell.n + 3
        measured = model.orientation(self.cell, self.mean, q, R)
        S = measured.E[:, :n] @ self.covariance @ measured.E[:, :n].T + self.noise * R
        innovation = np.linalg.solve(np.linalg.cholesky(S), measured.residual)
        before, self.innovation = self.innovation, innovation
        if before is not None:
            self._grow(0, np.sum((innovation - before) ** 2) / 6)
        if len(self.orientations) == 3:
            third = np.diff(np.unwrap([*self.orientations, q], axis=0), 3, axis=0)[0]
            self._grow(1, third @ np.linalg.solve(R, third) / (60 * self.noises[1]))
        self.orientations = [*self.orientations, q][-3:]

    def _grow(self, i, seen):
        o, noise = self.cell.settings, self.noises[i]
        surplus = min(seen, o.outlier) - 1
        self.noises[i] = np.clip(noise * np.exp(surplus / o.noise_count), 1.0, o.noise_most)

    @property
    def noise(self) -> float:
        """Variance of orientations as found, over the stated one."""
        return min(self.noises)

    def weigh(self, u: np.ndarray, contacts: int = 3) -> None:
        """Take a wrench; parameters as for `update_from_wrench`."""
        o, dt, n = self.cell.settings, self.since_wrench, self.cell.n
        self.since_wrench = 0.0
        self.load = self._load_of(u)
        if contacts == 0 and self.cell.is_open("bias") and np.isfinite(o.mode_time[0]):
            self._hang(u, dt)
        else:
            self.air = [[]]
        begins, self.in_contact = not self.in_contact, True
        drifts = np.isfinite(o.mode_time[0]) and self.covariance[RATE, RATE] > self.start_rates2
        self.on_three = contacts == 3 and not (self.since_start < o.settling or drifts)
        if contacts not in (2, 3) or self.since_start < o.settling or drifts:
            self._in_air()
            return
        if begins:
            self.friction_force2 = np.full(3, (self.mean[FRICTION] * self.load) ** 2)
        before = {
            component: (component.x.copy(), component.P.copy())
            for _, levels in self._living()
            for component in levels
        }
        products = {
            component: np.zeros((3, 3)) if begins else component.products() for component in before
        }
        given = u, contacts, products, dt
        found, doubt, nis = self._by_equations(*given, o.passes if begins else 1)
        misfit = nis > 6 * o.outlier and not begins
        self.spiked = self.spiked + 1 if misfit else 0
        if self.spiked == 1:
            for component, (x, P) in before.items():
                component.x, component.P = x, P
            found, doubt, _ = self._by_equations(*given, 1, nis / 6)
        if self.alive.sum() > 1:
            doubt = (self.weight * doubt).sum(axis=1)[self.alive]
            again = (
                o.direction_evidence_time
                / max(dt, 1e-4)
                * doubt
                / self.weight.sum(axis=1)[self.alive]
            )
            self.told = np.max(1 / (1 + again))
        self._reweigh(found)
        self._merge()
        for _, levels in self._living():
            for component in levels:
                component.keep_reactions()
        x, P = self.mean, self.covariance
        self.friction_force2 = x[FRICTION] ** 2 * (x[n:] ** 2 + np.diagonal(P)[n:])

    def _by_equations(self, u, contacts, products, dt, passes, wider=1.0):
        """Correct every component; return log likelihoods, doubts, and the mean of their NIS."""
        found, doubt, nis = (np.zeros(self.weight.shape) for _ in range(3))
        for g, levels in self._living():
            for j, component in enumerate(levels):
                prior = self.cell.settings.reaction_prior * self.load
                component.forget(prior, component.level)
                if contacts == 2:
                    component.halve(prior)
                found[g, j], volume, doubt[g, j], nis[g, j] = component.weigh(
                    u,
                    self.load,
                    self.friction_force2,
                    products[component],
                    contacts,
                    dt,
                    passes,
                    wider,
                )
                # Between frictions the reactions' wide prior is no evidence.
                found[g, j] += volume if self.alive.sum() > 1 else 0.0
        return found, doubt, (self.weight * nis).sum()

    def _load_of(self, u):
        scene = self.cell.scene
        force, couple = np.linalg.norm(u[:3]), np.linalg.norm(u[3:])
        return force + 2 * couple / scene.peg_diameter + scene.peg_mass * 9.81

    def _in_air(self):
        """Let reactions be unknown."""
        self.in_contact, n, o = False, self.cell.n, self.cell.settings
        for _, levels in self._living():
            for component in levels:
                component.x[n:] = 0.0
                component.forget(o.reaction_prior * self.load, self._untold())

    def _hang(self, u, dt):
        """Let a peg that hangs free tell the bias, as it was before the last stretch of time."""
        self.air[-1].append((dt, self.mean, u))
        time = sum(dt for dt, *_ in self.air[-1])
        if time < self.cell.settings.touch_time:
            return
        self.air.append([])
        if len(self.air) < 3:
            return
        steps, means, u = (np.array(values) for values in zip(*self.air.pop(0)))
        first = places_of(self.cell.open_quantities).bias
        bias = range(first, first + 6)
        learnt = self.cell.learnt.copy()
        learnt[self.cell.n :] = 0.0
        # A walk since the mean of the stretch.
        walked = (time + steps.sum() / 3) * self.cell.walk[bias]
        for _, levels in self._living():
            for component in levels:
                component.P[bias, bias] -= walked
                measured = model.hanging(self.cell, component.x, means, u, steps.mean())
                component.correct(measured, learnt=learnt)
                component.P[bias, bias] += walked

    def _reweigh(self, found):
        """Weigh by log likelihoods: levels in full, frictions by the share that is told."""
        evidence = np.full(len(self.frictions), -np.inf)
        told = self.told if self.alive.sum() > 1 else 1.0
        for g, _ in self._living():
            held, best = self.weight[g].sum(), found[g].max()
            levels = self.weight[g] / held * np.exp(np.maximum(found[g] - best, -50.0))
            evidence[g] = np.log(held) + told * (best + np.log(levels.sum()))
            levels = np.maximum(levels / levels.sum(), 1e-9)
            self.weight[g] = levels / levels.sum()
        share = np.exp(evidence - evidence.max())
        share /= share.sum()
        self.alive &= share >= 1e-9
        self.weight *= (share * self.alive)[:, None]
        self.weight /= self.weight.sum()

    def _merge(self):
        """Let two frictions be one, by moments, while that loses little (Runnalls 2007)."""
        while self.alive.sum() > 1:
            pairs = itertools.combinations(np.flatnonzero(self.alive), 2)
            loss, h, g = min((self._lost(h, g), h, g) for h, g in pairs)
            if loss >= self.cell.settings.joined:
                return
            for l, (one, other) in enumerate(zip(self.frictions[h], self.frictions[g])):
                w = self.weight[[h, g], l] / self.weight[[h, g], l].sum()
                mean = w[0] * one.x + w[1] * other.x
                one.P = sum(
                    share * (c.P + np.outer(c.x - mean, c.x - mean))
                    for share, c in zip(w, (one, other))
                )
                one.x = mean
            self.weight[h] += self.weight[g]
            self.weight[g], self.alive[g] = 0.0, False

    def _lost(self, *pair):
        """Return the bound on what is lost of two frictions that become one [nats]."""
        w = np.array([self.weight[g].sum() for g in pair])
        f, v = np.array([self._friction(g) for g in pair]).T
        mean = w @ f / w.sum()
        joined = w @ (v + (f - mean) ** 2) / w.sum()
        return 0.5 * (w.sum() * np.log(joined) - w @ np.log(v))

    def _friction(self, g):
        share = self.weight[g] / self.weight[g].sum()
        values = [(c.x[FRICTION], c.P[FRICTION, FRICTION]) for c in self.frictions[g]]
        return share @ np.array(values)

    @property
    def mean(self) -> np.ndarray:
        """Mean of the mixture, shape (n + 3,)."""
        return sum(w * c.x for w, c in self._weighted())

    @property
    def covariance(self) -> np.ndarray:
        """Its covariance, with what components differ by, shape (n + 3, n + 3)."""
        mean = self.mean
        return sum(w * (c.P + np.outer(c.x - mean, c.x - mean)) for w, c in self._weighted())

    def _weighted(self):
        pairs = zip(self.weight.ravel(), (c for levels in self.frictions for c in levels))
        return [(w, c) for w, c in pairs if w > 0.0]
