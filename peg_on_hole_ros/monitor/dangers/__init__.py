"""
Dangers: what may jam the peg within a short time, one module for each.

A member of `registry.Danger` has a module here, with the same interface:

`ADVICE` : (str, str)
    What the alarm `jamming` states at WARN and at ERROR where this danger is the likeliest cause:
    what happens, and what an operator or a program can do about it.
A `Record` of the danger's name
    What the danger remembers from one wrench to the next, and what it found at the last: a
    `probability` within the horizon, and numbers that are published beside it.
`forget(found)`
    Begins anew with the next wrench.
`assess(found, situation)`
    Processes a wrench, and fills in what is found. A `situation.Situation` is what all dangers are
    judged by: the estimate, how the peg moves, and the push that closes it.

`load` has `restart_trends(found)` as well: a course of values so far is no trend to go on.
`registry` is the only place that lists the dangers. The compiled judgement, the risk of any, the
alarm with its texts and numbers, the published row, and what is withheld while a setting is in
doubt follow from it.

To add a danger, touch these files: a module here; `monitor/tuned.py` (a record of its numbers);
`registry.py` (the member of `Danger`, the field of `Dangers`, and a line in `ADVICE`, `PARTS` and
in each function); and `outputs.py` (the entry `jamming_<name>` of the table, with unit and
meaning).
"""
