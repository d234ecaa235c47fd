"""The rules of the filter that can be switched off, each by one changed place of a source."""

from typing import NamedTuple


class Rule(NamedTuple):
    """
    A rule.

    Attributes
    ----------
    does : str
        In words, as a row of a table.
    file : str
        Of the package; empty: nothing is changed.
    was, becomes : str
        What stands there once, and what in its place switches the rule off.

    """

    does: str
    file: str = ""
    was: str = ""
    becomes: str = ""


KERNEL, FILTERS = "estimation/kernel/", "estimation/filters/"
RULES = {
    "all": Rule("all rules as they are"),
    "adaptation": Rule(
        "the bridged walk follows innovations",
        KERNEL + "bridging.py",
        "ADAPTATION = 0.1",
        "ADAPTATION = 0.0",
    ),
    "leaning": Rule(
        "and how they lean",
        KERNEL + "bridging.py",
        "LEANING = 0.05",
        "LEANING = 0.0",
    ),
    "growth": Rule(
        "the least walk grows with the rates",
        KERNEL + "bridging.py",
        "GROWS = 0.8",
        "GROWS = 0.0",
    ),
    "of_late": Rule(
        "rates are bridged with how they changed of late",
        KERNEL + "acceleration.py",
        "return FOLLOWED * acceleration * acceleration",
        "return 0.0 * acceleration",
    ),
    "beside": Rule(
        "constant rates are followed beside the steps",
        KERNEL + "constant_rates.py",
        "STEADY = 2.0",
        "STEADY = -1.0",
    ),
    "kept": Rule(
        "and kept for 20 ms once taken",
        KERNEL + "cycle.py",
        "KEPT = 0.02",
        "KEPT = 0.0",
    ),
    "kink": Rule(
        "a slip that only a step has turned is not told",
        KERNEL + "prediction.py",
        "if within > 0.0 and not surely and not slow:",
        "if within > 1e300 and not surely and not slow:",
    ),
    "resume": Rule(
        "steps are believed again at 18 deviations, not 4.5",
        KERNEL + "prediction.py",
        "RESUME = 12.0",
        "RESUME = 3.0",
    ),
    "selected": Rule(
        "steps teach friction only where few are not believed",
        KERNEL + "prediction.py",
        "                m[SLIDING] = 0.0\n            add_jump",
        "                pass\n            add_jump",
    ),
    "doubt": Rule(
        "steps whose innovations lean are doubted",
        KERNEL + "lean.py",
        "DOUBTED_ABOVE, TRUSTED_BELOW = 5.5",
        "DOUBTED_ABOVE, TRUSTED_BELOW = 1e9",
    ),
    "runaway": Rule(
        "motions that run away are bridged",
        KERNEL + "runaway.py",
        "FASTEST_GROWTH = 600.0",
        "FASTEST_GROWTH = 1e9",
    ),
    "contact_speed": Rule(
        "contacts gain no speed faster than a held peg's",
        KERNEL + "prediction.py",
        "CONTACT_ACCELERATION = 20.0",
        "CONTACT_ACCELERATION = 1e9",
    ),
    "widening": Rule(
        "friction's kink is widened by the slip's spread",
        "options.py",
        "slip_widening: float = 0.5",
        "slip_widening: float = 0.0",
    ),
    "ramp": Rule(
        "a wrench that changes is a ramp",
        KERNEL + "held_wrench.py",
        "JUMP_LIMIT = 12.6",
        "JUMP_LIMIT = 1e18",
    ),
    "any_time": Rule(
        "what is new of a change came at any time",
        KERNEL + "held_wrench.py",
        "AT_ANY_TIME = 1.0 / 12.0",
        "AT_ANY_TIME = 0.0",
    ),
    "friction_by_balance": Rule(
        "friction is learnt from the balance of forces",
        KERNEL + "balance.py",
        "learns = m[LEARNT] * m[SPREAD] > 0.0 and offsets_are_small(m)",
        "learns = False",
    ),
    "state_by_balance": Rule(
        "angles and rates are, too",
        KERNEL + "balance.py",
        "directed, biased = turned < DIRECTED,",
        "directed, biased = turned < -1.0,",
    ),
    "told_before": Rule(
        "balance is weighed by what the interval before told",
        KERNEL + "balance.py",
        "if told > 0.0:\n        scale",
        "if told > 1e300:\n        scale",
    ),
    "turns_lag": Rule(
        "an acceleration in a turn may be off by twice itself",
        KERNEL + "balance.py",
        "LAGS = 2.0",
        "LAGS = 0.0",
    ),
    "bent": Rule(
        "friction is known no better than a correction moved it",
        KERNEL + "parameters.py",
        "BENT = 0.4",
        "BENT = 0.0",
    ),
    "lag": Rule(
        "nor than it lags",
        KERNEL + "friction_lag.py",
        "LAGS = 0.5",
        "LAGS = 0.0",
    ),
    "rivals": Rule(
        "rival frictions are followed",
        FILTERS + "rivals.py",
        "BEGIN_AT = (-2.0, 2.0)",
        "BEGIN_AT = ()",
    ),
    "sought": Rule(
        "friction that leaves no step is sought below",
        KERNEL + "friction_doubt.py",
        "NOT_LEARNT = 0.9",
        "NOT_LEARNT = 1e9",
    ),
    "forgotten": Rule(
        "and forgotten where it was learnt",
        KERNEL + "friction_doubt.py",
        "LEARNT_WRONG = 0.02",
        "LEARNT_WRONG = 1e9",
    ),
    "misfit": Rule(
        "reactions whose accelerations no held peg has are those of a slow slip",
        KERNEL + "reactions.py",
        "return m[SURPRISE] <= SURPRISE_LIMIT",
        "return m[SURPRISE] <= 1e300",
    ),
    "set_down": Rule(
        "and those of a peg that comes from the air",
        KERNEL + "reactions.py",
        "if m[ON_CONTACTS] > 0.0 and m[SLOW] == 0.0:",
        "if m[SLOW] == 0.0:",
    ),
    "pulls": Rule(
        "of one that pulls friction is as unknown as of one that presses",
        KERNEL + "slow_reactions.py",
        "fabs(m[ANSWERS + 3 + i])",
        "m[ANSWERS + 3 + i]",
    ),
    "slow_surprise": Rule(
        "what does not fit in the balance of a slow slip is widened",
        KERNEL + "slow_reactions.py",
        "growth = max(1.0, m[SURPRISE] / SURPRISE_LIMIT)",
        "growth = 1.0",
    ),
    "carried": Rule(
        "a load leads to expect reactions",
        KERNEL + "slow_reactions.py",
        "        weigh_loads(m, CARRIED * holding, holding, uncertain)\n",
        "",
    ),
    "secant": Rule(
        "reactions with a friction hardly known by a secant",
        KERNEL + "slow_reactions.py",
        "not friction_known_to(m, HARDLY_KNOWN)",
        "not friction_known_to(m, 1e9)",
    ),
    "sideways": Rule(
        "a slip turned sideways has less friction, on the mean",
        KERNEL + "slip.py",
        "TURNED = 0.5",
        "TURNED = 0.0",
    ),
    "unsure": Rule(
        "and by how much is not known",
        KERNEL + "slow_friction.py",
        "UNSURE = 0.5",
        "UNSURE = 0.0",
    ),
}
