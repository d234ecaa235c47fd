"""Suspected settings by their members: the one place that lists them."""

from peg_on_hole_ros.diagnosis.suspected.bursts import Bursts
from peg_on_hole_ros.diagnosis.suspected.clock_drift import ClockDrift
from peg_on_hole_ros.diagnosis.suspected.clock_step import ClockStep
from peg_on_hole_ros.diagnosis.suspected.coarse_joints import CoarseJoints
from peg_on_hole_ros.diagnosis.suspected.dead_component import DeadComponent
from peg_on_hole_ros.diagnosis.suspected.delay import Delay
from peg_on_hole_ros.diagnosis.suspected.free_air import FreeAir
from peg_on_hole_ros.diagnosis.suspected.larger_unit import LargerUnit
from peg_on_hole_ros.diagnosis.suspected.late_wrench import LateWrench
from peg_on_hole_ros.diagnosis.suspected.lies_across import LiesAcross
from peg_on_hole_ros.diagnosis.suspected.low_pass import LowPass
from peg_on_hole_ros.diagnosis.suspected.one_setting import OneSetting
from peg_on_hole_ros.diagnosis.suspected.oscillation import Oscillation
from peg_on_hole_ros.diagnosis.suspected.rim_motion import RimMotion
from peg_on_hole_ros.diagnosis.suspected.standing_wrench import StandingWrench
from peg_on_hole_ros.diagnosis.suspected.stated_gravity import StatedGravity
from peg_on_hole_ros.diagnosis.suspected.suspect import Suspect
from peg_on_hole_ros.diagnosis.suspected.twin_joints import TwinJoints
from peg_on_hole_ros.diagnosis.suspected.unobservable import Unobservable
from peg_on_hole_ros.diagnosis.suspected.untaken_zero import UntakenZero
from peg_on_hole_ros.diagnosis.suspected.wrong_wrench import WrongWrench
from peg_on_hole_ros.diagnosis.suspected.zero_jump import ZeroJump

# In the order in which they look at a wrench and report: what makes others unsure comes first.
SUSPECTED: tuple[type[Suspect], ...] = (
    ClockStep, ClockDrift, Bursts, CoarseJoints, TwinJoints, StandingWrench, LateWrench,
    ZeroJump, Oscillation, DeadComponent, LargerUnit, LiesAcross, StatedGravity, WrongWrench,
    UntakenZero, FreeAir, LowPass, RimMotion, OneSetting, Delay, Unobservable,
)  # fmt: skip
