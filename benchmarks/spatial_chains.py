"""Descriptions of spatial linkages: Bennett's, which is overconstrained, and a slider-crank."""

from __future__ import annotations

import numpy as np

_BAR = (
    '<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="1"/><inertia ixx="{i}" '
    'iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
_HINGE = (
    '<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{at!r} 0 0" rpy="{twist!r} 0 0"/><axis xyz="0 0 1"/></joint>'
)
TWISTS = 1.1, 0.6
"""Angles between neighbouring axes of Bennett's linkage [rad]."""
ROD, CRANK, OFFSET = 1.0, 0.3, 0.2
"""Of the slider-crank [m]: the slider's line passes its crank's axis at the offset."""


def bennett() -> str:
    """Return Bennett's linkage as URDF+: four hinges, three of six closure rows redundant.

    Links of length sin α, sin β, sin α and, the base, sin β [m]; hinge_1 stands on the base.
    """
    alpha, beta = TWISTS
    long, short = float(np.sin(alpha)), float(np.sin(beta))
    text = '<link name="base"/>'
    for name, length in (("link_1", long), ("link_2", short), ("link_3", long)):
        text += _BAR.format(name=name, centre=f"{0.5 * length!r} 0.02 0.03", i="0.04")
    text += _HINGE.format(name="hinge_1", parent="base", child="link_1", at=0.0, twist=0.0)
    text += _HINGE.format(name="hinge_2", parent="link_1", child="link_2", at=long, twist=alpha)
    text += _HINGE.format(name="hinge_3", parent="link_2", child="link_3", at=short, twist=beta)
    text += (
        '<loop name="hinge_4" type="continuous"><predecessor link="link_3">'
        f'<origin xyz="{long!r} 0 0" rpy="{alpha!r} 0 0"/></predecessor><successor link="base">'
        f'<origin xyz="{-short!r} 0 0" rpy="{-beta!r} 0 0"/></successor><axis xyz="0 0 1"/></loop>'
    )
    return f'<robot name="bennett">{text}</robot>'


def bennett_angles(first: float) -> dict[str, float]:
    """Return the angles of the hinges for that of the first [rad]: Bennett (1903).

    tan(θ₁/2) tan(θ₂/2) = sin((α + β)/2) / sin((α − β)/2), for links of length sin of their twist,
    θ₃ = −θ₁ and θ₄ = −θ₂.
    """
    alpha, beta = TWISTS
    ratio = np.sin(0.5 * (alpha + beta)) / np.sin(0.5 * (beta - alpha))
    second = 2.0 * float(np.arctan2(ratio, np.tan(0.5 * first)))
    return {"hinge_1": first, "hinge_2": second, "hinge_3": -first}


def slider_crank() -> str:
    """Return a spatial slider-crank as URDF+: hinge, ball, universal joint and guide.

    The crank turns about z, the guide is parallel to x. At zero the crank points to the slider.
    """
    reach = float(np.sqrt(ROD**2 - OFFSET**2))
    half = f"{0.5 * reach!r} 0 {0.5 * OFFSET!r}"
    text = '<link name="base"/>'
    text += _BAR.format(name="crank", centre=f"{0.5 * CRANK!r} 0.01 0", i="0.01")
    text += _BAR.format(name="rod", centre=half, i="0.08")
    text += _BAR.format(name="slider", centre="0.05 0 0", i="0.01")
    text += _HINGE.format(name="crank_bearing", parent="base", child="crank", at=0.0, twist=0.0)
    text += (
        '<joint name="crank_pin" type="spherical"><parent link="crank"/><child link="rod"/>'
        f'<origin xyz="{CRANK!r} 0 0"/></joint>'
        '<joint name="guide" type="prismatic"><parent link="base"/><child link="slider"/>'
        f'<origin xyz="{CRANK + reach!r} 0 {OFFSET!r}"/><axis xyz="1 0 0"/></joint>'
        f'<loop name="wrist" type="universal"><predecessor link="rod"><origin xyz="{reach!r} 0 '
        f'{OFFSET!r}"/></predecessor><successor link="slider"/><axis xyz="0 1 0"/></loop>'
    )
    return f'<robot name="slider_crank">{text}</robot>'
