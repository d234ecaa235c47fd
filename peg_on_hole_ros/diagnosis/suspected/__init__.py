"""
Suspected settings: what may be stated wrongly, one module for each way to find that out.

A member of `registry.SUSPECTED` is a class that derives from `suspect.Suspect`, in a module here:

`NAME` : str
    Names the look in counts: `look_failed_<NAME>` where it fails.
`FINDS` : tuple of (str, str)
    What it finds, and where or when: a line each in the table of docs/integration.md.
`ADOPTS`, `OFFLINE`, `LASTS`, `SPANS_TARE`, `OF_ZERO`, `OF_STAMPS`, `WITHOUT_WRENCH` : bool
    When it looks, and what becomes of its finding; see `suspect`. None is set as a rule.
`__init__(stated)`
    Begins to look, by the settings that are used.
`restart()`
    Forgets what a motion has shown.
`restate(stated)`
    Takes other settings and goes on, where it `LASTS`, or `SPANS_TARE` and that was taken.
`forget_zero()`
    Forgets what it has found of the zero: a tare has taken it.
`take_stamps(of_wrench, t_ns)`, `take_joints(t_ns, positions)`,
`take_every_wrench(t_ns, wrenches)`, `count(wrenches)`, `take(instant, unsure)`,
`take_estimate(t_ns, peg, determined)`, `leave_three_contacts()`
    What it looks at: the stamp of every message, in the order in which they came; what the joints
    read in each joint state, likewise; every wrench that came in order; how many estimates were
    given; one wrench in 20 ms with the orientation; one estimate in 20 ms on three contacts, and
    that there is none. A look has those that it needs, and is called for no others.
`unsure`, `withholds`, `hides` : bool
    Whether nothing sure of contacts can be published now, whether no reactions can be called
    determined, and whether findings of other looks cannot be trusted.
`zero_open_ns` : int
    For how long what a peg at rest reads may have been a zero that nobody has taken, so that a
    tare takes it. 0 as a rule.
`take_zero_jump()`
    By how much the zero has jumped since this was asked last, which is then taken off a wrench.
`explains_joints`, `joints_variance` : bool, float
    Whether it has found what is odd about the values of joint states, and times which the
    variance of an orientation is the stated one. False and 1.0 as a rule.
`reaction_errors` : ndarray or None
    What each setting that the motion cannot determine would cost if it is off, which is published
    as `doubt_*`. None is known as a rule.
`findings()`
    What it has found: a `finding.Finding` each, with the sentence, the fields of WrenchInput with
    the values that fit, and whether these may be used in place of what is stated.

`registry` is the only place that lists them. `engine/settings_against_data.py` walks it in
order: it builds, calls and fences each look, reports and adopts what is found. Counts, causes in
`/diagnostics`, what is withheld in doubt, and the tables of docs/integration.md follow from it.

To add a member, touch these files: a module here, `diagnosis/tuned.py` (a record of its numbers),
and `registry.py` (its line). `make format` writes its lines into docs/integration.md. What else a
wrench may mean (sign, axes, weight, units) is one member, `wrong_wrench`, over the list of
`diagnosis/hypotheses.py`: a line there adds one.
"""
