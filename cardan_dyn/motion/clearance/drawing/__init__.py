"""Drawing: figures of scans and of simulations with clearance."""

from .contact_course import contact_course
from .force_reversals import force_reversals
from .impact_ranking import impact_ranking
from .peak_factor import peak_factor
from .peak_influence import peak_influence
from .pin_bearings import pin_forces, pin_peaks
from .pin_orbit import pin_orbit

__all__ = [
    "contact_course",
    "force_reversals",
    "impact_ranking",
    "peak_factor",
    "peak_influence",
    "pin_forces",
    "pin_orbit",
    "pin_peaks",
]
