"""What may still be told while a setting of the wrench is in doubt: nothing sure of contacts."""

from peg_on_hole_ros.records import Outputs

_DOUBT = "not judged: the wrench contradicts how it is stated (/diagnostics, filter)"
_RISKS = (
    "jamming_risk",
    "jamming_wedging",
    "jamming_stall",
    "jamming_load",
    "insertion_ratio",
    "whitney_margin",
    "determinant",
    "time_to_transition",
    "time_to_transition_stddev",
)


def unsure(outputs: Outputs, transition: bool) -> Outputs:
    """
    Return outputs without what rests on the wrench.

    Parameters
    ----------
    outputs : Outputs
    transition : bool
        The flag as it was told last: it stays.

    """
    monitor = {name: value for name, value in outputs.monitor.items() if name not in _RISKS}
    monitor["reactions_determined"] = 0.0
    alarms = tuple(alarm._replace(level=0, message=_DOUBT) for alarm in outputs.alarms)
    mode = "open" if outputs.contact_mode == "open" else "unknown"
    return outputs._replace(
        monitor=monitor, contact_mode=mode, transition=transition, alarms=alarms
    )
