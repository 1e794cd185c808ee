"""A spatial four-bar whose rod has a ball at each end, written in three ways."""

from __future__ import annotations

import numpy as np

FIRST, SECOND = np.array([0.3, 0.0, 0.0]), np.array([1.0, 0.2, 0.7])
ALONG = SECOND - FIRST
LINE = ALONG / np.linalg.norm(ALONG)
SLENDER = 0.04 * (np.eye(3) - np.outer(LINE, LINE)) + 0.01 * np.outer(LINE, LINE)
"""Inertia `(3, 3)` of a rod that is the same in all directions across its line [kg·m²]."""


def link(name: str, mass: float, centre: str, inertia: np.ndarray) -> str:
    moments = " ".join(
        f'{word}="{float(inertia[i, j])!r}"'
        for word, i, j in (
            *(("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2)),
            *(("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2)),
        )
    )
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass!r}"/>'
        f"<inertia {moments}/></inertial></link>"
    )


def hinge(name: str, parent: str, child: str, origin: str, axis: str) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}"/><axis xyz="{axis}"/></joint>'
    )


def words(vector: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in vector)


def base(inertia: np.ndarray = SLENDER, centre: np.ndarray = 0.5 * ALONG) -> str:
    """Crank a about z, rocker d about y, and the rod, whose frame is at the crank's tip."""
    plain = np.diag([0.002, 0.03, 0.03])
    return (
        '<link name="ground"/>'
        + link("crank", 1.0, "0.15 0 0", plain)
        + link("rocker", 2.0, "0 0 0.3", plain)
        + link("rod", 1.5, words(centre), inertia)
        + hinge("a", "ground", "crank", "0 0 0", "0 0 1")
        + hinge("d", "ground", "rocker", "1 0.2 0.1", "0 1 0")
    )


CLOSING_BALL = (
    f'<loop name="c" type="spherical"><predecessor link="rod"><origin xyz="{words(ALONG)}"/>'
    '</predecessor><successor link="rocker"><origin xyz="0 0 0.6"/></successor></loop>'
)


def as_balls(**options: np.ndarray) -> str:
    return (
        f'<robot name="balls">{base(**options)}<joint name="b" type="spherical">'
        '<parent link="crank"/><child link="rod"/><origin xyz="0.3 0 0"/></joint>'
        f"{CLOSING_BALL}</robot>"
    )


def as_a_floating_rod(**options: np.ndarray) -> str:
    return (
        f'<robot name="floating">{base(**options)}<joint name="b" type="floating">'
        '<parent link="ground"/><child link="rod"/><origin xyz="0.3 0 0"/></joint>'
        '<loop name="e" type="spherical"><predecessor link="crank"><origin xyz="0.3 0 0"/>'
        f'</predecessor><successor link="rod"/></loop>{CLOSING_BALL}</robot>'
    )


def as_hinges(**options: np.ndarray) -> str:
    """Three hinges per ball with massless links between them, as CAD exporters write them."""
    links = "".join(f'<link name="{name}"/>' for name in ("x1", "x2", "y1", "y2", "tip"))
    first = (
        hinge("b1", "crank", "x1", "0.3 0 0", "1 0 0")
        + hinge("b2", "x1", "x2", "0 0 0", "0 1 0")
        + hinge("b3", "x2", "rod", "0 0 0", "0 0 1")
    )
    second = (
        hinge("c1", "rod", "y1", words(ALONG), "1 0 0")
        + hinge("c2", "y1", "y2", "0 0 0", "0 1 0")
        + hinge("c3", "y2", "tip", "0 0 0", "0 0 1")
    )
    return (
        f'<robot name="hinges">{base(**options)}{links}{first}{second}'
        '<loop name="c" type="fixed"><predecessor link="tip"/><successor link="rocker">'
        '<origin xyz="0 0 0.6"/></successor></loop></robot>'
    )


WAYS = {"balls": as_balls, "floating": as_a_floating_rod, "hinges": as_hinges}
