"""What the adapters share: the closed chain in closed form, and the shape of a method."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

ENGINES = ("pinocchio_by_hand", "sympy_lagrange", "mujoco_engine", "drake_engine", "exudyn_engine")


@dataclass(frozen=True)
class Method:
    """A method to compute D₁, B₁, D₂, B₂ of a universal joint with unit output torque.

    Attributes:
        name: of the engine.
        version: of the engine.
        settings: how it is set, and what the user does by hand.
        prepare: takes the joint angle and input rotations `(N,)`; returns what computes `(N, 4)`.
        samples: greatest number of positions worth the time.
        once: whether preparing takes long and does not depend on the joint angle.
    """

    name: str
    version: str
    settings: str
    prepare: Callable[[float, np.ndarray], Callable[[], np.ndarray]]
    samples: int = 721
    once: bool = False


def engines(module: str = "methods") -> Iterator[Method]:
    """Yield the methods of all engines that are installed; say which are not."""
    for name in ENGINES:
        try:
            adapter = importlib.import_module(f"{__package__}.{name}")
        except ImportError as error:
            print(f"{name} is skipped: {error}")
            continue
        if hasattr(adapter, module):
            yield from getattr(adapter, module)()


def pin_angles(beta: float, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the angles at both pins with which the output shaft lies in its bearing."""
    sine, cosine = np.sin(beta), np.cos(beta)
    return (
        np.arctan2(sine * np.sin(phi), cosine),
        np.arctan2(sine * np.cos(phi), np.hypot(cosine, sine * np.sin(phi))),
    )


def split(moment_1: np.ndarray, moment_2: np.ndarray, beta: float) -> np.ndarray:
    """Return D₁, B₁, D₂, B₂ from moments `(N, 3)` on the cross and on shaft 2, in world axes."""
    axes = np.array([1.0, 0.0, 0.0]), np.array([np.cos(beta), np.sin(beta), 0.0])
    result = []
    for moment, axis in zip((moment_1, moment_2), axes, strict=True):
        result += [moment @ axis, np.linalg.norm(np.cross(moment, axis), axis=1)]
    return np.stack(result, axis=1)
