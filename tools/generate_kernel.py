"""
Write mechanics/generated.py: the six equations and their derivatives as scalar code.

Run it from the root of the checkout; it needs sympy. A test holds its output against the committed
file, and the compiled result against the numpy model, which is written by hand.

The tilt enters only through the closed forms of the geometry. Each of them is a symbol here, and
derivatives by gamma follow from the chain rule with their known derivatives: differentiating the
closed forms themselves would bring back the cancellation that they avoid.
"""

import sys
from pathlib import Path

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

TARGET = Path(__file__).parents[1] / "peg_on_hole_ros" / "mechanics" / "generated.py"

m, Ie, Iz, f, d, D = sp.symbols("m Ie Iz f d D", positive=True)
SCALES = sp.symbols("scale0:3", positive=True)
s, c, a1, a2, S1, S2, b, db = sp.symbols("s c a1 a2 S1 S2 b db")
h_c, z_c, dh_c, dz_c, ddh_c, ddz_c = sp.symbols("h_c z_c dh_c dz_c ddh_c ddz_c")
dgamma, dpsi, dphi = sp.symbols("dgamma dpsi dphi")
Fh, Fe, Fz, Mh, Me, Mz = sp.symbols("Fh Fe Fz Mh Me Mz")
y = sp.symbols("y0:6")

BY_GAMMA = {
    s: c,
    c: -s,
    a1: a2 / s,
    a2: a1 / s,
    S1: -2 * S2 / s,
    S2: -2 * S1 / s,
    b: db,
    h_c: dh_c,
    z_c: dz_c,
    dh_c: ddh_c,
    dz_c: ddz_c,
    ddh_c: 2 * a1 / s**2 - 2 * a2 * c / s**2 - ddz_c,
    ddz_c: ddh_c + 4 * S1 / s**2 + 2 * S2 * c / s**2,
}


def _by_peg_diameter():
    """Return the closed forms' derivatives by d at constant gamma, mass and inertia."""
    da1, da2 = 1 / (2 * s), -c / (2 * s)
    dS1, dS2 = -2 * c * da1 / s, sp.Rational(1, 2) - 2 * da1 / s
    dh, dz = s * da2, da1 - c * da2
    d_dh, d_dz = 2 * da1 - dz, dh + dS1
    return {
        a1: da1,
        a2: da2,
        S1: dS1,
        S2: dS2,
        b: 2 * c * (da1 * a2 + a1 * da2) / (s**2 * b),
        h_c: dh,
        z_c: dz,
        dh_c: d_dh,
        dz_c: d_dz,
        ddh_c: 2 * da2 / s - d_dz,
        ddz_c: d_dh - 2 * dS2 / s,
        d: 1,
    }


# What each residual is differentiated by: the tilt, the rates, friction and the peg's diameter.
BY = ("g", "dg", "dp", "df", "f", "d")
CHAIN = {
    "g": BY_GAMMA,
    "dg": {dgamma: 1},
    "dp": {dpsi: 1},
    "df": {dphi: 1},
    "f": {f: 1},
    "d": _by_peg_diameter(),
}


def derivative(expression, by):
    """Return the total derivative of an expression or matrix at constant wrench in (h, e, z)."""
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(lambda element: derivative(element, by))
    return sum(sp.diff(expression, symbol) * rate for symbol, rate in CHAIN[by].items())


JACOBIANS = [
    sp.Matrix([[2 * a1, 0, 0], [0, -D / 2, -d / 2], [-2 * a1 * c / s, 0, 0]]),
    sp.Matrix([[2 * a1, b, b * c], [0, S1, S2], [2 * S1, 0, b * s]]),
    sp.Matrix([[2 * a1, -b, -b * c], [0, S1, S2], [2 * S1, 0, -b * s]]),
]
RATES = sp.Matrix([dgamma, dpsi, dphi])


def column(prefix):
    """Return three symbols along h, e, z."""
    return sp.Matrix(sp.symbols(" ".join(f"{prefix}_{axis}" for axis in "hez")))


