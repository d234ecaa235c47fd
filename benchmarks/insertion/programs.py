"""The insertions that are compared with another engine: peg, holder and its program."""

from dataclasses import replace

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.plan import plan_from_tree

SCENE = Scene(hole_diameter=0.050, peg_diameter=0.0496)
# Friction holds what is pressed in along a line from rim to edge: that leans by 0.22.
SCENES = {"wedges": replace(SCENE, friction=0.4)}
HOLDER = {"stiffness": 1e4, "rotational_stiffness": 100.0, "force_limit": 1e3}
# On two points, 20 mm in the hole.
START = {"angles": [0.02, 0.0, 0.0], "rates": [0.0, 0.0, 0.0]}
# On three contacts, 20 mrad above gamma0, pressed on and turning.
ABOVE = {"angles": [0.1465, 0.0, 0.0], "rates": [-0.25, 0.0, 1.5], "offset": [0.0, 0.0, -1e-3]}
# 10 mm in the hole.
HARDLY_IN = {"angles": [0.04, 0.0, 0.0], "rates": [0.0, 0.0, 0.0]}
STARTS = {"goes_in": ABOVE, "wedges": HARDLY_IN}


def _insert(duration, **more):
    return {"kind": "insert", "duration": duration, **more}


PROGRAMS = {
    # Tilted on two points, down to a diameter, turning.
    "slides": {
        "down": _insert(0.25, angles=[0.016, 0.0, 0.3], rates=[0.0, 0.0, 1.0], depth=0.033,
                        depth_rate=0.1),
        "deeper": _insert(0.25, angles=[0.014, 0.0, 0.5], depth=0.052),
    },
    # A side load, then a push that is too small to move the peg under it.
    "jams": {
        "aside": _insert(0.1, place=[-0.002, 0.0]),
        "push": _insert(0.08, depth=0.0213),
        "pushing": _insert(0.1),
    },
    # The same, freed by less side load.
    "is_freed": {
        "aside": _insert(0.1, place=[-0.002, 0.0]),
        "push": _insert(0.08, depth=0.0216),
        "less": _insert(0.1, place=[0.0, 0.0]),
        "rest": _insert(0.1),
    },
    # Tilted against both contacts, let go of, and pushed.
    "wedges": {
        "squeeze": _insert(0.1, angles=[0.06, 0.0, 0.0]),
        "let_go": _insert(0.1, angles=[0.04, 0.0, 0.0]),
        "push": _insert(0.08, depth=0.0112),
        "pushing": _insert(0.1),
    },
    # From three contacts through the transition, 10 mm down the hole.
    "goes_in": {
        "close": _insert(0.12, rates=[-0.25, 0.0, 1.5]),
        "through": _insert(0.15, angles=[0.06, 0.0, 0.4], depth=0.0085),
        "down": _insert(0.1, angles=[0.04, 0.0, 0.45], depth=0.013),
    },
    # Upright and pressed on one wall, 10 mm down along it.
    "along_one_wall": {
        "upright": _insert(0.1, angles=[0.0045, 0.0, 0.0], depth=0.022, place=[0.0015, 0.0]),
        "down": _insert(0.15, angles=[0.0045, 0.0, 0.0], depth=0.032, place=[0.0015, 0.0]),
    },
}  # fmt: skip


def plan_of(name: str, **more):
    """Return the plan of a program, for `simulation.truth.integrate` as well."""
    tree = {"holder": HOLDER, "start": STARTS.get(name, START), "phases": PROGRAMS[name], **more}
    return plan_from_tree(Configuration(scene=SCENES.get(name, SCENE)), tree)
