"""
A peg as a free rigid body held by three gaps, built without any closed form of the package.

The gaps come from distances to an analytic cylinder and circle; every derivative is numeric:
complex steps for first ones, sixth-order differences for those along a motion.
"""

import numpy as np

EZ = np.array([0.0, 0.0, 1.0])


def rotation(q):
    """Return R_HP = Rz(psi) Ry(-gamma) Rz(phi), complex capable."""

    def turn(axis, angle):
        s, c = np.sin(angle), np.cos(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        R = np.zeros((3, 3), dtype=np.result_type(angle, float))
        R[axis, axis] = 1
        R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
        return R

    return turn(2, q[1]) @ turn(1, -q[0]) @ turn(2, q[2])


def contact_K(scene, C, R):
    """Return the least distance of the rim circle from the peg's side [m], and where it is."""
    zeta = R[:, 2]
    D, radius = scene.hole_diameter, scene.peg_diameter / 2
    theta = np.arctan2(zeta[1].real, zeta[0].real)
    for _ in range(60):
        p = D / 2 * np.array([np.cos(theta), np.sin(theta), 0])
        dp = np.array([-p[1], p[0], 0])
        r = p - C
        slope = r @ dp - (r @ zeta) * (dp @ zeta)
        curvature = dp @ dp - r @ p - (dp @ zeta) ** 2 + (r @ zeta) * (p @ zeta)
        step = slope / curvature
        theta = theta - step
        if abs(step) < 1e-15:
            break
    p = D / 2 * np.array([np.cos(theta), np.sin(theta), 0])
    r = p - C
    return np.sqrt(r @ r - (r @ zeta) ** 2) - radius, p


def contacts(scene, C, R):
    """
    Return the three gaps [m] and contact points of a body with mass centre C and axes R.

    K as in `contact_K`; B1, B2: where the peg's edge circle crosses the plane of the rim, its
    distance from the rim.
    """
    gap_K, K = contact_K(scene, C, R)
    gaps, points = [gap_K], [K]
    zeta = R[:, 2]
    D, radius = scene.hole_diameter, scene.peg_diameter / 2
    end = C - scene.mass_center_height * zeta
    x, y = radius * R[:, 0], radius * R[:, 1]
    rise = np.sqrt(x[2] ** 2 + y[2] ** 2)
    along = (x[2] * x + y[2] * y) / rise
    across = (-y[2] * x + x[2] * y) / rise
    cosine = -end[2] / rise
    sine = np.sqrt(1 - cosine**2)
    e = np.array([-zeta[1], zeta[0], 0]).real * -1
    side = np.sign((across.real) @ e)
    for sign in (-side, side):
        point = end + cosine * along + sign * sine * across
        gaps.append(D / 2 - np.sqrt(point[0] ** 2 + point[1] ** 2))
        points.append(point)
    return np.array(gaps), np.array(points)


def complex_step(function, x):
    """Return d function / dx by complex steps, last axis the components of x."""
    columns = []
    for k in range(len(x)):
        shifted = np.asarray(x, complex).copy()
        shifted[k] += 1e-30j
        columns.append(np.imag(function(shifted)) / 1e-30)
    return np.stack(columns, axis=-1)


def along(function, rate_scale=1.0):
    """Return d function(t) / dt at 0 by a sixth-order difference."""
    h = 1e-3 / rate_scale
    weights = {1: 45, 2: -9, 3: 1}
    return sum(w * (function(k * h) - function(-k * h)) for k, w in weights.items()) / (60 * h)


def gap_gradients(scene, C, R):
    """Return gaps' gradients by translation and by rotation about C (hole axes), (3, 3) each."""
    by_C = complex_step(lambda x: contacts(scene, x, R)[0], C)

    def turned(w):
        cross = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return contacts(scene, C + 0j, (np.eye(3) + cross) @ R)[0]

    return by_C, complex_step(turned, np.zeros(3))


def mass_center(scene, q, guess):
    """Return C where all three gaps vanish, by Newton's method from a guess."""
    C, R = np.array(guess, float), rotation(np.asarray(q, float))
    for _ in range(50):
        gaps, _ = contacts(scene, C, R)
        step = np.linalg.solve(gap_gradients(scene, C, R)[0], gaps)
        C = C - step
        if np.max(np.abs(step)) < 1e-16:
            break
    return C


def guess_center(scene, q):
    """Return a start for `mass_center`: the peg's edge centre half a radius off the hole's."""
    zeta = rotation(q)[:, 2]
    tilt = np.arccos(zeta[2])
    h = -np.array([zeta[0], zeta[1], 0]) / np.sin(tilt)
    radius, D = scene.peg_diameter / 2, scene.hole_diameter
    # End centre on the line where the generator through K meets the rim.
    down = (D - 2 * radius * np.cos(tilt)) / np.sin(tilt)
    K_line = -D / 2 * h - down * zeta
    eta = h * np.cos(tilt) + EZ * np.sin(tilt)
    return K_line + radius * eta + scene.mass_center_height * zeta


def spin_axes(q):
    """Return E with angular velocity = E(q) q', hole axes, from the rotation matrix alone."""
    R = rotation(np.asarray(q, float))
    dR = complex_step(lambda x: rotation(x), q)
    columns = []
    for k in range(3):
        W = dR[:, :, k] @ R.T
        columns.append([W[2, 1], W[0, 2], W[1, 0]])
    return np.array(columns).T


class Body:
    """Everything about one state that the three constructions share."""

    def __init__(self, scene, q, rates, force_H, moment_H):
        self.scene, self.q, self.rates = scene, np.asarray(q, float), np.asarray(rates, float)
        self.force = np.asarray(force_H) + scene.peg_mass * np.asarray(scene.gravity)
        self.moment = np.asarray(moment_H)
        self.scale = max(1.0, np.max(np.abs(self.rates)))
        self.C = mass_center(scene, self.q, guess_center(scene, self.q))
        self.R, self.E = rotation(self.q), spin_axes(self.q)
        self.inertia_P = np.diag([scene.transverse_inertia] * 2 + [scene.axial_inertia])
        self.inertia = self.R @ self.inertia_P @ self.R.T
        self.omega = self.E @ self.rates
        self.dC = self.center_jacobian(self.q)
        _, self.points = contacts(scene, self.C, self.R)
        gradient, _ = gap_gradients(scene, self.C, self.R)
        self.stretch = np.linalg.norm(gradient, axis=1)
        self.normals = gradient / self.stretch[:, None]
        self.velocity = self.dC @ self.rates + np.cross(self.omega, self.points - self.C)
        speed = np.linalg.norm(self.velocity, axis=1)
        self.friction = -scene.friction * self.velocity / np.where(speed, speed, 1)[:, None]
        self.reaction = self.normals + self.friction
        self.torque = np.cross(self.points - self.C, self.reaction)

    def center(self, q):
        return mass_center(
            self.scene, q, self.C if hasattr(self, "C") else guess_center(self.scene, q)
        )

    def center_jacobian(self, q):
        """Return dC/dq from the gaps' implicit function."""
        C = self.center(q)
        R = rotation(q)
        by_C, by_turn = gap_gradients(self.scene, C, R)
        return -np.linalg.solve(by_C, by_turn @ spin_axes(q))

    def path(self, t):
        return self.q + t * self.rates


def newton_euler(body):
    """Return (gamma'', psi'', phi'', N) from m a_C and dL/dt of the body moved along its pose."""
    m = body.scene.peg_mass
    dC_dot = along(lambda t: body.center_jacobian(body.path(t)), body.scale)
    E_dot = along(lambda t: spin_axes(body.path(t)), body.scale)
    A = np.zeros((6, 6))
    A[:3, :3], A[:3, 3:] = m * body.dC, -body.reaction.T
    A[3:, :3], A[3:, 3:] = body.inertia @ body.E, -body.torque.T
    gyro = np.cross(body.omega, body.inertia @ body.omega)
    r = np.concatenate(
        [
            body.force - m * dC_dot @ body.rates,
            body.moment - body.inertia @ E_dot @ body.rates - gyro,
        ]
    )
    return np.linalg.solve(A, r)


def lagrange(body):
    """Return the same from the kinetic energy's numeric derivatives and virtual work."""
    m = body.scene.peg_mass

    def mass_matrix(q):
        dC, wE = body.center_jacobian(q), rotation(q).T @ spin_axes(q)
        return m * dC.T @ dC + wE.T @ body.inertia_P @ wE

    M_dot = along(lambda t: mass_matrix(body.path(t)), body.scale)
    dT = np.array(
        [
            along(
                lambda t, k=k: body.rates @ mass_matrix(body.q + t * np.eye(3)[k]) @ body.rates / 2
            )
            for k in range(3)
        ]
    )
    virtual = [body.dC + np.cross(body.E.T, p - body.C).T for p in body.points]
    work = np.array([v.T @ f for v, f in zip(virtual, body.friction, strict=True)])
    A = np.zeros((6, 6))
    A[:3, :3], A[:3, 3:] = mass_matrix(body.q), -work.T
    A[3:, :3], A[3:, 3:] = m * body.dC, -body.reaction.T
    dC_dot = along(lambda t: body.center_jacobian(body.path(t)), body.scale)
    Q = body.dC.T @ body.force + body.E.T @ body.moment
    r = np.concatenate([Q - M_dot @ body.rates + dT, body.force - m * dC_dot @ body.rates])
    return np.linalg.solve(A, r)


def multipliers(body):
    """Return the same from the free body's 6 equations and the 3 gaps' second derivatives."""
    scene, m = body.scene, body.scene.peg_mass
    by_C, by_turn = gap_gradients(scene, body.C, body.R)
    v = body.dC @ body.rates

    def gap_rate(t):
        # Free flight: constant velocity and constant angular velocity.
        angle = np.linalg.norm(body.omega) * t
        k = body.omega / (np.linalg.norm(body.omega) or 1.0)
        K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        R = (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K) @ body.R
        g_C, g_w = gap_gradients(scene, body.C + v * t, R)
        return g_C @ v + g_w @ body.omega

    A = np.zeros((9, 9))
    A[:3, :3], A[3:6, 3:6] = m * np.eye(3), body.inertia
    # Reactions count by their normal part: a gap's multiplier times its stretch.
    A[:3, 6:], A[3:6, 6:] = -body.reaction.T, -body.torque.T
    A[6:, :3], A[6:, 3:6] = by_C, by_turn
    r = np.concatenate(
        [
            body.force,
            body.moment - np.cross(body.omega, body.inertia @ body.omega),
            -along(gap_rate, body.scale),
        ]
    )
    y = np.linalg.solve(A, r)
    E_dot = along(lambda t: spin_axes(body.path(t)), body.scale)
    return np.concatenate([np.linalg.solve(body.E, y[3:6] - E_dot @ body.rates), y[6:]])
