"""`peg-on-hole plan`: words, JSON, pictures, and what it refuses."""

import json

import pytest

from cli_helpers import ROOT, config, fails
from peg_on_hole_ros.cli.main import main

CELL = ROOT / "config" / "plan_cell.yaml"


def test_the_example_is_planned_in_words_and_written_for_a_robot(tmp_path, capsys):
    out = tmp_path / "plan"
    assert main(["plan", "--config", str(CELL), "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert text.startswith("From a tilt of 0.2 rad, pushing -10 N along h, -30 N along z:\n  1. ")
    assert "begin to turn" in text and "without turning: the peg wedges with a probability" in text
    data = json.loads((out / "plan.json").read_text())
    assert data["possible"] and data["aim"] == "time" and data["remedies"] == []
    assert data["press"] == {"h": -10.0, "e": 0.0, "z": -30.0}
    # A robot that follows the stages from the start comes to gamma0, having turned as stated.
    tilt, rates, turned, time = data["start"]["tilt"], data["start"]["rates"], 0.0, 0.0
    for stage in data["stages"]:
        mean = {k: (rates[k] + stage["rates"][k]) / 2 for k in rates}
        tilt += mean["gamma"] * stage["duration"]
        turned += (abs(mean["psi"]) + abs(mean["phi"])) * stage["duration"]
        time += stage["duration"]
        assert stage["tilt"] == pytest.approx(tilt)
        rates = stage["rates"]
    assert tilt == pytest.approx(0.0632561, abs=1e-6)
    assert turned == pytest.approx(data["turning"]) and time == pytest.approx(data["duration"])
    assert data["plain"]["wedge_probability"] > 0.5 > data["outlook"]["wedge_probability"]
    assert max(data["outlook"]["peak_high"].values()) < 200
    assert (out / "plan.png").read_bytes().startswith(b"\x89PNG")
    picture = (out / "plan.svg").read_text()
    for words in ("closing without turning", "the plan", "limit at K", "wedges"):
        assert words in picture


@pytest.mark.nightly
def test_json_on_stdout_is_that_of_the_file(tmp_path, capsys):
    out = tmp_path / "plan"
    assert main(["plan", "--config", str(CELL), "--out", str(out), "--json"]) == 0
    assert capsys.readouterr().out == (out / "plan.json").read_text()


@pytest.mark.nightly
def test_no_plan_is_an_answer(tmp_path, capsys):
    path = config(tmp_path, "monitor: {max_normal: [80.0, 80.0, 80.0]}")
    assert main(["plan", "--config", str(path), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["possible"] is False and data["outlook"]["overload_probability"] > 0.5
    assert data["remedies"][0].startswith("push with at most ")
    assert main(["plan", "--config", str(path)]) == 0
    text = capsys.readouterr().out
    assert text.startswith("No motion within these limits is safe")
    assert "Each of these changes makes a motion possible: push with at most " in text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "plan: {start_tilt: 0.05}",
            "plan.start_tilt = 0.05 rad is not between gamma0 = 0.0632561 rad and 1.5708 rad, "
            "both excluded: the peg rests on three points between them; gamma0 follows from the "
            "two diameters",
        ),
        (
            "plan: {min_closing_rate: 0.5}",
            "{path}: plan.min_closing_rate = 0.5 rad/s is above plan.max_closing_rate = 0.2 "
            "rad/s; it has to be at most that",
        ),
    ],
)
def test_a_cell_that_contradicts_itself_is_refused(text, message, tmp_path, capsys):
    path = config(tmp_path, text)
    fails(capsys, 2, message.format(path=path), "plan", "--config", path)


def test_a_wrong_parameter_is_refused_with_its_range(tmp_path, capsys):
    path = config(tmp_path, "plan: {aim: speed}")
    message = f"{path}, line 3: plan.aim = 'speed' is not one of time, turning"
    fails(capsys, 2, message, "plan", "--config", path)
    path = config(tmp_path, "plan: {max_slip_rate: 200.0}")
    message = (
        f"{path}, line 3: plan.max_slip_rate = 200 rad/s is not within 0 to 100 rad/s; degrees? "
    )
    message += "200 of them a second are 3.49066 rad/s"
    fails(capsys, 2, message, "plan", "--config", path)


def test_the_configuration_is_not_overwritten(tmp_path, capsys):
    path = tmp_path / "plan.json"
    path.write_bytes(CELL.read_bytes())
    assert main(["plan", "--config", str(path), "--out", str(tmp_path)]) == 2
    assert path.read_bytes() == CELL.read_bytes()
    assert "it is the file that is read" in capsys.readouterr().err
