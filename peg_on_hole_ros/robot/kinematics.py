"""Where a robot's joints turn and carry the peg, by its URDF and Pinocchio."""

import numpy as np

from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.orientation import RobotJoints
from peg_on_hole_ros.measurements.screws import ScrewChain, TipPoses, tip_poses
from peg_on_hole_ros.robot.urdf_file import Chain, read_chain
from peg_on_hole_ros.robot.urdf_source import named
from peg_on_hole_ros.safe_text import cut, shown
from peg_on_hole_ros.startup.library_output import held_back


def orientation_source(options: JointInput) -> RobotJoints:
    """
    Return what makes an AngleMeasurement of a robot's joint state.

    Parameters
    ----------
    options : JointInput
        With source `robot`: urdf, tip_frame, names and the axes of peg and hole.

    Raises
    ------
    PegOnHoleError
        Pinocchio is not installed, or the description and the options do not fit together.

    """
    chain = read_chain(options)
    return RobotJoints(options, UrdfKinematics(chain, options))


class UrdfKinematics:
    """
    Rotation and place of the tip frame in the root link, and their Jacobian.

    Pinocchio reads the description and gives the screws of the joints; `measurements.screws`
    multiplies them, for thousands of joint states at once.

    Attributes
    ----------
    lower, upper : tuple of n float
        Limits of the joints in joints.names, infinite where there are none [rad].

    """

    def __init__(self, chain: Chain, options: JointInput) -> None:
        pin = _pinocchio()
        said = None
        try:
            # Mimicking joints as joints of their own: Pinocchio follows a leader only where both
            # are of one kind, and the chain knows them all.
            # What it says of meshes and colours is of no use here.
            with held_back(written_after=False) as said:
                model = pin.buildModelFromXML(chain.text)
        except (ValueError, RuntimeError) as error:
            told = said.text.strip() if said else ""
            raise PegOnHoleError(
                f"joints.urdf: {named(options)} is not a valid URDF: "
                f"{cut(' '.join((told or str(error)).split()), 300)}"
            ) from None
        _check_names(pin, model, chain, options)
        self.lower, self.upper = chain.lower, chain.upper
        self._screws = _screws(pin, model, chain, options.tip_frame)

    def poses(self, positions: np.ndarray) -> TipPoses:
        """Return the poses of the tip at positions in the order of joints.names, (s, n)."""
        return tip_poses(self._screws, positions)


def _screws(pin, model, chain: Chain, tip_frame: str) -> ScrewChain:
    """Return the joints of a chain as screws where all are at zero."""
    data = model.createData()
    tip = model.getFrameId(tip_frame, pin.FrameType.BODY)
    # Where a continuous joint is at zero, its cosine is one.
    q = pin.neutral(model)
    columns = pin.computeFrameJacobian(model, data, q, tip, pin.WORLD).reshape(6, -1)
    placement = pin.updateFramePlacement(model, data, tip)
    joints = [model.joints[model.getJointId(name)] for name in chain.moving]
    # Of a velocity Pinocchio has the linear part first.
    screws = np.array([columns[:, joint.idx_v] for joint in joints])
    return ScrewChain(
        screws[:, 3:].copy(),
        screws[:, :3].copy(),
        np.array(chain.source, np.int64),
        np.array(chain.multiplier, float),
        np.array(chain.offset, float),
        placement.rotation.copy(),
        placement.translation.copy(),
    )


def _check_names(pin, model, chain, options):
    """
    Refuse names that Pinocchio's parser reads differently than `read_chain`.

    XML turns a line break or a tab in a name into a space, Pinocchio keeps it; and Pinocchio takes
    every description for UTF-8. For a frame that does not exist it returns an index beyond the
    last one, with which it would read memory out of bounds.
    """
    missing = [f"joint {shown(name)}" for name in chain.moving if not model.existJointName(name)]
    if not model.existFrame(options.tip_frame, pin.FrameType.BODY):
        missing.append(f"link {shown(options.tip_frame)}")
    if missing:
        raise PegOnHoleError(
            f"joints.urdf: Pinocchio finds no {missing[0]} in {named(options)}: line breaks, tabs "
            "and letters of another encoding than UTF-8 are another name to it; give it a plain "
            "name"
        )


def _pinocchio():
    try:
        import pinocchio
    except ImportError as error:
        raise PegOnHoleError(
            f"joints.source robot needs Pinocchio ({error}): pip install pin; beside a native "
            "ROS 2 its package pinocchio"
        ) from None
    if not hasattr(pinocchio, "buildModelFromXML"):
        # On the package index that name is a plugin of a test runner.
        raise PegOnHoleError(
            f"{pinocchio.__file__} is another package of that name, not the rigid-body library: "
            "pip uninstall pinocchio, then pip install pin"
        )
    return pinocchio
