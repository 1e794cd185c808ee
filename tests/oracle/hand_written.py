"""Chains written by hand, each for one thing that is easy to get wrong."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from chains import Builder, placed, rotation, turn
from scenes import Case

Array = np.ndarray

SIDE = (0.3, 0.4, 0.5)
"""Roll, pitch, yaw of a mount that lies along nothing."""
X, Y, Z = np.eye(3)


def case_of(
    builder: Builder,
    drives: tuple[str, ...],
    positions: Array,
    *,
    speeds: Array | None = None,
    accelerations: Array | None = None,
    held: Mapping[str, float] | None = None,
    gravity: tuple[float, ...] | Array = (0.0, 0.0, 0.0),
    joint_loads: Mapping[str, float] | None = None,
    link_loads: Mapping[str, tuple[Array, Array, str]] | None = None,
    compliance: Mapping[str, Array] | None = None,
) -> Case:
    """Return a case of a chain; it rests unless speeds are given."""
    positions = np.asarray(positions, float)
    rest = np.zeros_like(positions)
    return Case(
        builder.chain(),
        drives,
        dict(held or {}),
        dict(joint_loads or {}),
        dict(link_loads or {}),
        np.array(gravity, float),
        dict(compliance or {}),
        positions,
        rest if speeds is None else rest + speeds,
        rest if accelerations is None else rest + accelerations,
        frozenset(builder.features),
    )


def massive(builder: Builder, name: str, mass: float, centre: tuple[float, float, float]) -> None:
    """Add a link with an inertia that has no symmetry."""
    tensor = np.array([[3.0, 0.2, -0.3], [0.2, 4.0, 0.5], [-0.3, 0.5, 5.0]])
    size = builder.size
    builder.link(
        name, mass, size * np.array(centre), (0.1, -0.2, 0.3), 0.01 * mass * size**2 * tensor
    )


def turntable(builder: Builder) -> Array:
    """Add a table that `swivel` turns; return a frame on it that lies along nothing."""
    massive(builder, "table", 4.0, (0.1, 0.0, 0.2))
    axis = np.array([0.1, -0.2, 1.0])
    builder.joint("swivel", "continuous", "world", "table", np.eye(4), axis)
    return placed(rotation(SIDE), builder.size * np.array([0.2, -0.1, 0.4]))


def four_bar(builder: Builder, base: str, mount: Array) -> None:
    """Add a four-bar `a`, `b`, `c`, `d` in the xy plane of a mount, `c` closing it."""

    def at(x: float, y: float, angle: float) -> Array:
        local = placed(turn(Z, angle), builder.size * np.array([x, y, 0.0]))
        return mount @ local

    massive(builder, "crank", 1.0, (0.1, 0.15, 0.05))
    massive(builder, "coupler", 2.0, (0.4, 0.2, -0.1))
    massive(builder, "rocker", 3.0, (0.1, 0.4, 0.2))
    builder.joint("a", "continuous", base, "crank", at(0.0, 0.0, 0.4))
    builder.joint("b", "continuous", "crank", "coupler", at(0.1, 0.3, -0.3))
    builder.joint("d", "continuous", base, "rocker", at(1.0, 0.0, 1.1))
    builder.loop("c", "continuous", "coupler", "rocker", at(1.1, 0.8, 0.0))


def swivelled_four_bar(swivels: list[float], acting: bool = True) -> Case:
    """A four-bar on a turntable, whose plane turns with it."""
    builder = Builder()
    four_bar(builder, "table", turntable(builder))
    positions = np.array([[swivel, 0.1] for swivel in swivels])
    if not acting:
        return case_of(builder, ("swivel", "a"), positions)
    return case_of(
        builder,
        ("swivel", "a"),
        positions,
        speeds=np.array([1.5, -2.0]),
        accelerations=np.array([-0.7, 3.0]),
        gravity=(1.0, -2.0, -9.0),
        joint_loads={"d": -3.0, "c": 0.7},
        link_loads={"coupler": (np.array([1.0, 5.0, -2.0]), np.array([0.3, 0.1, 0.2]), "link")},
    )


def shared_support(kind: str) -> Case:
    """A tree joint along or about z and a `planar` loop with normal z at the same point."""
    builder = Builder()
    builder.link("slab", 2.0)
    frame = placed(rotation(SIDE), np.array([0.3, 0.2, 0.1]))
    builder.joint("first", kind, "world", "slab", frame, X if kind == "prismatic" else Z)
    builder.loop("second", "planar", "world", "slab", frame, Z)
    gravity = frame[:3, :3] @ np.array([0.0, 0.0, -9.8])
    return case_of(builder, ("first",), np.array([[0.0], [0.2]]), gravity=gravity)


def hung_from_the_world() -> Case:
    """Two bodies, 3 kg and 7 kg, that nothing but a `fixed` loop onto the world carries."""
    builder = Builder()
    builder.link("block", 3.0, (0.1, 0.0, 0.0))
    builder.link("arm", 7.0, (0.5, 0.0, 0.0))
    builder.joint("free", "floating", "world", "block", np.eye(4))
    builder.joint("hinge", "revolute", "block", "arm", placed(np.eye(3), X), Y)
    builder.loop("weld", "fixed", "block", "world", placed(np.eye(3), 2.0 * Z))
    return case_of(builder, ("hinge",), np.array([[0.0], [0.5]]), gravity=(0.0, 0.0, -10.0))


def decided_compliance() -> Case:
    """A plane four-bar that gives only where the laws of motion decide everything."""
    builder = Builder()
    four_bar(builder, "world", placed(rotation(SIDE), np.array([0.2, -0.1, 0.4])))
    soft = 1e-8 * np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    return case_of(
        builder,
        ("a",),
        np.array([[0.0], [0.3], [0.7]]),
        gravity=(1.0, -2.0, -9.0),
        compliance=dict.fromkeys("abcd", soft),
    )


def sliding_chain(factor: float) -> Case:
    """A slider-crank whose slider lies on a table, all lengths times a factor.

    Masses and gravity stay, and time goes with the root of the factor: so do all forces, and
    moments go with the factor.
    """
    builder = Builder(size=factor)
    mount = placed(rotation(SIDE), factor * np.array([0.2, -0.1, 0.4]))

    def at(x: float, y: float, angle: float = 0.0) -> Array:
        return mount @ placed(turn(Z, angle), factor * np.array([x, y, 0.0]))

    massive(builder, "crank", 1.0, (0.1, 0.15, 0.05))
    massive(builder, "rod", 2.0, (0.4, 0.2, -0.1))
    massive(builder, "slider", 3.0, (0.1, 0.0, 0.2))
    massive(builder, "lid", 0.5, (0.0, 0.1, 0.1))
    builder.joint("a", "continuous", "world", "crank", at(0.0, 0.0, 0.2))
    builder.joint("b", "continuous", "crank", "rod", at(0.2, 0.4, -0.3))
    builder.joint("table", "planar", "world", "slider", at(1.3, 0.1, 0.5))
    builder.joint("drawer", "prismatic", "slider", "lid", at(1.4, 0.2), np.array([1.0, 1.0, 1.0]))
    builder.loop("c", "continuous", "rod", "slider", at(1.3, 0.1, 0.3))
    builder.loop("guide", "prismatic", "world", "slider", at(0.5, 0.1), X)
    pace = factor**-0.5
    return case_of(
        builder,
        ("a", "drawer"),
        np.array([[0.0, 0.0], [0.3, 0.1 * factor], [0.6, -0.2 * factor]]),
        speeds=pace * np.array([2.0, 0.5 * factor]),
        accelerations=pace**2 * np.array([-3.0, 0.7 * factor]),
        gravity=(1.0, -2.0, -9.0),
        joint_loads={"b": 0.8 * factor, "guide": 5.0},
    )


def locked_linkage(base: str) -> Case:
    """A four-bar whose crank a coupling locks to a wheel that the scene holds.

    Args:
        base: what carries it, `world` or the `table` that is driven.
    """
    builder = Builder()
    mount = turntable(builder)
    four_bar(builder, base, mount)
    massive(builder, "wheel", 1.5, (0.05, 0.02, 0.1))
    frame = mount @ placed(np.eye(3), np.array([-0.5, 0.2, 0.0]))
    builder.joint("w", "continuous", base, "wheel", frame)
    builder.coupling("mesh", "wheel", "crank", -1.5)
    return case_of(
        builder,
        ("swivel",),
        np.array([[0.0], [0.4], [1.0]]),
        speeds=np.array([1.5]),
        accelerations=np.array([-0.7]),
        held={"w": 0.1},
        gravity=(1.0, -2.0, -9.0),
        joint_loads={"d": -3.0},
    )
