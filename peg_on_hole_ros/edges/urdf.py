"""Orientation of the peg from a robot's joints, by its URDF and Pinocchio."""

import numpy as np

from peg_on_hole_ros.edges.urdf_file import Chain, read_chain
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.orientation import RobotJoints, TipPose
from peg_on_hole_ros.options import JointInput


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
    Rotation of the tip frame in the root link's axes, and its Jacobian, by Pinocchio.

    Attributes
    ----------
    lower, upper : ndarray, shape (n,)
        Limits of the joints in joints.names, infinite where there are none [rad].

    """

    def __init__(self, chain: Chain, options: JointInput):
        self._pin = pin = _pinocchio()
        try:
            # Mimicking joints as joints of their own: Pinocchio follows a leader only where both
            # are of one kind, and the chain knows them all.
            self._model = pin.buildModelFromXML(chain.text)
        except ValueError:
            raise PegOnHoleError(
                f"joints.urdf: {options.urdf} is not a valid URDF; what is wrong with it stands "
                "above, as its parser said it"
            ) from None
        self._data = self._model.createData()
        self._tip = self._model.getFrameId(options.tip_frame, pin.FrameType.BODY)
        self._neutral = pin.neutral(self._model)
        self.lower, self.upper = np.array(chain.lower), np.array(chain.upper)
        self._source = list(chain.source)
        self._multiplier, self._offset = np.array(chain.multiplier), np.array(chain.offset)
        joints = [self._model.joints[self._model.getJointId(name)] for name in chain.moving]
        # A continuous joint's position is kept as cosine and sine.
        circle = np.array([joint.nq == 2 for joint in joints])
        index_q = np.array([joint.idx_q for joint in joints])
        self._line, self._circle = np.flatnonzero(~circle), np.flatnonzero(circle)
        self._line_q, self._circle_q = index_q[~circle], index_q[circle]
        # Rates of the moving joints from those of the joints that are read.
        self._rates = np.zeros((self._model.nv, len(options.names)))
        for joint, source, multiplier in zip(joints, chain.source, chain.multiplier):
            self._rates[joint.idx_v, source] = multiplier

    def __call__(self, position: np.ndarray) -> TipPose:
        """Return rotation and Jacobian of the tip at positions in the order of joints.names."""
        pin = self._pin
        moving = self._multiplier * position[self._source] + self._offset
        q = self._neutral.copy()
        q[self._line_q] = moving[self._line]
        q[self._circle_q] = np.cos(moving[self._circle])
        q[self._circle_q + 1] = np.sin(moving[self._circle])
        jacobian = pin.computeFrameJacobian(
            self._model, self._data, q, self._tip, pin.LOCAL_WORLD_ALIGNED
        )
        rotation = pin.updateFramePlacement(self._model, self._data, self._tip).rotation
        return TipPose(rotation, jacobian[3:] @ self._rates)


def _pinocchio():
    try:
        import pinocchio
    except ImportError as error:
        raise PegOnHoleError(
            f"joints.source robot needs Pinocchio ({error}): "
            "pip install 'peg_on_hole_ros[urdf]'; beside a native ROS 2 its package pinocchio"
        ) from None
    if not hasattr(pinocchio, "buildModelFromXML"):
        # On the package index that name is a plugin of a test runner.
        raise PegOnHoleError(
            f"{pinocchio.__file__} is another package of that name, not the rigid-body library: "
            "pip uninstall pinocchio, then pip install 'peg_on_hole_ros[urdf]'"
        )
    return pinocchio
