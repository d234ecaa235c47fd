"""
Insertion of a rigid peg by a time-stepping complementarity scheme, built apart from the package.

D. E. Stewart, J. C. Trinkle, An implicit time-stepping scheme for rigid body dynamics with
inelastic collisions and Coulomb friction, Int. J. Numer. Methods Eng. 39 (1996) 2673-2691.
Contacts are rigid: impulses keep gaps from closing, and lie in the friction cone. Gaps come from
dense samples of the rim's and the edge's circles, refined by parabolas; nothing is in closed form.
The holder is a spring and damper between two poses, its program two functions of time.
"""

import numpy as np

SAMPLES = 720
ANGLES = np.arange(SAMPLES) * (2 * np.pi / SAMPLES)
CIRCLE = np.column_stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(SAMPLES)])
# Gaps below this take part in a step [m].
NEAR = 2e-5
SWEEPS = 400
DONE = 1e-9


def skew(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def turn(w):
    """Return the rotation by a vector."""
    angle = np.linalg.norm(w)
    if angle < 1e-12:
        return np.eye(3) + skew(w)
    K = skew(w / angle)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def lowest(gap_of, angle):
    """Return where near an angle a gap is least, by parabolas through three values."""
    width = 2 * np.pi / SAMPLES
    for _ in range(4):
        left, middle, right = (gap_of(angle + k * width) for k in (-1, 0, 1))
        bend = left - 2 * middle + right
        if bend > 0:
            angle += width * np.clip((left - right) / (2 * bend), -1, 1)
        width /= 8
    return angle


def minima(values):
    return np.flatnonzero((values < np.roll(values, 1)) & (values <= np.roll(values, -1)))


def touching(scene, C, R):
    """Return point, normal on the peg and gap of every place that is near to touching."""
    D, r = scene.hole_diameter, scene.peg_diameter / 2
    zeta, end = R[:, 2], C - scene.mass_center_height * R[:, 2]

    def beside(angle):
        p = D / 2 * np.array([np.cos(angle), np.sin(angle), 0])
        w = p - end - ((p - end) @ zeta) * zeta
        return p, w

    def edge(angle):
        return end + r * (np.cos(angle) * R[:, 0] + np.sin(angle) * R[:, 1])

    found = []
    w = D / 2 * CIRCLE - end
    up = w @ zeta
    gaps = np.linalg.norm(w - up[:, None] * zeta, axis=1) - r
    for k in minima(gaps):
        if gaps[k] < NEAR and 0 < up[k] < scene.peg_height:
            angle = lowest(lambda a: np.linalg.norm(beside(a)[1]) - r, ANGLES[k])
            p, w = beside(angle)
            length = np.linalg.norm(w)
            found.append((p, -w / length, length - r))
    points = end + r * (CIRCLE[:, :1] * R[:, 0] + CIRCLE[:, 1:2] * R[:, 1])
    gaps = D / 2 - np.hypot(points[:, 0], points[:, 1])
    for k in minima(gaps):
        if gaps[k] < NEAR and points[k, 2] < 0:
            angle = lowest(lambda a: D / 2 - np.hypot(*edge(a)[:2]), ANGLES[k])
            p = edge(angle)
            outward = np.array([p[0], p[1], 0]) / np.hypot(p[0], p[1])
            found.append((p, -outward, D / 2 - np.hypot(p[0], p[1])))
    return found


def holder(holding, command, C, R, v, w):
    """Return force at, and moment about, the mass centre."""
    lever, stiffness, damping, turning, turning_damping = holding
    C_to, R_to, v_to, w_to = command
    arm, arm_to = R @ lever, R_to @ lever
    F = stiffness * (C_to + arm_to - C - arm)
    F = F + damping * (v_to + np.cross(w_to, arm_to) - v - np.cross(w, arm))
    S = R_to @ R.T
    # Small differences: the rotation vector from the skew part.
    half = np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]]) / 2
    sine = np.linalg.norm(half)
    vector = half * (np.arcsin(sine) / sine if sine > 1e-12 else 1.0)
    return F, turning * vector + turning_damping * (w_to - w) + np.cross(arm, F)


def insert(scene, holding, command_of, C, R, v, w, seconds, step):
    """
    Return time, mass centre, axes and normal forces on rim and edge, a row a step.

    Parameters
    ----------
    scene : Scene
    holding : tuple
        Grip from the mass centre (peg axes), stiffness, damping, and both of the rotation.
    command_of : callable
        t to mass centre, axes, velocity, angular velocity; the weight is carried.
    C, R, v, w : ndarray
        Begin.
    seconds, step : float
        [s]

    """
    m, I_P = scene.peg_mass, np.diag([scene.transverse_inertia] * 2 + [scene.axial_inertia])
    rows = []
    lever, stiffness, damping, turning, turning_damping = holding
    for k in range(round(seconds / step)):
        t = (k + 1) * step
        inertia = R @ I_P @ R.T
        F, M = holder(holding, command_of(t), C, R, v, w)
        gyro = np.cross(w, inertia @ w)
        # The stiff holder is taken implicitly: M u' = M u + h (F - h K u') about the old pose.
        arm = skew(R @ lever)
        G = np.hstack([np.eye(3), -arm])
        held = (step * damping + step**2 * stiffness) * G.T @ G
        held[3:, 3:] += (step * turning_damping + step**2 * turning) * np.eye(3)
        mass = np.zeros((6, 6))
        mass[:3, :3], mass[3:, 3:] = m * np.eye(3), inertia
        u = np.concatenate([v, w])
        damped = held - step**2 * (stiffness * G.T @ G)
        damped[3:, 3:] -= step**2 * turning * np.eye(3)
        A = mass + held
        free = np.linalg.solve(A, mass @ u + damped @ u + step * np.concatenate([F, M - gyro]))
        places = touching(scene, C, R)
        u, impulses = _complementarity(A, free, places, C, scene.friction, step)
        rim = sum(p for p, place in zip(impulses, places) if abs(place[0][2]) < 1e-15) / step
        edge = sum(p for p, place in zip(impulses, places) if abs(place[0][2]) >= 1e-15) / step
        v, w = u[:3], u[3:]
        C, R = C + step * v, turn(step * w) @ R
        rows.append((t, C, R, rim, edge))
    return [np.array(part) for part in zip(*rows)]


def _complementarity(A, free, places, C, friction, step):
    """Return the velocity and the normal impulses, by projected sweeps over the contacts."""
    if not places:
        return free, []
    J = [np.hstack([np.eye(3), -skew(p - C)]) for p, _, _ in places]
    inverse = np.linalg.inv(A)
    W = [j @ inverse @ j.T for j in J]
    impulse = np.zeros((len(places), 3))
    u = free.copy()
    for _ in range(SWEEPS):
        change = 0.0
        for i, (_, n, gap) in enumerate(places):
            # The proximal form of complementarity on the cone.
            scale = 1.0 / np.linalg.eigvalsh(W[i])[-1]
            slide = J[i] @ u
            slide = slide + (gap / step) * n
            trial = impulse[i] - scale * slide
            normal = max(trial @ n, 0.0)
            along = trial - (trial @ n) * n
            length = np.linalg.norm(along)
            if length > friction * normal:
                along *= friction * normal / length
            new = normal * n + along
            u = u + inverse @ J[i].T @ (new - impulse[i])
            change = max(change, np.abs(new - impulse[i]).max())
            impulse[i] = new
        if change < DONE * max(1e-3, np.abs(impulse).max()):
            break
    return u, [float(p @ n) for p, (_, n, _) in zip(impulse, places)]
