"""`peg-on-hole setup`: the settings of a cell, step by step, each with how it is known."""

import argparse
from pathlib import Path

from peg_on_hole_ros.bags.storage.bag_files import bag_files
from peg_on_hole_ros.cli.bag_and_configuration import Reading
from peg_on_hole_ros.cli.output_paths import check_output_paths, write_text
from peg_on_hole_ros.cli.setting_up.bags import SetupBags
from peg_on_hole_ros.cli.setting_up.dialogue import Dialogue
from peg_on_hole_ros.cli.setting_up.steps import RECORDINGS, Steps
from peg_on_hole_ros.cli.setting_up.written_file import known_table, read_known, written
from peg_on_hole_ros.cli.settings import check_path
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.errors import BagDamaged, PegOnHoleError
from peg_on_hole_ros.robot.urdf_source import beside
from peg_on_hole_ros.setup_steps.knowledge import DEFAULT, STATED, Cell, Known
from peg_on_hole_ros.setup_steps.questions import (
    read_answer,
)
from peg_on_hole_ros.startup.exit_codes import INTERRUPTED

_DIAMETERS = ("scene.hole_diameter", "scene.peg_diameter")


def run(arguments: argparse.Namespace) -> int:
    """Lead through the steps, write the file and the table; exit code 2 for a contradiction."""
    _look_in_folder(arguments)
    given = {kind: getattr(arguments, kind) for kind in RECORDINGS if getattr(arguments, kind)}
    cell = _start(arguments)
    read = [file for path in given.values() for file in bag_files(path).read()]
    read += [arguments.config] if arguments.config and not _goes_on(arguments.config) else []
    read += [cell.values["joints.urdf"]] if cell.is_given("joints.urdf") else []
    check_output_paths(read, texts=[arguments.out])
    dialogue = Dialogue(cell, asks=not arguments.yes)
    bags = SetupBags(cell, Reading.of(arguments).most_chunk)
    steps, ended, failed = Steps(cell, dialogue, bags, given), None, None
    try:
        steps.lead_through()
    except EOFError:
        ended = "no more answers"
    except KeyboardInterrupt:
        ended = "interrupted"
    except PegOnHoleError as error:
        if arguments.yes:
            raise
        # What has been answered is not to be answered again.
        ended, failed = "ended by an error", error
    write_text(arguments.out, written(cell, arguments.out))
    _print_result(cell, dialogue, steps.settings(), arguments.out, ended)
    if failed is not None:
        raise failed
    if ended == "interrupted":
        return INTERRUPTED
    if cell.contradictions:
        first, more = cell.contradictions[0], len(cell.contradictions) - 1
        others = f" (and {more} more, above)" if more else ""
        raise PegOnHoleError(
            f"{arguments.out} is written, but a setting is contradicted: {first}{others}"
        )
    if bags.damage:
        raise BagDamaged(bags.damage)
    return 0


def _goes_on(path):
    """Return whether a file is one of `setup`, which may be written anew in its place."""
    return bool(read_known(path))


def _look_in_folder(arguments):
    """Take recordings of a folder where none is given."""
    if arguments.folder is None:
        return
    folder = Path(arguments.folder)
    if not folder.is_dir():
        raise PegOnHoleError(f"there is no folder {folder}: --from names one with recordings")
    for kind in RECORDINGS:
        names = (f"{kind}.mcap", f"{kind}.mcap.zstd", f"{kind}.db3", kind)
        found = next((folder / name for name in names if (folder / name).exists()), None)
        if found and getattr(arguments, kind) is None:
            setattr(arguments, kind, str(found))


def _start(arguments):
    """Return what is stated before the first question."""
    check_path(arguments.config)
    if arguments.config is None:
        cell = Cell({}, "")
    else:
        stated = read_parameters(arguments.config)
        if "joints.urdf" in stated:
            stated["joints.urdf"] = beside(str(stated["joints.urdf"]), [arguments.config])
        known = read_known(arguments.config)
        # What such a file has as a default, nobody has stated.
        kept = {
            name: value
            for name, value in stated.items()
            if name not in known or known[name].kind != DEFAULT
        }
        cell = Cell(kept, arguments.config)
        cell.known |= {name: how.alone() for name, how in known.items() if name in kept}
    for text in arguments.set or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise PegOnHoleError(f"--set {text} is not NAME=VALUE, such as scene.peg_mass=0.35")
        cell.put(name.strip(), read_answer(name.strip(), value), Known(STATED, "by --set"))
    if arguments.urdf is not None:
        cell.put("joints.urdf", arguments.urdf, Known(STATED, "by --urdf"))
    elif arguments.folder is not None and not cell.is_given("joints.urdf"):
        found = sorted(Path(arguments.folder).glob("*.urdf"))
        if len(found) == 1:
            cell.put("joints.urdf", str(found[0]), Known(STATED, "the only one of --from"))
    missing = [name for name in _DIAMETERS if not cell.is_given(name)]
    if missing and arguments.yes:
        raise PegOnHoleError(
            f"gauge bore and shank, and state {' and '.join(missing)}, such as --set "
            f"{missing[0]}=30.00mm: no recording measures the diameters"
        )
    cell.make_room()
    return cell


def _print_result(cell, dialogue, configuration, out, ended):
    dialogue.say(f"\n{known_table(cell, configuration)}")
    not_known = cell.open_settings()
    for line in not_known:
        dialogue.say(f"not known: {line}")
    for each in cell.contradictions:
        dialogue.say(f"contradicted: {each}")
    if ended:
        dialogue.say(
            f"{ended}: what was found is kept in {out}; continue with `peg-on-hole setup --config "
            f"{out}`"
        )
        return
    dialogue.say(f"written: {out}; use it with `peg-on-hole replay BAG --config {out}`")
    if not_known:
        many = "1 setting is" if len(not_known) == 1 else f"{len(not_known)} settings are"
        dialogue.say(
            f"{many} not known (above), and the defaults used may be wrong: state or record "
            f"what is missing, and continue with `peg-on-hole setup --config {out}`"
        )
