"""Words of MJCF: the elements and attributes that are known, by element.

A word that is not here is refused. If unknown words were passed over, a misspelt `axis` would be
read as the default axis. The lists are those of MuJoCo 4.0 (`mj_printSchema`), and what compilers
from 2.1 on knew besides.
"""

from __future__ import annotations

from collections.abc import Collection
from xml.etree import ElementTree

from ...errors import ModelError, choices

ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
"""Attributes that turn a frame; an element has one of them at most."""


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


SECTIONS = _words(
    "compiler option size visual statistic default extension custom asset worldbody contact "
    "deformable equality tendon actuator sensor keyframe"
)
"""Elements in <mujoco>."""
ACTUATORS = _words(
    "general motor position velocity intvelocity orientation pid damper cylinder muscle adhesion "
    "dcmotor plugin"
)
DEFAULTS = ACTUATORS | _words(
    "default mesh texture material joint geom site camera light pair equality tendon"
)
"""Elements in <default>."""
CONTENTS = _words("inertial joint freejoint geom site camera light body frame")
"""Elements in <body> that are read or may be passed over."""
REFUSED = {
    "attach": "write the attached model into the file",
    "replicate": "write the copies into the file",
    "composite": "write its bodies into the file",
    "flexcomp": "deformable bodies have no joints",
    "plugin": "forces that a plugin makes are unknown here",
}
"""Elements in <body> that change the mechanism and are not read, and what to do."""

_PLACE = f"name pos class {' '.join(ORIENTATIONS)}"
_SHAPE = f"{_PLACE} type size fromto group material mesh rgba user"
_SOFT = "name class active solref solimp"
ATTRIBUTES = {
    tag: _words(words)
    for tag, words in {
        "compiler": "alignfree angle assetdir autolimits balanceinertia boundinertia boundmass "
        "conflict convexhull coordinate discardvisual eulerseq exactmeshinertia fitaabb "
        "fusestatic inertiafromgeom inertiagrouprange meshdir passthrough savecanonical "
        "savecompiled saveinertial settotalmass strippath texturedir usethread",
        "body": f"name pos childclass {' '.join(ORIENTATIONS)} fuse gravcomp mocap simple sleep "
        "user",
        "frame": f"name pos childclass {' '.join(ORIENTATIONS)}",
        "inertial": f"pos mass diaginertia fullinertia {' '.join(ORIENTATIONS)}",
        "joint": "name class type pos axis range limited ref armature damping frictionloss "
        "stiffness springdamper springref springyield actuatorfrclimited actuatorfrcrange "
        "actuatorgravcomp group margin solimpfriction solimplimit solreffriction solreflimit user",
        "freejoint": "name group align",
        "geom": f"{_SHAPE} adhesion castshadow conaffinity condim contype density fitscale "
        "fluidcoef fluidshape friction gap hfield margin mass priority shellinertia solimp "
        "solmix solref surfacevel",
        "site": _SHAPE,
        "connect": f"{_SOFT} body1 body2 anchor site1 site2",
        "weld": f"{_SOFT} body1 body2 anchor relpose torquescale site1 site2",
        "equality": _SOFT,
        "equality joint": f"{_SOFT} joint1 joint2 polycoef",
        "include": "file",
    }.items()
}
"""Element to its attributes, for the elements that are read."""


def check_attributes(element: ElementTree.Element, at: str, kind: str | None = None) -> None:
    """Refuse attributes that an element does not have.

    Args:
        element: it is left alone where `ATTRIBUTES` does not list it.
        at: how messages name it.
        kind: key of `ATTRIBUTES`, if not the tag.
    """
    known = ATTRIBUTES.get(kind or element.tag)
    unknown = set(element.attrib) - known if known else None
    if known and unknown:
        raise ModelError(
            f"{at}: <{element.tag}> has no attribute {choices(unknown)}; attributes: "
            f"{choices(known, min(unknown))}"
        )


def check_children(element: ElementTree.Element, known: Collection[str], at: str) -> None:
    """Refuse elements that do not belong into an element."""
    for child in element:
        if child.tag not in known:
            raise ModelError(
                f"{at}: <{child.tag}> in <{element.tag}> is unknown; elements: "
                f"{choices(known, child.tag)}"
            )


def keyword(value: str, words: Collection[str], at: str) -> str:
    """Return an attribute's value, which must be one of several words."""
    if value not in words:
        raise ModelError(f"{at} is {value!r}, expected one of {', '.join(words)}")
    return value
