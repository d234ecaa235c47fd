"""
How much noisier than stated a wrench is, and whether it can be used: a module for each reason.

A member has a module here, with the same interface:

A `Record` of the member's name
    What the member remembers from one wrench to the next. A record of zeros has seen no wrench.
`forget(state)`
    Begins anew with the next motion. What is reported to a user stays.
`follow(state, received)`
    Processes a wrench. A `received.Received` is what all members are given.
`factor(state)`
    By how much the variance of the last wrench is larger than stated, at least 1.
`is_off(state)`
    Whether the last wrench must not be used at all, whatever its variance.
`causes(state, variance)`
    What is reported to a user of the sensor, a line each, by the stated variance, shape (6,).

What stands still is a finding, which other findings wait for: `repeated` leaves that to
`diagnosis.suspected.standing_wrench`. `repeated` runs first and has `is_news(state)` as well: a
wrench that repeats the one before it, bit for bit, is followed by no other member. `rough` has
`begin(state)` as well, for when other noise is stated.

`registry` is the only place that lists the members. It multiplies their factors; the variance that
the filter uses, the contacts that are withheld from a wrench that is off, and the causes in
`/diagnostics` follow from it.

To add a member, touch these files: a module here; `registry.py` (a field of `WrenchNoise`, and a
line in each function); and `measurements/tuned.py` (a record of its numbers).
"""
