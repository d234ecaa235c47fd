"""Samples that a calibration can use; the rest is counted by a replay's reasons."""

from collections import Counter
from typing import Any

from peg_on_hole_ros.identification.outliers import without_jumps, without_spikes
from peg_on_hole_ros.messages.decode import Malformed
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample


def take_wrench(sample: Any, wrenches: list[WrenchSample], left_out: Counter[str]) -> None:
    """Add a wrench of a bag to others, or count why it is left out."""
    if isinstance(sample, Malformed):
        left_out[f"wrench_dropped_malformed_{sample.reason}"] += 1
    else:
        wrenches.append(sample)


def sound_wrenches(wrenches: list[WrenchSample], left_out: Counter[str]) -> list[WrenchSample]:
    """Return wrenches in the order of their stamps, each once, without spikes."""
    once = _once(wrenches, "wrench", left_out)
    kept = without_spikes(once)
    _count(left_out, "wrench_spike", len(once) - len(kept))
    return kept


def sound_orientations(
    measurements: list[AngleMeasurement], left_out: Counter[str]
) -> list[AngleMeasurement]:
    """Return orientations in the order of their stamps, each once, without those far off."""
    once = _once(measurements, "joints", left_out)
    kept = without_jumps(once)
    _count(left_out, "joints_gated", len(once) - len(kept))
    return kept


def _once(samples, source, left_out):
    """Return samples in the order of their stamps; of two with one stamp the first stays."""
    by_stamp: dict[int, Any] = {}
    for sample in samples:
        by_stamp.setdefault(sample.t_ns, sample)
    _count(left_out, f"{source}_dropped_repeated_stamp", len(samples) - len(by_stamp))
    return [by_stamp[t_ns] for t_ns in sorted(by_stamp)]


def _count(left_out, reason, count):
    if count:
        left_out[reason] += count
