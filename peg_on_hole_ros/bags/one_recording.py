"""Whether the files of a folder that nothing describes are parts of one recording."""

from collections.abc import Sequence

from peg_on_hole_ros.bags.bag_files import BagFiles
from peg_on_hole_ros.bags.first_pass import Found
from peg_on_hole_ros.errors import BagError

# A recorder that splits may put messages that came together into either file, and leaves no gap
# but that between two messages [ns].
_APART_NS = 1_000_000_000


def check_one_recording(files: BagFiles, scans: Sequence[Found]) -> None:
    """
    Refuse files that no description holds together and that do not follow one another in time.

    A recorder goes on in the next part with the next message. It may have been paused there, so
    a gap is believed where the files are called as it calls them.
    """
    if files.description is not None:
        return
    spans = []
    for scan in scans:
        if scan.blocks:
            first = min(block.first_ns for block in scan.blocks)
            spans.append((first, max(block.last_ns for block in scan.blocks), scan.path.name))
    for (begun, end, before), (begin, last, after) in zip(spans, spans[1:]):
        what = ""
        if begin - end > _APART_NS and not files.named_by_recorder():
            what = f"{after} begins {(begin - end) * 1e-9:.3f} s after {before} has ended"
        elif begun >= last:
            what = f"{after} was recorded before {before}"
        elif end - begin > min(_APART_NS, (last - begin) // 2, (end - begun) // 2):
            what = f"{before} and {after} overlap by {(min(end, last) - begin) * 1e-9:.3f} s"
        if what:
            raise BagError(
                f"{files.path} has no metadata.yaml, and {what}, so they are not parts of one "
                f"recording; {files.remedy()}"
            )
