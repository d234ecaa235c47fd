"""`peg-on-hole compare`: differences between two outputs, stamp by stamp."""

import argparse
import json
import tempfile
from math import isfinite
from pathlib import Path

import numpy as np

from peg_on_hole_ros.bags.estimates import QUANTITIES, Output, same_message
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA
from peg_on_hole_ros.cli.bag_and_configuration import open_bag
from peg_on_hole_ros.cli.output_paths import check_output_paths, write_text
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import finite, table, to_json
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagDamaged, BagError, PegOnHoleError
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.replay.bag_settings import completed_settings
from peg_on_hole_ros.replay.run import stored_configuration
from peg_on_hole_ros.report.comparison_page import Overlay, apart, comparison_page
from peg_on_hole_ros.report.page import library

_WRAPPED = np.array([wraps for _, _, wraps in QUANTITIES])


def run(arguments: argparse.Namespace) -> int:
    """Print a table of differences; exit code 4 if a bag was cut off or damaged."""
    first, second = _names(arguments)
    inputs = filter(None, (arguments.a, arguments.b, arguments.bag))
    check_output_paths(inputs, texts=[arguments.report])
    overlay = None
    if arguments.report:
        library()  # Missing, it is told before the work.
        overlay = Overlay()
    if arguments.bag:
        result, damage, configuration = _two_replays(
            arguments.bag, arguments.a, arguments.b, overlay
        )
    else:
        for name in (arguments.a, arguments.b):
            if Path(name).suffix in (".yaml", ".yml"):
                raise PegOnHoleError(
                    f"{name} is a configuration; to compare two of them, name the bag to replay: "
                    "compare A.yaml B.yaml --bag BAG"
                )
        a, b = open_bag(arguments.a), open_bag(arguments.b)
        result, damage = compare(a, b, first, second, overlay), a.damage or b.damage
        configuration = stored_configuration(a) or Configuration()
    if overlay:
        page = comparison_page(arguments.a, arguments.b, result, overlay, configuration)
        write_text(arguments.report, page)
    print(
        to_json(result) if arguments.json else _comparison_text(result, arguments.a, arguments.b)
    )
    if damage:
        raise BagDamaged(damage)
    return 0


def _names(arguments):
    """Return the names of the nodes whose outputs are meant in A and B, None where not given."""
    given = arguments.prefix or [None]
    if arguments.prefix and arguments.bag:
        raise PegOnHoleError("--prefix chooses among recorded outputs: with --bag there are none")
    if len(given) > 2:
        raise PegOnHoleError(
            f"--prefix is given {len(given)} times: once for both, or for A and for B"
        )
    return given[0], given[-1]


def _two_replays(path, config_a, config_b, overlay):
    from peg_on_hole_ros.cli.replay import replay

    # Both files are checked before the first long run.
    settings = [load(config) for config in (config_a, config_b)]
    bag = open_bag(path)
    with tempfile.TemporaryDirectory(prefix="peg_on_hole_") as folder:
        outputs = []
        for name, (configuration, node) in zip("ab", settings):
            out = Path(folder) / f"{name}.mcap"
            replay(bag, completed_settings(bag, configuration).configuration, node, out=out)
            outputs.append(Bag(out))
        return compare(*outputs, overlay=overlay), bag.damage, settings[0][0]  # type: ignore[arg-type, misc]


def compare(
    a: Bag,
    b: Bag,
    first: str | None = None,
    second: str | None = None,
    overlay: Overlay | None = None,
) -> dict:
    """
    Return the JSON of a comparison, over the stamps that both have.

    Parameters
    ----------
    a, b : Bag
    first, second : str, optional
        Names of the nodes whose outputs are meant, where a bag has those of several.
    overlay : Overlay, optional
        Is given every pair, to be drawn.

    Raises
    ------
    BagError
        One is no output of this package, or has several, or they have no stamp in common.

    """
    first_output, second_output = Output(a, first, rest=True), Output(b, second, rest=True)
    topics = [set(output.topics) for output in (first_output, second_output)]
    pairs = _Pairs([name for name in first_output.topics if name in topics[1]])

    def add(x, y):
        pairs.add(x, y)
        if overlay:
            overlay.add(x, y)

    only_a, only_b = _align(iter(first_output), iter(second_output), add)
    if not pairs.count:
        raise BagError(f"{a.path} and {b.path} have no stamp in common")
    left_out = {
        "incomplete_a": first_output.incomplete,
        "incomplete_b": second_output.incomplete,
        "topics_only_a": sorted(topics[0] - topics[1]),
        "topics_only_b": sorted(topics[1] - topics[0]),
    }
    differs = pairs.differs or only_a > 0 or only_b > 0
    return {
        "stamps": {"common": pairs.count, "only_a": only_a, "only_b": only_b},
        "identical": not differs and not any(left_out.values()),
        "differs": differs,
        **left_out,
        "topics": pairs.topics,
        "quantities": pairs.quantities(),
        "monitor": pairs.monitor(),
        "contact_mode_agrees": pairs.modes / pairs.count,
        "transition_agrees": pairs.transitions / pairs.count,
        "configuration": _configuration_differences(a, b),
    }


def _align(a, b, add):
    """Give pairs of equal stamps to `add`; return how many stamps only one side has."""
    only_a = only_b = 0
    x, y = next(a, None), next(b, None)
    while x is not None and y is not None:
        if x.t_ns == y.t_ns:
            add(x, y)
            x, y = next(a, None), next(b, None)
        elif x.t_ns < y.t_ns:
            only_a += 1
            x = next(a, None)
        else:
            only_b += 1
            y = next(b, None)
    only_a += (x is not None) + sum(1 for _ in a)
    only_b += (y is not None) + sum(1 for _ in b)
    return only_a, only_b


