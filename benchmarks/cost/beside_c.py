#!/usr/bin/env python3
"""
One solution of the six equations as numba compiles it, beside the same arithmetic in C.

    python -m benchmarks.cost.beside_c [COUNT]

Needs gcc. The equations come from `tools/generate_kernel.py`, as C; what is around them is
written by hand. Both solve the same states in a loop of their own language, in turns; the least
time of each counts. Their answers have to agree.
"""

import ctypes
import re
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import sympy as sp
from numba import njit

from benchmarks.cost.turns import in_turns
from peg_on_hole_ros.mechanics import kernel
from peg_on_hole_ros.mechanics.scene import Scene, scene_scalars

ROOT = Path(__file__).parents[2]
TURNS = 7
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-shared", "-fPIC")
AROUND = r"""
#include <math.h>
typedef struct { double d, D, H_c, gamma0, m, Ie, Iz, f, g_x, g_y, g_z; } Scene;

static inline void closed_forms(const Scene *p, double gamma, double *g) {
    double d = p->d, D = p->D, H_c = p->H_c, above = gamma - p->gamma0;
    double s = sin(gamma), c = cos(gamma), h = sin(gamma / 2), half = h * h;
    double a1 = D * sin(gamma - above / 2) * sin(above / 2) / s;
    double a2 = ((D - d) + 2 * d * half) / (2 * s);
    double taken = 2 * a1 / s, near = taken < D / 8 ? 1.0 : 0.0;
    double spread = (D - d) * c / (s * s), tan2 = half / (1 - half);
    double S1 = near * (D / 2 - c * taken) + (1 - near) * (spread + D / 2 * tan2);
    double S2 = near * (d / 2 - taken) + (1 - near) * (spread - d / 2 * tan2);
    double b = 2 * sqrt(c * a1 * a2) / s, db = 2 * S1 * S2 / (s * b);
    double h_c = ((D - d) + 2 * d * half) / 2 - H_c * s, z_c = (H_c - a2) * c + a1;
    double dh_c = d / 2 * s - H_c * c, dz_c = h_c + S1;
    double all[14] = {s, c, a1, a2, S1, S2, b, db, h_c, z_c, dh_c, dz_c,
                      d / 2 * c + H_c * s, dh_c - 2 * S2 / s};
    for (int i = 0; i < 14; i++) g[i] = all[i];
}

static double solve(const Scene *p, const double *scales, const double *x, const double *u,
                    double *y) {
    double g[14], out[24], w[6], K[9];
    closed_forms(p, x[0], g);
    double s = g[0], c = g[1], h_c = g[8], dh_c = g[10], dz_c = g[11];
    double sp = sin(x[2]), cp = cos(x[2]), spsi = sin(x[1]), cpsi = cos(x[1]);
    double r0 = c * cp, r1 = -c * sp, r2 = -s, r6 = s * cp, r7 = -s * sp;
    w[0] = r0 * u[0] + r1 * u[1] + r2 * u[2] + p->m * (cpsi * p->g_x + spsi * p->g_y);
    w[1] = sp * u[0] + cp * u[1] + p->m * (cpsi * p->g_y - spsi * p->g_x);
    w[2] = r6 * u[0] + r7 * u[1] + c * u[2] + p->m * p->g_z;
    w[3] = r0 * u[3] + r1 * u[4] + r2 * u[5];
    w[4] = sp * u[3] + cp * u[4];
    w[5] = r6 * u[3] + r7 * u[4] + c * u[5];
    equations(p, scales, g, x + 3, w, out);
    const double *G = out, *W = out + 9, *r = out + 18;
    double inertia_gamma = p->m * (dh_c * dh_c + dz_c * dz_c) + p->Ie;
    double inertia_psi = p->m * h_c * h_c + p->Ie * s * s;
    double along_h = p->m * dh_c / inertia_gamma, along_e = p->m * h_c / inertia_psi;
    double along_z = p->m * dz_c / inertia_gamma;
    for (int i = 0; i < 3; i++) {
        double G_psi = G[3 + i] - c * G[6 + i];
        K[i] = W[i] - along_h * G[i];
        K[3 + i] = W[3 + i] - along_e * G_psi;
        K[6 + i] = W[6 + i] - along_z * G[i];
    }
    double c00 = K[4] * K[8] - K[5] * K[7], c10 = K[5] * K[6] - K[3] * K[8];
    double c20 = K[3] * K[7] - K[4] * K[6];
    double determinant = K[0] * c00 + K[1] * c10 + K[2] * c20, over = 1.0 / determinant;
    double i0 = c00 * over, i1 = (K[2] * K[7] - K[1] * K[8]) * over;
    double i2 = (K[1] * K[5] - K[2] * K[4]) * over, i3 = c10 * over;
    double i4 = (K[0] * K[8] - K[2] * K[6]) * over, i5 = (K[2] * K[3] - K[0] * K[5]) * over;
    double i6 = c20 * over, i7 = (K[1] * K[6] - K[0] * K[7]) * over;
    double i8 = (K[0] * K[4] - K[1] * K[3]) * over;
    double og = 1.0 / inertia_gamma, op = 1.0 / inertia_psi, of = 1.0 / p->Iz;
    double free_gamma = r[0] * og, free_psi = (r[1] - c * r[2]) * op;
    double k0 = p->m * dh_c * free_gamma - r[3], k1 = p->m * h_c * free_psi - r[4];
    double k2 = p->m * dz_c * free_gamma - r[5];
    double N0 = i0 * k0 + i1 * k1 + i2 * k2, N1 = i3 * k0 + i4 * k1 + i5 * k2;
    double N2 = i6 * k0 + i7 * k1 + i8 * k2;
    double Qg = r[0] + G[0] * N0 + G[1] * N1 + G[2] * N2;
    double Qp = r[1] + G[3] * N0 + G[4] * N1 + G[5] * N2;
    double Qf = r[2] + G[6] * N0 + G[7] * N1 + G[8] * N2;
    double psi = (Qp - c * Qf) * op;
    y[0] = Qg * og; y[1] = psi; y[2] = Qf * of - c * psi; y[3] = N0; y[4] = N1; y[5] = N2;
    return determinant / (2.0 * g[6] * g[3] / (0.25 * p->D * p->D + g[2] * g[2]));
}

double repeat(const Scene *p, const double *scales, const double *states, long n, double *y) {
    double total = 0.0;
    for (long k = 0; k < n; k++) {
        solve(p, scales, states + 12 * k, states + 12 * k + 6, y);
        for (int i = 0; i < 6; i++) total += y[i];
    }
    return total;
}
"""


