"""
Contact sets: which contacts a wrench is weighed with, one module for each.

A member of `contact_set.ContactSet` has a module here, with the same interface:

`SOLVED_REACTIONS` : int
    How many reactions the wrench determines, at most three. They stand behind all other values of
    the mean, from `places.reactions` on, in the places of N_K, N_B1 and N_B2. None: the wrench
    does not correct the motion.
`WRENCH_MAY_DRIVE` : bool
    Whether the wrench alone may drive the motion, as in the method `dde_driven`.
`IN_HOLE` : bool
    Whether the peg is in the hole on K and B, so that the tilt determines how deep it is, and a
    measured depth is a measurement of the clearance. Slips and forces are then those of
    `hole_geometry`, else those on the rim.
`begin_reactions(x, P, first, variance)`
    Gives the reactions their prior in a mean and its covariance: they are new with every wrench.
`linearise(kalman, scene, x, P, mode_stddev)`
    Linearises the balance of forces and couples at a component. It fills in, of `kalman.scratch`,
    `residual` f (6,), its `jacobian` E (6, n + 3) and the covariance `noise` (6, 6), so that
    -f = E (truth - mean) + noise. One that corrects the motion fills in as well
    `direction_noise`, the part of friction whose direction is unknown, and `by_friction`. It takes
    slips and lever arms from its geometry (`rim_geometry`, `hole_geometry`), and returns how far
    the slip may point elsewhere, see `direction.friction_direction_statistics`.

`unknown` has no model, so it has no `linearise`. `registry` is the only place that chooses by
member.

To add a member, touch these files: `contact_set.py` (the member), a module here and its
geometry beside this package, `registry.py` (a line in each function), `fill_estimate.py` and
`forces.py` where neither slips nor forces are those of the rim or of the hole,
`monitor/assessment.py` (when it is chosen), and `test/reference_equations.py` (the same balance
by complex steps, which the compiled one is compared with).
"""
