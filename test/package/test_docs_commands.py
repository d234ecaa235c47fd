"""Every command in README and docs: what can be run is run, page by page, as a reader would."""

import re
import runpy
import shlex
import sys

import pytest

from cli_helpers import ROOT, reader
from peg_on_hole_ros.cli.arguments import parser

# The tutorial begins: what later pages repeat of it has been run.
PAGES = [
    ROOT / "docs" / "tutorial.md",
    *(ROOT / name for name in ("README.md", "SECURITY.md", "CONTRIBUTING.md", "bags/README.md")),
    *sorted({*(ROOT / "docs").rglob("*.md")} - {ROOT / "docs" / "tutorial.md"}),
    *sorted((ROOT / "benchmarks").rglob("README.md")),
]
COMMAND = re.compile(r"^(?:    |> )?((?:peg-on-hole|sed|make) (?:.*\\\n.*)*.*)$", re.M)
INLINE = re.compile(r"`(peg-on-hole \w[^`]*)`")
SCRIPT = re.compile(r"python (?:-m )?(benchmarks(?:[./][\w./]+| [a-z]\w*))((?: \[?-[^`\n]*)?)")
# What runs for as long as one looks, for minutes, or on a cluster: the tests that run it.
ELSEWHERE = {
    "peg-on-hole watch": "report/test_live_page.py",
    "peg-on-hole node": "node/test_node.py",
    "peg-on-hole play": "node/test_play.py",
    "peg-on-hole setup": "cli/test_cli_setup.py",
    "peg-on-hole calibrate bags/setup_cell": "package/test_guide.py",
    "peg-on-hole replay bags/setup_cell": "package/test_guide.py",
    "peg-on-hole replay bags/cell_ur_like.mcap": "package/test_guide.py",
    "peg-on-hole choose --config config/plan_cell.yaml": "cli/test_cli_choose.py",
    "peg-on-hole chart --out chart": "benchmarks/test_chart.py",
    "peg-on-hole stability --out stability": "benchmarks/test_stability.py",
    "peg-on-hole replay /data/recordings --dask": "many_bags/test_many_bags.py",
    "peg-on-hole simulate --config config/working_cycle.yaml": "sim/test_simulated_bag.py",
    "make run": "cli/test_demo.py",
}


def commands(page):
    text = page.read_text(encoding="utf-8")
    return [found.replace("\\\n", " ").strip() for found in COMMAND.findall(text)]


def elsewhere(line):
    return next((test for begin, test in ELSEWHERE.items() if line.startswith(begin)), None)


EVERY = list(dict.fromkeys(line for page in PAGES for line in commands(page)))
RUN = [line for line in EVERY if not elsewhere(line) and not line.startswith("make")]
SHAPES = sorted({line for page in PAGES for line in INLINE.findall(page.read_text())})
SCRIPTS = sorted({found for page in PAGES for found in SCRIPT.findall(page.read_text())})


def shape(line):
    """Return the words of a command as its parser has them, without what may be left out."""
    bare = re.sub(r"\s(?:\[.*|>.*|#.*)$", "", line)
    return [word for word in shlex.split(bare)[1:] if word != "..."]


def test_there_are_commands_to_test():
    assert len(RUN) > 12 and len(SHAPES) > 5 and len(SCRIPTS) > 8
    for test in ELSEWHERE.values():
        assert (ROOT / "test" / test).exists(), test


@pytest.mark.parametrize("line", [line for line in EVERY if line.startswith("peg")] + SHAPES)
def test_each_command_is_understood(line):
    words = shape(line)
    if "COMMAND" in words:
        return
    # One that stands in a sentence may name no more than the command.
    names = parser()._subparsers._group_actions[0].choices
    assert words[0] in names
    if len(words) > 1:
        assert parser().parse_args(words).command == words[0]


@pytest.mark.parametrize("line", [line for line in EVERY if line.startswith("make")])
def test_each_target_exists(line):
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert re.search(rf"^{line.split()[1]}:", text, re.M)


@pytest.mark.filterwarnings("ignore:.*found in sys.modules")
@pytest.mark.parametrize(("module", "options"), SCRIPTS)
def test_each_script_has_its_options(module, options, monkeypatch, capsys):
    name, *family = module.removesuffix(".py").replace("/", ".").rstrip(".").split(" ")
    path = ROOT / name.replace(".", "/")
    if path.is_dir() and not family:
        return
    path = path / "__main__.py" if family else path.with_suffix(".py")
    told = path.read_text(encoding="utf-8")
    if "ArgumentParser" in told:
        monkeypatch.setattr(sys, "argv", [name, *family, "--help"])
        with pytest.raises(SystemExit) as ended:
            runpy.run_module(name, run_name="__main__")
        assert ended.value.code in (0, None)
        told = capsys.readouterr().out
    for option in re.findall(r"--[\w-]+", options):
        assert option in told, f"{name} {option}"


# What a newcomer reads first; what takes long of it, and all other pages, at night.
LONG = ("peg-on-hole calibrate", "peg-on-hole simulate", "peg-on-hole replay my.mcap")
FIRST = [line for line in commands(PAGES[0]) if line in RUN and not line.startswith(LONG)]


@pytest.fixture(
    scope="module",
    params=[FIRST, pytest.param(RUN, marks=pytest.mark.nightly)],
    ids=["tutorial", "all"],
)
def told(request, tmp_path_factory):
    """Run commands in one folder, in the order in which they are read."""
    lines = list(dict.fromkeys(request.param))
    folder = tmp_path_factory.mktemp("reader")
    run = reader(folder)
    # Of `bags/` as many as the pages name.
    (folder / "bags").unlink()
    (folder / "bags").mkdir()
    for name in {name for line in lines for name in re.findall(r"bags/(\w+\.mcap)", line)}:
        (folder / "bags" / name).symlink_to(ROOT / "bags" / name)
    found = {line: run(line) for line in lines}
    return folder, found


def test_every_command_does_what_it_says(told):
    folder, found = told
    made = {path.name for path in folder.iterdir()}
    for line in found:
        for place in re.findall(r"(?:--out|--report|--summary|>) ([\w./]+)", line):
            assert place.split("/")[0] in made, line


def test_the_tutorial_tells_what_it_promises(told):
    folder, found = told
    # The setting was found in the file, and has an effect.
    assert "friction: 0.1" in (folder / "half.yaml").read_text(encoding="utf-8")
    compared = next(text for line, text in found.items() if "compare whole.mcap" in line)
    assert "scene.friction" in compared
    replayed = next(text for line, text in found.items() if "replay bags/working_cycle" in line)
    assert "aborted" in replayed and "inserted" in replayed