def contact_stage():
    """
    Return the named intermediate values of each contact, and their derivatives.

    Friction over the normal reaction, u = -f v w with w = 1/sqrt(v.v + scale^2), is named so that
    its derivatives are written in it, not in the square root once more.
    """
    values, slopes = [], []
    for i, J in enumerate(JACOBIANS):
        v, u, w = column(f"v{i}"), column(f"u{i}"), sp.Symbol(f"w{i}")
        values += list(zip(v, J * RATES, strict=True))
        values += [(w, 1 / sp.sqrt(v.dot(v) + SCALES[i] ** 2))]
        values += list(zip(u, -f * w * v, strict=True))
        for by in BY:
            dv = derivative(J * RATES, by)
            along = sp.Symbol(f"along{i}_{by}")
            slopes += [(along, w * w * v.dot(dv))]
            du = -f * w * dv - along * u - (w * v if by == "f" else sp.zeros(3, 1))
            slopes += list(zip(column(f"u{i}_{by}"), du, strict=True))
    OB = sp.Symbol("OB")
    values += [(OB, sp.sqrt(D**2 / 4 + a1**2))]
    return values, slopes


def normals(by=None):
    """Return the unit normals at K, B1, B2, or their derivatives, with OB as a symbol."""
    OB = sp.Symbol("OB")
    to_O = [sp.Matrix([-S1, b, a1]), sp.Matrix([-S1, -b, a1])]
    n_K = sp.Matrix([c, 0, s])
    if by is None:
        return [n_K] + [r / OB for r in to_O]
    dOB = a1 * derivative(a1, by) / OB
    return [derivative(n_K, by)] + [derivative(r, by) / OB - r * dOB / OB**2 for r in to_O]


def motion_terms():
    """Return the mass matrix times y, and the rest of the six equations without reactions."""
    coupling = m * h_c * dh_c + (Ie - Iz) * s * c
    inertia = sp.Matrix(
        [
            (m * (dh_c**2 + dz_c**2) + Ie) * y[0],
            (m * h_c**2 + Ie * s**2 + Iz * c**2) * y[1] + Iz * c * y[2],
            Iz * c * y[1] + Iz * y[2],
            m * dh_c * y[0],
            m * h_c * y[1],
            m * dz_c * y[0],
        ]
    )
    velocity_terms = sp.Matrix(
        [
            m * (dh_c * ddh_c + dz_c * ddz_c) * dgamma**2
            - coupling * dpsi**2
            + Iz * s * dpsi * dphi,
            2 * coupling * dgamma * dpsi - Iz * s * dgamma * dphi,
            -Iz * s * dgamma * dpsi,
            m * (ddh_c * dgamma**2 - h_c * dpsi**2),
            2 * m * dh_c * dgamma * dpsi,
            m * ddz_c * dgamma**2,
        ]
    )
    wrench = sp.Matrix([Fh * dh_c + Fz * dz_c - Me, Fe * h_c + Mz, -s * Mh + c * Mz, Fh, Fe, Fz])
    return inertia, wrench - velocity_terms


def value_outputs():
    """Return G (rows gamma, psi, phi), W (rows h, e, z), both by K, B1, B2, and r."""
    n = normals()
    u = [column(f"u{i}") for i in range(3)]
    G = sp.Matrix.hstack(*(J.T * u_i for J, u_i in zip(JACOBIANS, u, strict=True)))
    W = sp.Matrix.hstack(*(n_i + u_i for n_i, u_i in zip(n, u, strict=True)))
    _, r = motion_terms()
    return [*G, *W, *r]


def slope_outputs():
    """Return each residual, left side minus right side at given y, by all of BY."""
    inertia, r = motion_terms()
    columns = []
    for by in BY:
        column_by = derivative(inertia - r, by)
        dn = normals(by)
        for i, J in enumerate(JACOBIANS):
            u, du = column(f"u{i}"), column(f"u{i}_{by}")
            dG = J.T * du + derivative(J, by).T * u
            column_by = column_by - y[3 + i] * sp.Matrix([*dG, *(du + dn[i])])
        columns.append(column_by)
    return [columns[j][i] for i in range(6) for j in range(len(BY))]


