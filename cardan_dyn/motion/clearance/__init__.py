"""Clearance in joints: from rigid forces to impact peaks.

`scanning` opens each joint (`opened_joint`: B bearings and how they give way), takes forces and
where they swing round from a sweep or response (`forces`), and estimates impacts by the
`impact_model`; `planar_motion` follows a pin in its plane. `simulating` moves an `opened_scene`,
`comparing` holds both against each other, `drawing` draws them, `plots` lets results find these
figures.
"""

from . import plots  # noqa: F401  Results draw themselves from here on.
