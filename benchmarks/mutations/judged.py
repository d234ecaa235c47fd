"""Mutants that no test can notice, by name, and why."""

JUDGED: dict[str, str] = {
    "estimator/mixture.py merge: state.alive[g] > 0.0 and state.alive[h] > 0.0 -> "
    "state.alive[h] > 0.0": "A hypothesis that is not alive has no weight, so its friction is no "
    "number, and no loss of a merge with it is less than another: the condition saves time.",
}
