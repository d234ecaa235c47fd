"""A recording in which the peg stands upright all the time, and error lines of any length."""

from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.records import WrenchSample
from recorded_faults import samples
from simulated import ROOT
from small_bags import JOINTS, WRENCH, joints, wrench

CONFIG = str(ROOT / "config" / "closing_with_slip.yaml")


def test_what_an_upright_peg_shows_of_the_settings_is_refused_in_a_line(tmp_path, capsys):
    bag = tmp_path / "upright.mcap"
    with BagWriter(bag) as writer:
        for sample in samples(ROOT / "bags" / "closing_with_slip.mcap", 0.0, 0.1):
            if isinstance(sample, WrenchSample):
                message = wrench(sample.t_ns, sample.force, sample.torque)
                writer.write("/wrench", WRENCH, message, sample.t_ns)
            else:
                message = joints(sample.t_ns, (0.0, 0.0, 0.0))
                writer.write("/joint_states", JOINTS, message, sample.t_ns)
    assert main(["inspect", str(bag), "--observability", "--config", CONFIG]) in (2, 3)
    lines = [each for each in capsys.readouterr().err.splitlines() if "error" in each]
    assert len(lines) == 1 and "upright" in lines[0]


def test_the_line_of_an_error_ends_however_long_a_name_is(tmp_path, capsys):
    settings = tmp_path / "long.yaml"
    names = ", ".join(["n" * 900_000, "psi", "phi"])
    settings.write_text(f"/**: {{ros__parameters: {{joints: {{names: [{names}]}}}}}}\n")
    bag = str(ROOT / "bags" / "closing_with_slip.mcap")
    assert main(["replay", bag, "--config", str(settings)]) in (2, 3)
    assert max(map(len, capsys.readouterr().err.splitlines())) < 4100
