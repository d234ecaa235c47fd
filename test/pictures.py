"""
Pictures of pages as they were last looked at, and how far others are from them.

A picture is kept part by part, each brought to a size of its own, so that a heading that breaks
elsewhere moves nothing below it. `PEG_ON_HOLE_PICTURES=1` writes them anew: look at them then.
"""

import io
import os
from pathlib import Path

import numpy as np
from PIL import Image

KEPT = Path(__file__).parent / "report" / "pictures"
# Size of a part [pixels], and the share of its cells that may change. Words break elsewhere in
# another font; plots and drawings have a size of their own, and letters at their edges alone: a
# line or the arrows that are gone change more (both are tried in the tests).
WORDS, DRAWN = 0.2, 0.008
SIZES = {
    "header": ((400, 60), WORDS),
    "#summary": ((400, 160), WORDS),
    "#tries": ((400, 160), WORDS),
    ".views svg": ((200, 200), DRAWN),
    # The band of modes begins where the page came, which is no matter of its looks.
    ".strip:not(.band)": ((400, 120), DRAWN),
    ".plot": ((400, 170), DRAWN),
}
_CELL = 10
# Of 255, in the mean of a cell.
_CHANGED = 12


def parts(page) -> dict[str, np.ndarray]:
    """Return the parts of a page that stands at its top, each in its size, RGB."""
    whole = Image.open(io.BytesIO(page.screenshot(full_page=True))).convert("RGB")
    found = {}
    for selector, (size, _) in SIZES.items():
        for k, box in enumerate(page.evaluate(_BOXES, selector)):
            x, y, width, height = box
            cut = whole.crop((round(x), round(y), round(x + width), round(y + height)))
            found[f"{selector} {k}"] = np.asarray(cut.resize(size, Image.Resampling.BOX))
    return found


_BOXES = """(selector) => [...document.querySelectorAll(selector)]
  .map((one) => one.getBoundingClientRect())
  .filter((box) => box.width && box.height)
  .map((box) => [box.x + scrollX, box.y + scrollY, box.width, box.height])"""


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Return the share of cells in which two parts of a size differ."""
    difference = np.abs(_cells(one) - _cells(other)).max(axis=-1)
    return float((difference > _CHANGED).mean())


def _cells(part):
    height, width, _ = part.shape
    cut = part[: height // _CELL * _CELL, : width // _CELL * _CELL].astype(float)
    return cut.reshape(height // _CELL, _CELL, width // _CELL, _CELL, 3).mean(axis=(1, 3))


def stacked(found: dict[str, np.ndarray]) -> Image.Image:
    """Return parts below each other, to be kept and looked at."""
    width = max(part.shape[1] for part in found.values())
    sheet = Image.new("RGB", (width, sum(part.shape[0] for part in found.values())), "#808080")
    y = 0
    for part in found.values():
        sheet.paste(Image.fromarray(part), (0, y))
        y += part.shape[0]
    return sheet


def differing(name: str, found: dict[str, np.ndarray]) -> dict[str, float]:
    """
    Return the parts that are not as they were last looked at, with the share of changed cells.

    Parameters
    ----------
    name : str
        Of the picture that is kept.
    found : dict of str to ndarray
        From `parts`.

    """
    path = KEPT / f"{name}.png"
    if os.environ.get("PEG_ON_HOLE_PICTURES"):
        KEPT.mkdir(exist_ok=True)
        stacked(found).quantize(128).save(path, optimize=True)
    kept = np.asarray(Image.open(path).convert("RGB"))
    if kept.shape != np.asarray(stacked(found)).shape:
        return {"the parts are others": 1.0}
    y, shares = 0, {}
    for part_name, part in found.items():
        height, width, _ = part.shape
        shares[part_name] = apart(kept[y : y + height, :width], part)
        y += height
    return {part: share for part, share in shares.items() if share > allowed(part)}


def allowed(part: str) -> float:
    """Return the share of cells of a part that may differ."""
    return SIZES[part.rpartition(" ")[0]][1]
