"""What recordings tell of where the hole is: a touched plate, and a run that ends in it."""

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.identification.hole_by_end import HoleByEnd
from peg_on_hole_ros.identification.selection import NORMAL_95
from peg_on_hole_ros.identification.touched_plate import TouchedPlate
from peg_on_hole_ros.identification.tuned import INSERTED_END
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of
from peg_on_hole_ros.setup_steps.knowledge import FOLLOWS, MEASURED, UNKNOWN, Cell, Known


def take_plate(cell: Cell, plate: TouchedPlate, configuration: Configuration, source: str) -> None:
    """Compare the hole as it is stated with the plate around it, or take its direction."""
    R_RH = rotation_from_rpy(configuration.joints.hole_rpy)
    rpy = [float(f"{x:.5g}") for x in rpy_of(R_RH @ _turn_to(plate.normal))]
    doubt = NORMAL_95 * plate.off_stddev
    by = f"{plate.touches} touches of the plate in {source}"
    if not cell.is_given("joints.hole_rpy"):
        cell.put("joints.hole_rpy", rpy, Known(MEASURED, f"+- {doubt:.2g} degrees, {by}"))
    elif plate.off > doubt + INSERTED_END.most_off:
        cell.contradict(
            "joints.hole_rpy",
            f"set {rpy}, unless tip_frame is wrong or the hole is not square to its plate: it is "
            f"{plate.off:.2g} +- {doubt:.2g} degrees off the normal of {by}",
        )
    else:
        cell.add("joints.hole_rpy", f"it fits {by}: {plate.off:.2g} +- {doubt:.2g} degrees off")
    if not cell.is_given("joints.hole_xyz"):
        cell.tell(
            "joints.hole_xyz",
            Known(UNKNOWN, f"state it: {by} determine its direction, not its centre"),
        )
        return
    height = f"{1e3 * abs(plate.above):.2g} mm {'above' if plate.above > 0.0 else 'below'} it"
    if abs(plate.above) > INSERTED_END.most_aside:
        cell.contradict(
            "joints.hole_xyz",
            "correct it, unless peg_xyz or tip_frame is wrong by as much: by "
            f"{by} the plate is {height}",
        )
    else:
        cell.add("joints.hole_xyz", f"it fits {by}: the plate is {height}")


def take_hole(
    cell: Cell, found: HoleByEnd | None, configuration: Configuration, source: str
) -> None:
    """Compare the hole as it is stated with the one in which a run ends, or take that one."""
    names = "joints.hole_rpy", "joints.hole_xyz"
    if found is None:
        for name in names:
            if cell.is_given(name):
                cell.add(name, f"not tested, as {source} does not end in the hole")
        return
    joints = configuration.joints
    R_RH = rotation_from_rpy(joints.hole_rpy)
    rpy = [float(f"{x:.5g}") for x in rpy_of(R_RH @ _turn_to(found.axis))]
    face = found.top + configuration.scene.hole_chamfer * found.axis
    top = R_RH @ face + np.array(joints.hole_xyz)
    xyz = [float(f"{x:.5g}") for x in top]
    by = f"{source} ends {1e3 * found.depth:.3g} mm down the hole"
    if not cell.is_given("joints.hole_rpy"):
        how = f"+- {found.off_bound:.2g} degrees, {by}"
        cell.put("joints.hole_rpy", rpy, Known(MEASURED, how))
    elif found.off > found.off_bound + INSERTED_END.most_off:
        cell.contradict(
            "joints.hole_rpy",
            f"set {rpy}, unless peg_rpy or tip_frame is wrong: {by}, whose axis is "
            f"{found.off:.2g} degrees off it, of which the clearance explains "
            f"{found.off_bound:.2g}",
        )
    else:
        cell.add("joints.hole_rpy", f"it fits: {by}, {found.off:.2g} degrees off it")
    if not cell.is_given("joints.hole_xyz"):
        most = 1e3 * INSERTED_END.most_aside
        how = f"+- {most:g} mm along the hole, {by}"
        cell.put("joints.hole_xyz", xyz, Known(MEASURED, how))
        cell.put("joints.hole_xyz_stddev", INSERTED_END.most_aside, Known(FOLLOWS, by))
        return
    aside, above = found.aside, found.above
    height = f"{1e3 * abs(above):.2g} mm {'above' if above > 0.0 else 'below'}"
    said = f"{by}, which begins {1e3 * aside:.2g} mm beside it and {height}"
    if max(aside, abs(above)) > INSERTED_END.most_aside:
        cell.contradict(
            "joints.hole_xyz",
            f"set {xyz}, unless peg_xyz or tip_frame is wrong by as much: {said}",
        )
    else:
        cell.add("joints.hole_xyz", f"it fits: {said}")


def _turn_to(axis: np.ndarray) -> np.ndarray:
    """Return the shortest rotation that turns z to an axis, shape (3, 3)."""
    x, y, z = axis
    k = 1.0 / (1.0 + z)
    return np.array([[1 - k * x * x, -k * x * y, x], [-k * x * y, 1 - k * y * y, y], [-x, -y, z]])
