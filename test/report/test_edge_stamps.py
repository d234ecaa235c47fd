"""A report of a recording with the first and the last stamps that a header can have."""

import pytest

from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from small_bags import JOINTS, MS, WRENCH, joints, wrench

# Of the seconds of a header, 32 bits with a sign [ns].
FIRST, LAST = -(2**31) * 10**9, (2**31 - 1) * 10**9


def stamped(path, stamp_of):
    with BagWriter(path) as bag:
        for k in range(300):
            t_ns = stamp_of(k)
            bag.write("/wrench", WRENCH, wrench(t_ns), 10**9 + k * MS)
            bag.write("/joint_states", JOINTS, joints(t_ns), 10**9 + k * MS)
    return path


@pytest.mark.parametrize(
    "stamp_of",
    [
        lambda k: 10**9 + k * MS if k != 150 else FIRST,
        lambda k: 10**9 + k * MS if k != 150 else LAST,
        lambda k: FIRST + k * MS if k < 150 else LAST - (300 - k) * MS,
        lambda k: FIRST if k < 150 else LAST,
    ],
    ids=["one first", "one last", "first, then last", "none but these"],
)
def test_a_report_is_made_or_refused_in_a_line(tmp_path, capsys, stamp_of):
    bag, page = stamped(tmp_path / "x.mcap", stamp_of), tmp_path / "x.html"
    code = main(["replay", str(bag), "--report", str(page)])
    error = capsys.readouterr().err
    assert "Traceback" not in error
    if code:
        assert code == 3 and error.startswith("peg-on-hole: error:") and error.count("\n") == 1
    else:
        assert page.stat().st_size > 10_000