@njit(error_model="numpy")
def repeat(p, scales, states, work, y):
    """Return the sum of all answers."""
    total = 0.0
    for k in range(states.shape[0]):
        row = states[k]
        kernel.accelerate(p, scales, row[:6], row[6:], work, y)
        for i in range(6):
            total += y[i]
    return total


def equations_in_c() -> str:
    """Return the generated equations as a function in C."""
    tool = runpy.run_path(str(ROOT / "tools" / "generate_kernel.py"))
    values, _ = tool["contact_stage"]()
    outputs = [(f"out[{i}]", e) for i, e in enumerate(tool["value_outputs"]())]
    names, lines = sp.numbered_symbols("t"), []
    for stage in [*tool["staged"](values), outputs]:
        temporaries, reduced = sp.cse([e for _, e in stage], symbols=names)
        targets = [str(target) for target, _ in stage]
        lines += [f"    double {target} = {_c(e)};" for target, e in temporaries]
        lines += [
            f"    {'' if target.startswith('out') else 'double '}{target} = {_c(e)};"
            for target, e in zip(targets, reduced, strict=True)
        ]
    geometry = [
        "s",
        "c",
        "a1",
        "a2",
        "S1",
        "S2",
        "b",
        "db",
        "h_c",
        "z_c",
        "dh_c",
        "dz_c",
        "ddh_c",
        "ddz_c",
    ]
    taken = [f"double {name} = g[{i}];" for i, name in enumerate(geometry)]
    taken += [f"double {n} = rates[{i}];" for i, n in enumerate(("dgamma", "dpsi", "dphi"))]
    taken += [f"double {n} = w[{i}];" for i, n in enumerate(("Fh", "Fe", "Fz", "Mh", "Me", "Mz"))]
    taken += [f"double scale{i} = scales[{i}];" for i in range(3)]
    taken += [f"double {name} = p->{name};" for name in ("m", "Ie", "Iz", "f", "d", "D")]
    head = (
        "static inline void equations(const Scene *p, const double *scales, const double *g,\n"
        "                             const double *rates, const double *w, double *out) {\n    "
    )
    return head + "\n    ".join(taken) + "\n" + "\n".join(lines) + "\n}\n"


def _c(expression):
    # Small powers as products, as LLVM makes them of Python's.
    return re.sub(
        r"pow\((\w+), (-?)2\)",
        lambda found: f"(1.0/({found[1]}*{found[1]}))" if found[2] else f"({found[1]}*{found[1]})",
        sp.ccode(expression),
    )


def built(folder: Path) -> ctypes.CDLL:
    """Return the library in C."""
    source, library = folder / "kernel.c", folder / "kernel.so"
    head, rest = AROUND.split("\nstatic double solve", 1)
    source.write_text(f"{head}\n{equations_in_c()}\nstatic double solve{rest}")
    subprocess.run(["gcc", *FLAGS, str(source), "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def main(count: int = 1_000_000) -> None:
    """Print a table."""
    rng = np.random.default_rng(0)
    q = np.array([rng.uniform(0.08, 1.2, count), *rng.uniform(-3, 3, (2, count))])
    states = np.vstack([q, rng.uniform(-2, 2, (3, count)), rng.uniform(-5, 5, (6, count))])
    states = np.ascontiguousarray(states.T)
    p, work, y = scene_scalars(Scene()), kernel.workspace(), np.zeros(6)
    scene, scales = np.array(p), np.full(3, 5e-5)
    with tempfile.TemporaryDirectory() as folder:
        in_c = built(Path(folder)).repeat
    in_c.restype = ctypes.c_double
    place = ctypes.POINTER(ctypes.c_double)
    given = [each.ctypes.data_as(place) for each in (scene, scales, states)]
    ways = {
        "C, gcc": lambda: in_c(*given, ctypes.c_long(count), y.ctypes.data_as(place)),
        "numba": lambda: repeat(p, scales, states, work, y),
    }
    repeat(p, scales, states[:2], work, y)
    turns = in_turns(ways, TURNS)
    if not np.isclose(*turns.results.values(), rtol=1e-9):
        raise SystemExit(f"the answers differ: {turns.results}")
    for name in ways:
        print(f"{name:8} {turns.least(name) / count * 1e9:6.0f} ns")
    print(f"numba takes {turns.least('numba') / turns.least('C, gcc'):.2f} times the time of C")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
