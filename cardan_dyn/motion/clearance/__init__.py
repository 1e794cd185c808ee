"""Clearance in joints: from rigid forces to impact peaks."""

from . import plots  # noqa: F401  Results draw themselves from here on.
