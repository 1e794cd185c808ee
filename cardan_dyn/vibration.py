"""Vibration: periodic motions about a drive at constant speed, and what becomes of small ones.

A scene drives the coordinate that turns at constant speed, and names those that are free;
springs and dampers are among its elements. `scene.simulate(motion={driven: speed})` moves the same
scene over time.
"""

from .motion.vibration.motions.regions import Region
from .motion.vibration.results.campbell import Campbell, campbell
from .motion.vibration.results.critical_speeds import CriticalSpeeds, critical_speeds
from .motion.vibration.results.floquet import Floquet, floquet
from .motion.vibration.results.forced_response import ForcedResponse, forced_response
from .motion.vibration.results.linearisation import Linearisation, linearise
from .motion.vibration.results.periodic_motion import PeriodicMotion, periodic_motion
from .motion.vibration.results.resonance import CriticalSpeed
from .motion.vibration.results.run_up import RunUp, run_up
from .motion.vibration.results.torque_curve import TorqueBarrier

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