class _Pairs:
    """Sums over pairs of estimates; `topics` are those that both outputs have."""

    def __init__(self, topics):
        size = len(QUANTITIES)
        self.count = self.modes = self.transitions = 0
        self.topics = {name: {"stamps": 0, "differ": 0} for name in topics}
        self._greatest, self._squares = np.zeros(size), np.zeros(size)
        self._sigma_greatest, self._sigma_squares = np.zeros(size), np.zeros(size)
        self._sigma_counts = np.zeros(size, dtype=int)
        self._monitor: dict[str, list] = {}

    def add(self, a, b):
        """Take one pair."""
        difference = b.values - a.values
        turns = np.round(difference / (2 * np.pi))
        difference = np.where(_WRAPPED, difference - 2 * np.pi * turns, difference)
        # A reaction that one of them has not determined differs by no number; `topics` tell.
        difference = np.where(np.isfinite(difference), difference, 0.0)
        size = np.abs(difference)
        self.count += 1
        self._greatest = np.maximum(self._greatest, size)
        self._squares += size**2
        # Of the two predictions the smaller, so that a wide bound hides nothing.
        sigma = np.minimum(a.stddev, b.stddev)
        known = sigma > 0
        relative = np.divide(size, sigma, out=np.zeros_like(size), where=known)
        self._sigma_greatest = np.maximum(self._sigma_greatest, relative)
        self._sigma_squares += relative**2
        self._sigma_counts += known
        self.modes += a.mode == b.mode
        self.transitions += a.transition == b.transition
        for name in a.monitor.keys() & b.monitor.keys():
            size = abs(b.monitor[name] - a.monitor[name])
            if not isfinite(size):
                continue  # does not exist at this moment
            entry = self._monitor.setdefault(name, [0, 0.0, 0.0])
            entry[0] += 1
            entry[1] = max(entry[1], size)
            entry[2] += size**2
        for name, counts in self.topics.items():
            one, other = a.messages.get(name), b.messages.get(name)
            counts["stamps"] += not one is other is None
            counts["differ"] += not same_message(one, other)

    @property
    def differs(self):
        """Whether anything is not the same to the last bit."""
        declared = self.modes == self.transitions == self.count
        return not declared or any(counts["differ"] for counts in self.topics.values())

    def quantities(self):
        """Return the differences of angles, rates, reactions and slip speeds."""
        rows = []
        for i, (name, unit, _) in enumerate(QUANTITIES):
            known = int(self._sigma_counts[i])
            rows.append(
                {
                    "name": name,
                    "unit": unit,
                    "max": finite(self._greatest[i]),
                    "rms": finite(np.sqrt(self._squares[i] / self.count)),
                    "max_in_stddev": finite(self._sigma_greatest[i]) if known else None,
                    "rms_in_stddev": (
                        finite(np.sqrt(self._sigma_squares[i] / known)) if known else None
                    ),
                }
            )
        return rows

    def monitor(self):
        """Return the differences of the monitor's scalars, where both have them."""
        return [
            {"name": name, "stamps": n, "max": finite(high), "rms": finite((total / n) ** 0.5)}
            for name, (n, high, total) in sorted(self._monitor.items())
        ]


def _configuration_differences(a, b):
    first, second = (bag.metadata.get(CONFIGURATION_METADATA, {}) for bag in (a, b))
    if not first or not second:
        return None
    return {
        name: [_value(first.get(name)), _value(second.get(name))]
        for name in sorted(first.keys() | second.keys())
        if first.get(name) != second.get(name)
    }


def _value(text):
    return None if text is None else json.loads(text)


def _comparison_text(result, a, b):
    stamps = result["stamps"]
    lines = [f"A: {a}", f"B: {b}", *_sameness(result)]
    differences = result["configuration"]
    if differences:
        lines += ["", "settings that differ"]
        lines += [f"  {name}: {x} -> {y}" for name, (x, y) in differences.items()]
    lines += [
        "",
        f"stamps in common: {stamps['common']}; only in A: {stamps['only_a']}; "
        f"only in B: {stamps['only_b']}",
        f"contact mode agrees at {100 * result['contact_mode_agrees']:.2f} % of the stamps, "
        f"transition at {100 * result['transition_agrees']:.2f} %",
    ]
    differing, same = apart(result["quantities"])
    numbers, same_numbers = apart(result["monitor"])
    rows = [
        (row["name"], *(quantity(row[k], row["unit"]) for k in ("max", "rms")))
        + tuple(map(_number, (row["max_in_stddev"], row["rms_in_stddev"])))
        for row in differing
    ] + [(row["name"], _number(row["max"]), _number(row["rms"]), "-", "-") for row in numbers]
    if rows:
        head = "difference B - A", "max", "RMS", "max/stddev", "RMS/stddev"
        lines += ["", table(head, rows)]
    if count := len(same) + len(same_numbers):
        every = count + len(rows)
        lines += ["", f"the same in both: {count} of {every} quantities"]
    return "\n".join(lines)


def _sameness(result):
    same = "yes" if result["identical"] else "no" if result["differs"] else "all that both have"
    yield f"bit for bit the same: {same}"
    differing = {name: n["differ"] for name, n in result["topics"].items() if n["differ"]}
    if differing:
        listed = ", ".join(f"{name} at {count}" for name, count in differing.items())
        yield f"  stamps at which messages differ: {listed}"
    for side in "ab":
        incomplete, alone = result[f"incomplete_{side}"], result[f"topics_only_{side}"]
        if incomplete:
            yield f"  not compared: {incomplete} stamps that lack a part in {side.upper()}"
        if alone:
            yield f"  not compared: {', '.join(alone)}, only in {side.upper()}"


def _number(value):
    return "-" if value is None else number(value)
