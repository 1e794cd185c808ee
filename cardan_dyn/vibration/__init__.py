"""Vibration: periodic motions about a drive at constant speed, and what becomes of small ones.

A scene drives the coordinate that turns at constant speed, and names those that are free;
springs and dampers are among its elements. `scene.simulate(motion={driven: speed})` moves the same
scene over time.
"""

from .motions.regions import Region
from .results.campbell import Campbell, campbell
from .results.critical_speeds import CriticalSpeed, CriticalSpeeds, critical_speeds
from .results.floquet import Floquet, floquet
from .results.forced_response import ForcedResponse, forced_response
from .results.linearisation import Linearisation, linearise
from .results.periodic_motion import PeriodicMotion, periodic_motion
from .results.run_up import RunUp, run_up
from .results.torque_curve import TorqueBarrier

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
