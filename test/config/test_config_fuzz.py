"""Whatever a parameters file holds: an exit code that is documented, and one line for an error."""

import re

import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import PARAMETERS
from peg_on_hole_ros.config.parameters_file import write_parameters

UNFIT = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\ud800-\udfff\u2028\u2029]")
WHOLE = write_parameters({})

nasty = st.sampled_from(
    [
        "[" * 3000, "{" * 3000, "[" * 40 + "]" * 40, "- " * 2000, "? " * 500,
        "!!bool maybe", '!!int ""', "!!float abc", "!!timestamp x", "!!python/object:os.system x",
        "!!binary ~", "!!set {a, b}", "!!omap [a: 1]", "!foo 1", "!!str 0.2", "!!null 1", "!<x> 1",
        "0x" + "f" * 400, "1" * 5000, "0" * 400, "-" + "9" * 400 + ".0", "1e999", "1e-999", "0b1",
        "08", "1_000", "12:30", ".inf", "-.INF", ".nan", "+.5", "infinity", "0x1p3", "١٢",
        "a\0b", "\x1b[31m", "\x85", "\u2028", "\ufeff", "\ud7ff", "\U0001f600", "é", "\x7f",
        "&a 1", "*a", "<<: {a: 1}", "<<", "%YAML 1.1", "--- ", "...", "|", ">-", "'", '"', "\\",
        '"\\x1b[2J"', '"\\ud800"', "#", ":", "- ", "? a", "~", "null", "{}", "[]", "", "\t", "@",
        "~nobody/x", "/dev/zero", "x" * 5000, "y", "No", "true", "[[1.0]]", "[1, 2.0]",
        "{a: {b: c}}", "`",
    ]
)  # fmt: skip
text = st.text(max_size=20) | nasty
value = st.one_of(
    nasty,
    st.integers().map(str),
    st.floats().map(repr),
    st.text(max_size=12),
    st.lists(st.floats(allow_nan=False).map(repr) | nasty, max_size=4).map(
        lambda items: f"[{', '.join(items)}]"
    ),
)
name = st.sampled_from([row.name for row in PARAMETERS]) | st.sampled_from(
    ["scene", "joints", "simulation", "use_sim_time", "qos_overrides./x", "scene.frction", "on"]
)
head = st.sampled_from(
    ["peg_on_hole", "/**", "/*", "/cell/peg_on_hole", "/a/*", "other", "peg_on_hole/x", "**", ""]
)


@st.composite
def stated(draw):
    """A file as people write them, with names of the table and any text for a value."""
    rows = draw(st.lists(st.tuples(name, value), max_size=5))
    lines = [f"    {key}: {text}" for key, text in rows]
    return "\n".join([f"{draw(head)}:", "  ros__parameters:", *lines]) + "\n"


@st.composite
def nested(draw):
    """A file whose groups and names are where they do not belong."""
    keys = st.one_of(name, head, st.just("ros__parameters"), st.text(max_size=4), st.integers())
    leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6)
    tree = draw(
        st.recursive(
            leaves,
            lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=3),
            max_leaves=12,
        )
    )
    under = draw(st.booleans())
    return yaml.safe_dump({"peg_on_hole": {"ros__parameters": tree}} if under else tree)


@st.composite
def spliced(draw):
    """A sound file into which something was put, or of which a piece is missing."""
    begin = draw(st.integers(0, len(WHOLE)))
    end = begin + draw(st.sampled_from([0, 1, 10, 300]))
    return WHOLE[:begin] + draw(text) + WHOLE[end:]


def holds(path, capsys):
    code = main(["solve", "--state", "0.2,0,0,-0.16,0,2", "--config", str(path)])
    out, err = capsys.readouterr()
    assert not UNFIT.search(out) and not UNFIT.search(err)
    *remarks, last = err.splitlines() or [""]
    assert all(line.startswith("configuration: ") for line in remarks)
    assert code in (0, 2), err
    if code:
        assert last.startswith("peg-on-hole: error: ") and "fault of the program" not in last
        assert out == "" and not remarks
        # A value is cut; what else is told has its bounds too.
        assert len(last) < 1500
    return code


def write(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode(errors="replace"))
    return path


def test_files_as_people_write_them(tmp_path_factory, capsys):
    codes = set()

    @given(stated())
    @example("peg_on_hole:\n  ros__parameters:\n    wrench: {acts_on: robot}\n")
    def each(content):
        codes.add(holds(write(tmp_path_factory, content), capsys))

    each()
    assert codes == {0, 2}


def test_files_of_any_structure(tmp_path_factory, capsys):
    @given(nested() | st.binary(max_size=60))
    def each(content):
        holds(write(tmp_path_factory, content), capsys)

    each()


def test_the_whole_file_with_something_in_it(tmp_path_factory, capsys):
    codes = set()

    @settings(max_examples=settings.default.max_examples)
    @given(spliced())
    def each(content):
        codes.add(holds(write(tmp_path_factory, content), capsys))

    each()
    assert codes == {0, 2}
