"""
Derive the closed forms of docs/notation.md from the constraints, with sympy.

Each step states what is assumed, what is claimed, and lets sympy show that the claim follows:
identities are reduced to zero exactly, in c = cos(gamma) and s = sin(gamma) with s^2 = 1 - c^2.
Run it (`python docs/derivation/derive.py`); it prints one line for each claim and fails at the
first that does not hold. docs/derivation/README.md tells the same in words.
"""

import sympy as sp

d, D, H, m, Ie, Iz = sp.symbols("d D H_c m I_e I_z", positive=True)
c = sp.Symbol("c", positive=True)
s = sp.sqrt(1 - c**2)
t = sp.Symbol("t")
FRAME = ("h", "e", "z")

# The pose in (h, e, z): the peg's axes, and the closed forms that are claimed.
ETA, EPS, ZETA = sp.Matrix([c, 0, s]), sp.Matrix([0, -1, 0]), sp.Matrix([-s, 0, c])
A1, A2 = (d - D * c) / (2 * s), (D - d * c) / (2 * s)
S1, S2 = (A2 - A1 * c) / s, (A2 * c - A1) / s
B_SQUARED = D**2 / 4 - S1**2
b = sp.Symbol("b", positive=True)
O_CROSS = sp.Matrix([0, 0, A1])
END = O_CROSS - A2 * ZETA
CENTER = END + H * ZETA
K = sp.Matrix([-D / 2, 0, 0])
B1, B2 = sp.Matrix([S1, -b, 0]), sp.Matrix([S1, b, 0])


def by_gamma(expression):
    """Return d/dgamma of an expression in c (dc/dgamma = -s) without b."""
    return -s * sp.diff(expression, c)


def vanishes(expression):
    """Return whether an expression in c, d, D, H_c and b^2 is identically zero."""
    entries = list(expression) if isinstance(expression, sp.MatrixBase) else [expression]
    for entry in entries:
        reduced = sp.expand(sp.expand(entry).subs(b**2, B_SQUARED))
        if sp.simplify(sp.together(reduced)) != 0:
            return False
    return True


def pose():
    """Derive the pose from the three contacts, each written as a condition on a free centre."""
    h, z = sp.symbols("h z")
    center = sp.Matrix([h, 0, z])
    # K: the rim point (-D/2, 0, 0) lies d/2 from the peg's axis, on the side of -eta.
    on_side = ETA.dot(center - K) - d / 2
    end = center - H * ZETA
    # B: the edge point end + d/2 (cos(chi) eta + sin(chi) eps) meets z = 0 on the circle D/2.
    cosine = sp.Symbol("cos_chi")
    in_plane = end[2] + d / 2 * cosine * s
    on_rim = (end[0] + d / 2 * cosine * c) ** 2 + d**2 / 4 * (1 - cosine**2) - D**2 / 4
    given = {h: CENTER[0], z: CENTER[2], cosine: 2 * S2 / d}
    yield "K lies on the peg's side", on_side.subs(given)
    yield "B1, B2 lie in the plane of the rim", in_plane.subs(given)
    yield "B1, B2 lie on the rim", on_rim.subs(given)
    yield "their h is S1", (end[0] + d / 2 * cosine * c).subs(given) - S1
    yield "b is the same on rim and edge", B_SQUARED - (d**2 / 4 - S2**2)
    # The conditions fix the pose: their Jacobian is regular for gamma0 < gamma < pi/2.
    system = sp.Matrix([on_side, in_plane, on_rim]).jacobian([h, z, cosine]).subs(given)
    yield "the pose is isolated: det = d (D - d c)/2", sp.det(system) - d * (D - d * c) / 2