class Printer(PythonCodePrinter):
    """Python in which a tilt of zero gives NaN: numba raises at negative powers of zero."""

    def _hprint_Pow(self, expr, rational=False, sqrt="math.sqrt"):
        if expr.exp.is_Integer and expr.exp < -1:
            return f"1/{self.parenthesize(expr.base, 100)}**{-expr.exp}"
        return super()._hprint_Pow(expr, rational, sqrt)


def scalar_code(stages):
    """Return assignment lines, stage by stage; common subexpressions are taken out once each."""
    names, lines, code = sp.numbered_symbols("t"), [], Printer().doprint
    for stage in stages:
        targets = [str(target) for target, _ in stage]
        temporaries, reduced = sp.cse([e for _, e in stage], symbols=names)
        lines += [f"    {target} = {code(e)}" for target, e in temporaries]
        lines += [f"    {t} = {code(e)}" for t, e in zip(targets, reduced, strict=True)]
    return "\n".join(lines).replace("math.sqrt", "sqrt") + "\n"


HEADER = '''"""
The six equations and their derivatives as scalar code; written by tools/generate_kernel.py.

Do not edit: change the script and run it again.
"""

# ruff: noqa
from math import sqrt

import numpy as np

from peg_on_hole_ros.mechanics.scene import SceneScalars


def equations(
    scene: SceneScalars, scales: np.ndarray | tuple[float, float, float],
    geometry: tuple[float, ...], rates: tuple[float, float, float], wrench: tuple[float, ...],
    out: np.ndarray,
) -> None:
    """Fill out[0:9] with G, out[9:18] with W (rows of 3: K, B1, B2), out[18:24] with r."""
'''
DERIVATIVES = '''

def derivatives(
    scene: SceneScalars, scales: np.ndarray | tuple[float, float, float],
    geometry: tuple[float, ...], rates: tuple[float, float, float], wrench: tuple[float, ...],
    y: tuple[float, ...], out: np.ndarray,
) -> None:
    """Fill out[0:36], rows of 6: residuals by gamma, gamma', psi', phi', f, d at given y."""
'''
UNPACK = (
    "    m, Ie, Iz, f, d, D = scene.m, scene.Ie, scene.Iz, scene.f, scene.d, scene.D\n"
    "    s, c, a1, a2, S1, S2, b, db, h_c, z_c, dh_c, dz_c, ddh_c, ddz_c = geometry\n"
    "    dgamma, dpsi, dphi = rates\n"
    "    scale0, scale1, scale2 = scales\n"
    "    Fh, Fe, Fz, Mh, Me, Mz = wrench\n"
)


def staged(values):
    """Split named intermediates so that no stage uses a name that it defines itself."""
    stages = []
    for name, expression in values:
        defined = {target for target, _ in stages[-1]} if stages else set()
        if not stages or defined & expression.free_symbols:
            stages.append([])
        stages[-1].append((name, expression))
    return stages


def generate() -> str:
    """Return the text of the generated module."""
    values, slopes = contact_stage()
    outputs = [(f"out[{i}]", e) for i, e in enumerate(value_outputs())]
    derivatives = [(f"out[{i}]", e) for i, e in enumerate(slope_outputs())]
    return (
        HEADER
        + UNPACK
        + scalar_code([*staged(values), outputs])
        + DERIVATIVES
        + UNPACK
        + "    y0, y1, y2, y3, y4, y5 = y\n"
        + scalar_code([*staged(values), *staged(slopes), derivatives])
    )


if __name__ == "__main__":
    text = generate()
    if "--check" in sys.argv:
        sys.exit(0 if TARGET.read_text() == text else f"{TARGET} is not what this script writes")
    TARGET.write_text(text)
