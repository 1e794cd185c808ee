"""Loops with joints of every kind about oblique axes, on a body that itself turns."""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd


def link(name: str, mass: float) -> str:
    moments = f'ixx="{mass}" iyy="{1.5 * mass}" izz="{1.2 * mass}" ixy="0.1" ixz="0" iyz="0.05"'
    return (
        f'<link name="{name}"><inertial><origin xyz="0.1 -0.2 {0.05 * mass}"/>'
        f'<mass value="{mass}"/><inertia {moments}/></inertial></link>'
    )


def joint(name: str, kind: str, parent: str, child: str, origin: str, axis: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}" rpy="0.3 -0.2 0.5"/><axis xyz="{axis}"/></joint>'
    )


MIXED = (
    '<robot name="mixed"><link name="base"/>'
    + link("platform", 4.0)
    + joint("turn", "continuous", "base", "platform", "1 2 3", "0.36 0.48 0.8")
    + link("slider", 1.0)
    + joint("slide", "prismatic", "platform", "slider", "0.5 0 0.1", "0.6 0 0.8")
    + link("left", 2.0)
    + joint("swing", "continuous", "slider", "left", "0 0.4 0", "0.8 0.6 0")
    + link("right", 3.0)
    + joint("hinge", "continuous", "platform", "right", "0 -0.3 0.7", "0 0.6 -0.8")
    + '<loop name="ball" type="spherical"><predecessor link="left"><origin xyz="0.2 0.1 0.3" '
    'rpy="0.1 0.2 0.3"/></predecessor><successor link="right"><origin xyz="-0.1 0.2 0.1" '
    'rpy="-0.4 0.1 0.2"/></successor></loop>'
    + '<loop name="cross" type="universal"><predecessor link="right"><origin xyz="0.1 0.3 0" '
    'rpy="0.2 0.1 0.3"/></predecessor><successor link="slider"><origin xyz="0.3 0 0.1"/>'
    '</successor><axis xyz="0 0.6 0.8"/><axis2 xyz="1 0 0"/></loop>'
    + '<loop name="bolt" type="fixed"><predecessor link="left"><origin xyz="0.3 0 0" '
    'rpy="0.2 0 0.1"/></predecessor><successor link="base"><origin xyz="0.7 1.5 2.5" '
    'rpy="0 0.3 0"/></successor></loop></robot>'
)
"""Its loops do not close: it is a chain for kinematics that need no closed loops."""


def rows(mechanism: cd.Mechanism, count: int, seed: int = 0) -> np.ndarray:
    """Return random coordinates `(count, size)` of all joints."""
    rng = np.random.default_rng(seed)
    x = np.repeat(mechanism.coordinates.neutral()[None], count, axis=0)
    model = mechanism.model
    moves = mechanism.coordinates.moves(np.arange(model.nv))
    moves.apply(x, rng.uniform(-1.0, 1.0, (count, model.nv)))
    return x


def moved(
    mechanism: cd.Mechanism, x: np.ndarray, v: np.ndarray, a: np.ndarray, t: float
) -> np.ndarray:
    """Return rows a short time t later: angles and slides exactly, quaternions to third order."""
    coordinates = mechanism.coordinates
    result = x.copy()
    coordinates.moves(np.arange(mechanism.model.nv)).apply(result, t * v + 0.5 * t**2 * a)
    return result