def lengths():
    """Derive the identities between the lengths, and their derivatives by gamma."""
    yield "a1 c + S1 s = a2", A1 * c + S1 * s - A2
    yield "b^2 = 4 c a1 a2 / s^2", B_SQUARED - 4 * c * A1 * A2 / s**2
    yield "OB1^2 = D^2/4 + a1^2 = d^2/4 + a2^2", A1**2 + D**2 / 4 - A2**2 - d**2 / 4
    yield "S1 = (D(1 + c^2) - 2 d c)/(2 s^2)", S1 - (D * (1 + c**2) - 2 * d * c) / (2 * s**2)
    tan2 = (1 - c) / (1 + c)
    yield "S1 = (D - d) c/s^2 + D/2 tan^2", S1 - (D - d) * c / s**2 - D / 2 * tan2
    yield "S2 = (D - d) c/s^2 - d/2 tan^2", S2 - (D - d) * c / s**2 + d / 2 * tan2
    yield "a1' = a2/s", by_gamma(A1) - A2 / s
    yield "a2' = a1/s", by_gamma(A2) - A1 / s
    yield "S1' = -2 S2/s", by_gamma(S1) + 2 * S2 / s
    yield "S2' = -2 S1/s", by_gamma(S2) + 2 * S1 / s
    yield "b b' = 2 S1 S2/s", by_gamma(B_SQUARED) / 2 - 2 * S1 * S2 / s
    h_c, z_c = CENTER[0], CENTER[2]
    dh_c, dz_c = 2 * A1 - z_c, h_c + S1
    yield "h_c = -(H_c - a2) s", h_c + (H - A2) * s
    yield "h_c' = 2 a1 - z_c", by_gamma(h_c) - dh_c
    yield "z_c' = h_c + S1", by_gamma(z_c) - dz_c
    yield "h_c'' = 2 a2/s - z_c'", by_gamma(dh_c) - (2 * A2 / s - dz_c)
    yield "h_c = (D - d c)/2 - H_c s", h_c - (D - d * c) / 2 + H * s
    yield "h_c' = (d/2) s - H_c c", dh_c - d / 2 * s + H * c
    yield "h_c'' = (d/2) c + H_c s", by_gamma(dh_c) - d / 2 * c - H * s
    yield "z_c'' = h_c' - 2 S2/s", by_gamma(dz_c) - (dh_c - 2 * S2 / s)
    limit = by_gamma(dz_c).subs(c, d / D)
    # h_c' is -z_c there, and S2 is d/2.
    sine0 = sp.sqrt(1 - d**2 / D**2)
    yield "z_c''(gamma0) = -z_c - d/sin(gamma0)", limit + CENTER[2].subs(c, d / D) + d / sine0


def normals_and_velocities():
    """Derive normals as squares of the touching tangents, and velocities of material points."""
    # K: the rim's tangent is e, the peg's side contains zeta: the normal is eta.
    yield (
        "n_K is square to rim and side",
        sp.Matrix([ETA.dot(sp.Matrix([0, 1, 0])), ETA.dot(ZETA)]),
    )
    psi_rate, phi_rate, tilt_rate = sp.symbols("psi_rate phi_rate tilt_rate")
    omega = tilt_rate * EPS + sp.Matrix([0, 0, psi_rate]) + phi_rate * ZETA
    dC = sp.Matrix([by_gamma(CENTER[0]), 0, by_gamma(CENTER[2])]) * tilt_rate
    v_C = dC + psi_rate * sp.Matrix([0, 0, 1]).cross(CENTER)
    for name, point in (("B1", B1), ("B2", B2)):
        rim_tangent = sp.Matrix([-point[1], point[0], 0])
        edge_tangent = ZETA.cross(point - END)
        to_O = O_CROSS - point
        yield f"n_{name} points to O", sp.Matrix([to_O.dot(rim_tangent), to_O.dot(edge_tangent)])
        velocity = v_C + omega.cross(point - CENTER)
        side = point[1]
        claimed = (
            tilt_rate * sp.Matrix([2 * A1, 0, 2 * S1])
            + psi_rate * sp.Matrix([-side, S1, 0])
            + phi_rate * sp.Matrix([-side * c, S2, -side * s])
        )
        yield f"velocity at {name}", velocity - claimed
        yield f"v.n = 0 at {name}", velocity.dot(to_O)
    velocity = v_C + omega.cross(K - CENTER)
    claimed = tilt_rate * sp.Matrix([2 * A1, 0, -2 * A1 * c / s])
    claimed -= sp.Matrix([0, 1, 0]) * (D * psi_rate + d * phi_rate) / 2
    yield "velocity at K", velocity - claimed
    yield "v.n = 0 at K", velocity.dot(ETA)
    # The planar motion turns about L = (-S1, 0, 2 a1).
    L = sp.Matrix([-S1, 0, 2 * A1])
    yield "L is the instant centre", dC + tilt_rate * EPS.cross(L - CENTER)
    yield "KL = 2 a1/s", (L - K).dot(L - K) - (2 * A1 / s) ** 2
    to_B = L - sp.Matrix([S1, 0, 0])
    yield "BL = 2 OB", to_B.dot(to_B) - 4 * (A1**2 + S1**2)


