"""The plots of a report as data: which columns, in which colour, with which bands and limits."""

from typing import NamedTuple

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.records import ANGLES, CONTACTS
from peg_on_hole_ros.report.tracks import LEARNT

_MODE_NOTE = "What the contact was declared to be, from moment to moment."


class Source(NamedTuple):
    """
    Where the lines of a plot come from.

    Attributes
    ----------
    table : str
        Name of a table of columns.
    label : str
        Put after the names of lines; empty: there is one source.
    style : str
        `line`, `second` (of two that are compared), `noise` or `truth`.

    """

    table: str
    label: str = ""
    style: str = "line"


def line(source: Source, column: str, name: str, color: int, band: bool = False) -> dict:
    """Return one line: column `column` of a table, with `_low` and `_high` as a band."""
    return {
        "table": source.table,
        "column": column,
        "name": f"{name} {source.label}".strip(),
        "color": color,
        "style": source.style,
        "band": band,
    }


def level(y: float, name: str, strong: bool = False) -> dict:
    """Return a horizontal line at a limit."""
    return {"y": y, "name": name, "strong": strong}


def panel(name: str, title: str, unit: str, note: str, lines: list[dict], **more: object) -> dict:
    """Return one plot; `more`: levels, log, floor, range, alarms (whether they are marked)."""
    drawn = {"levels": [], "log": False, "alarms": False, "range": None, "floor": 0} | more
    return {"name": name, "title": title, "unit": unit, "note": note, "lines": lines} | drawn


def estimate_panels(
    sources: list[Source], configuration: Configuration, truth: Source | None = None
) -> list[dict]:
    """Return the plots of what outputs hold; `truth` is drawn with tilt, turns and reactions."""
    gamma0, monitor = configuration.scene.gamma0, configuration.monitor

    def lines(names, label="{}", band=True, known=False):
        # Drawn first, so below the estimate.
        shown = [*([truth] if truth and known else []), *sources]
        return [
            line(source, name, label.format(name), color, band and source is not truth)
            for source in shown
            for color, name in enumerate(names)
        ]

    limits = sorted(set(monitor.max_normal))
    risks = {"wedging": 1, "stall": 2, "load": 3}
    return [
        panel(
            "tilt",
            "Tilt",
            "rad",
            "Tilt gamma with its 95 % bounds. Below gamma0 three-point contact has become "
            "two-point contact: the peg is in the hole.",
            lines(ANGLES[:1], known=True),
            levels=[level(gamma0, "gamma0")],
        ),
        panel(
            "turns",
            "Turns",
            "rad",
            "psi about the hole's axis, phi about the peg's own, with their 95 % bounds. A gap: "
            "not determined, as near upright, where only their sum is.",
            lines(ANGLES[1:], known=True),
            range="values",
        ),
        panel(
            "reactions",
            "Normal reactions",
            "N",
            "Reactions at the three contacts with their 95 % bounds, which are cut off at the "
            "plot's edge. A gap: the wrench does not determine them there, or no estimate came.",
            lines(CONTACTS, "N_{}", known=True),
            levels=[level(limit, "limit") for limit in limits],
            range="reactions",
        ),
        {"name": "modes", "title": "Contact mode", "unit": "", "note": _MODE_NOTE, "bands": True},
        panel(
            "risk",
            "Risk of jamming and transition",
            "",
            "Risk of jamming as a whole and by its causes, and the probability of the "
            "transition. Triangles mark alarms.",
            [
                *(line(source, "jamming_risk", "risk", 0) for source in sources),
                *(
                    line(source, f"jamming_{cause}", cause, color)
                    for source in sources
                    for cause, color in risks.items()
                ),
                *(line(source, "transition_probability", "transition", 4) for source in sources),
            ],
            levels=[
                level(monitor.jamming_warn, "WARN"),
                level(monitor.jamming_error, "ERROR", True),
            ],
            alarms=True,
            range="unit",
        ),
        *(
            panel(
                name,
                f"{name.capitalize()} as estimated",
                unit,
                note,
                [line(source, name, name, 0, True) for source in sources],
            )
            for name, unit, note in (
                (LEARNT[0], "", "Coefficient of friction with its 95 % bounds."),
                (LEARNT[1], "µm", "Hole diameter less peg diameter, with its 95 % bounds."),
            )
        ),
    ]


def input_panels(configuration: Configuration) -> list[dict]:
    """Return the plots of what came in, and how it fits."""
    wrench, estimate = Source("wrench"), Source("estimate")
    measured = Source("innovations", style="noise")
    options = configuration.filter
    force, torque = configuration.wrench.force_stddev, configuration.wrench.torque_stddev
    return [
        panel(
            "force",
            "Force as measured",
            "N",
            f"At the sensor, in its axes, as the messages have it; stated noise {force:g} N.",
            [line(wrench, f"F{axis}", f"F{axis}", i) for i, axis in enumerate("xyz")],
        ),
        panel(
            "torque",
            "Torque as measured",
            "N m",
            f"At the sensor, in its axes, as the messages have it; stated noise {torque:g} N m.",
            [line(wrench, f"M{axis}", f"M{axis}", i) for i, axis in enumerate("xyz")],
        ),
        panel(
            "innovations",
            "Innovations",
            "",
            "How far measured orientations are from the estimate, squared, in stated variances: "
            "3 is usual for three angles. Above the gate a measurement is not used.",
            [
                line(measured, "squared", "measured less estimated", 0),
                line(estimate, "nis_median", "median NIS", 1),
                line(estimate, "nis_drift", "drift of NIS", 2),
            ],
            levels=[level(options.gate_threshold, "gate", True), level(3.0, "usual")],
            log=True,
            floor=0.1,
        ),
        panel(
            "intervals",
            "Gaps in the input",
            "ms",
            "Time between one message and the next. Peaks are gaps; above the line they are "
            "counted, and the estimate is widened or restarted.",
            [
                line(Source("wrench_interval"), "interval", "wrench", 0),
                line(Source("joints_interval"), "interval", "joint states", 1),
            ],
            levels=[
                level(options.max_gap * 1e3, "longest gap of the wrench"),
                level(options.max_joint_gap * 1e3, "longest gap of joint states"),
            ],
            log=True,
        ),
    ]


def difference_panels() -> list[dict]:
    """Return the plots of B - A of two outputs, in the smaller of their deviations."""
    source = Source("difference")
    angles, reactions = ANGLES, CONTACTS
    note = "Difference over the smaller of both stated standard deviations."
    return [
        panel(
            "angle_difference",
            "Angles: B - A",
            "stddev",
            note,
            [line(source, name, name, i) for i, name in enumerate(angles)],
        ),
        panel(
            "reaction_difference",
            "Reactions: B - A",
            "stddev",
            note,
            [line(source, name, f"N_{name}", i) for i, name in enumerate(reactions)],
        ),
    ]


def with_data(panels: list[dict], tables: dict[str, dict], mode_rows: int = 1) -> list[dict]:
    """Return the panels with those lines alone whose columns are there, and no empty panel."""
    shown = []
    for one in panels:
        if "bands" in one:
            shown.append(one | {"rows": mode_rows})
            continue
        lines = [at for at in one["lines"] if at["column"] in tables.get(at["table"], {})]
        if lines:
            shown.append(one | {"lines": lines})
    return shown
