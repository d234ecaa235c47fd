"""What a bag holds is shown and never obeyed: in a real browser, where it would be."""

import pytest

from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from small_bags import JOINTS, MS, WRENCH, joints, wrench

pytestmark = pytest.mark.xdist_group("browser")

EVIL = "</script><img src=x onerror=document.title='obeyed'>"


def test_names_of_files_and_frames_are_texts(opened, tmp_path):
    name = r"<b onmouseover=1>a$\frac{1}$b.mcap"
    bag, path = tmp_path / name, tmp_path / "r.html"
    with BagWriter(bag) as writer:
        for i in range(200):
            t = 10**9 + i * MS
            writer.write("/joint_states", JOINTS, joints(t), t)
            message = wrench(t, (0.01 * i, 0.0, -10.0))
            message["header"]["frame_id"] = EVIL if i % 2 else "tool0"
            writer.write("/wrench", WRENCH, message, t)
    assert main(["replay", str(bag), "--report", str(path)]) == 0
    shown = opened(path)
    assert shown.page.inner_text("h1") == f"Replay of {name}"
    assert shown.page.title() == f"Replay of {name}"
    # Two frames on one topic are doubtful, and named.
    assert EVIL in shown.page.inner_text(".banner")
    assert shown.page.locator("img, h1 b").count() == 0