def lagrange():
    """Derive the left sides from the kinetic energy of the whole body."""
    gamma, psi, phi = (sp.Function(name)(t) for name in ("gamma", "psi", "phi"))
    h, z = sp.Function("h_c")(gamma), sp.Function("z_c")(gamma)
    sg, cg = sp.sin(gamma), sp.cos(gamma)
    rate = {x: sp.diff(x, t) for x in (gamma, psi, phi)}
    # Angular velocity on the peg's own axes (eps, eta, zeta): z is s eta + c zeta.
    omega = (rate[gamma], rate[psi] * sg, rate[phi] + rate[psi] * cg)
    position = sp.Matrix([h * sp.cos(psi), h * sp.sin(psi), z])
    speed2 = sum(x**2 for x in sp.diff(position, t))
    T = m * speed2 / 2 + (Ie * (omega[0] ** 2 + omega[1] ** 2) + Iz * omega[2] ** 2) / 2

    def left(x):
        return sp.diff(sp.diff(T, rate[x]), t) - sp.diff(T, x)

    dh, dz = sp.diff(h, gamma), sp.diff(z, gamma)
    ddh, ddz = sp.diff(h, gamma, 2), sp.diff(z, gamma, 2)
    second = {x: sp.diff(x, t, 2) for x in (gamma, psi, phi)}
    coupling = m * h * dh + (Ie - Iz) * sg * cg
    claimed = {
        gamma: (m * (dh**2 + dz**2) + Ie) * second[gamma]
        + m * (dh * ddh + dz * ddz) * rate[gamma] ** 2
        - coupling * rate[psi] ** 2
        + Iz * sg * rate[psi] * rate[phi],
        psi: (m * h**2 + Ie * sg**2 + Iz * cg**2) * second[psi]
        + Iz * cg * second[phi]
        + 2 * coupling * rate[gamma] * rate[psi]
        - Iz * sg * rate[gamma] * rate[phi],
        phi: Iz * (second[phi] + cg * second[psi] - sg * rate[gamma] * rate[psi]),
    }
    for x in (gamma, psi, phi):
        yield f"left side of the {x.func} equation", sp.expand((left(x) - claimed[x]).doit())
    accelerations = [
        second[gamma] * dh + ddh * rate[gamma] ** 2 - h * rate[psi] ** 2,
        h * second[psi] + 2 * dh * rate[gamma] * rate[psi],
        second[gamma] * dz + ddz * rate[gamma] ** 2,
    ]
    turn = sp.Matrix([[sp.cos(psi), -sp.sin(psi), 0], [sp.sin(psi), sp.cos(psi), 0], [0, 0, 1]])
    found = turn.T * sp.diff(position, t, 2)
    yield "acceleration of C in (h, e, z)", sp.expand(found - sp.Matrix(accelerations))


STEPS = (pose, lengths, normals_and_velocities, lagrange)


def main():
    """Show every claim; return how many there were."""
    count = 0
    for step in STEPS:
        print(step.__doc__.strip())
        for claim, residual in step():
            if not vanishes(residual):
                raise SystemExit(f"  does not hold: {claim}; left over: {sp.simplify(residual)}")
            print(f"  holds: {claim}")
            count += 1
    return count


if __name__ == "__main__":
    main()
