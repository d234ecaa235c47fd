"""Reactions that figures and records may take: those that the estimate calls determined."""


def determined_reactions(messages: dict[str, dict]) -> list[float] | None:
    """
    Return the reactions of one stamp, or None where the wrench does not determine them.

    Parameters
    ----------
    messages : dict of str to dict
        Fields of the messages of one stamp, by topic.

    Returns
    -------
    normal : list of float or None
        Of K, B1, B2 [N].

    """
    contacts, monitor = messages.get("contacts"), messages.get("monitor")
    if contacts is None or monitor is None:
        return None
    told = dict(zip(monitor["name"], monitor["position"]))
    return contacts["effort"] if told.get("reactions_determined", 0.0) == 1.0 else None
