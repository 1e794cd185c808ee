"""Descriptions in which joints mimic others, and plain Pinocchio for what they need."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from .linkages import LINK

FINGER = """<robot name="finger"><link name="palm"/>
{links}
<joint name="knuckle" type="continuous"><parent link="palm"/><child link="first"/>
  <origin xyz="0.1 0 0" rpy="0 0 0.3"/><axis xyz="0 1 0"/></joint>
<joint name="middle" type="continuous"><parent link="first"/><child link="second"/>
  <origin xyz="0.4 0 0"/><axis xyz="0 1 0.2"/>{middle}</joint>
<joint name="plunger" type="prismatic"><parent link="second"/><child link="third"/>
  <origin xyz="0.3 0 0.1" rpy="0.1 0.2 0"/><axis xyz="1 0 0"/>
  <limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>{plunger}</joint></robot>"""
"""Three bodies in a row, of which two joints may mimic others."""


def mimic(joint: str, multiplier: float = 1.0, offset: float = 0.0) -> str:
    """Return the element by which a joint mimics another."""
    return f'<mimic joint="{joint}" multiplier="{multiplier!r}" offset="{offset!r}"/>'


def finger(middle: str = "", plunger: str = "") -> str:
    """Return a finger of three bodies whose second and third joint may mimic others."""
    links = "\n".join(
        LINK.format(name=name, com=com, mass=mass)
        for name, com, mass in (
            ("first", "0.2 0.05 0", "1"),
            ("second", "0.1 0 0.05", "2"),
            ("third", "0.05 0.02 0", "0.5"),
        )
    )
    return FINGER.format(links=links, middle=middle, plunger=plunger)


def efforts(text: str, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return the efforts `(3,)` of a finger's joints by Pinocchio, as if all were driven.

    Args:
        text: the finger; Pinocchio's parser knows no couplings.
        q, v, a: `(3,)` coordinates, velocities and accelerations.
    """
    model = pin.buildModelFromXML(text)
    # Continuous joints have the cosine and sine of their angle.
    configuration = [np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1]), q[2]]
    return np.asarray(pin.rnea(model, model.createData(), np.array(configuration), v, a))
