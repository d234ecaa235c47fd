"""Where a robot's joints turn and carry the peg, by its URDF and Pinocchio."""

from collections.abc import Sequence
from math import cos, sin

import numpy as np

from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.orientation import RobotJoints, TipPose
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
    return RobotJoints(options, UrdfKinematics(chain, options))  # type: ignore[arg-type]


class UrdfKinematics:
    """
    Rotation and place of the tip frame in the root link, and their Jacobian, by Pinocchio.

    Attributes
    ----------
    lower, upper : tuple of n float
        Limits of the joints in joints.names, infinite where there are none [rad].

    """

    def __init__(self, chain: Chain, options: JointInput) -> None:
        self._pin = pin = _pinocchio()
        said = None
        try:
            # Mimicking joints as joints of their own: Pinocchio follows a leader only where both
            # are of one kind, and the chain knows them all.
            # What it says of meshes and colours is of no use here.
            with held_back(written_after=False) as said:
                self._model = pin.buildModelFromXML(chain.text)
        except (ValueError, RuntimeError) as error:
            told = said.text.strip() if said else ""
            raise PegOnHoleError(
                f"joints.urdf: {options.urdf} is not a valid URDF, as its parser says: "
                f"{cut(' '.join((told or str(error)).split()), 300)}"
            ) from None
        _check_names(pin, self._model, chain, options)
        self._data = self._model.createData()
        self._tip = self._model.getFrameId(options.tip_frame, pin.FrameType.BODY)
        self._neutral = pin.neutral(self._model).tolist()
        self.lower, self.upper = chain.lower, chain.upper
        joints = [self._model.joints[self._model.getJointId(name)] for name in chain.moving]
        # Place in q, joint that is read, multiplier, offset, and whether the joint is continuous:
        # its position is kept as cosine and sine.
        self._moving = [
            (joint.idx_q, *row, joint.nq == 2)
            for joint, *row in zip(joints, chain.source, chain.multiplier, chain.offset)
        ]
        # Rates of the moving joints from those of the joints that are read.
        self._rates = np.zeros((self._model.nv, len(options.names)))
        for joint, source, multiplier in zip(joints, chain.source, chain.multiplier):
            self._rates[joint.idx_v, source] = multiplier

    def __call__(self, position: Sequence[float]) -> TipPose:
        """Return pose and Jacobian of the tip at positions in the order of joints.names."""
        pin, q = self._pin, self._neutral.copy()
        for i, source, multiplier, offset, continuous in self._moving:
            x = multiplier * position[source] + offset
            if continuous:
                q[i], q[i + 1] = cos(x), sin(x)
            else:
                q[i] = x
        jacobian = pin.computeFrameJacobian(
            self._model, self._data, np.array(q), self._tip, pin.LOCAL_WORLD_ALIGNED
        )
        tip = pin.updateFramePlacement(self._model, self._data, self._tip)
        # Of one joint Pinocchio returns a vector.
        rates = jacobian.reshape(6, -1) @ self._rates
        return TipPose(tip.rotation, rates[3:], tip.translation.copy(), rates[:3])


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
