"""Bundled mechanisms, one of each kind, for tests that would find the same of those like it."""

EVERY_KIND = (
    "slider_crank",
    "needle_drive",
    "double_shaft_spatial",
    "elastic_thoma_rig",
    "torsional_line_behind",
    "drive_line",
    "stewart_platform",
)
"""Planar and in space, with held coordinates, springs, gears, slides, balls and several drives."""
