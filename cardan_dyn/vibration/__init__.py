"""Vibration: periodic motions about a drive at constant speed, and what becomes of small ones.

A scene drives the coordinate that turns at constant speed, and names those that are free;
springs and dampers are among its elements. `scene.simulate(motion={driven: speed})` moves the same
scene over time.
"""

from .campbell import Campbell, campbell
from .critical_speeds import CriticalSpeed, CriticalSpeeds, critical_speeds
from .floquet import Floquet, floquet
from .forced_response import ForcedResponse, forced_response
from .linearisation import Linearisation, linearise
from .periodic_motion import PeriodicMotion, periodic_motion
from .regions import Region
from .run_up import RunUp, run_up
from .torque_curve import TorqueBarrier

__all__ = [
    "Campbell",
    "CriticalSpeed",
    "CriticalSpeeds",
    "Floquet",
    "ForcedResponse",
    "Linearisation",
    "PeriodicMotion",
    "Region",
    "RunUp",
    "TorqueBarrier",
    "campbell",
    "critical_speeds",
    "floquet",
    "forced_response",
    "linearise",
    "periodic_motion",
    "run_up",
]
