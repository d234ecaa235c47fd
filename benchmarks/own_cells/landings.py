"""
Drawn cells of one's own whose peg lands upright on the cone of a chamfer before it inserts.

The hole has a chamfer of 45 degrees, which is not stated. The peg comes down 0.2 to 0.5 mm beside
the edge of the bore, slides down the cone for 20 to 110 ms, lifts off, and goes through the cycle
of `own_cells`. Asked: as for `searches`, and whether the friction after it is that of the hole.
"""

from benchmarks.own_cells.beside import LANDING
from benchmarks.own_cells.searches import family

FAMILY = family(LANDING)
