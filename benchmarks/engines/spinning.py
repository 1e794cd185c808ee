"""What the adapters of the free spin share."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ..spin import Spin

ENGINES = ("spin_mujoco", "spin_drake", "spin_exudyn", "spin_sympy", "spin_pinocchio")


@dataclass(frozen=True)
class Spinner:
    """A method to simulate a free spin.

    Attributes:
        name: of the engine.
        version: of the engine.
        settings: how it is set, and what the user does by hand.
        levels: steps per revolution, or relative tolerances, from coarse to fine.
        prepare: takes a spin and a level; returns what simulates it from the start and returns
            the position of the input at the end [rad]. The model is made beforehand.
    """

    name: str
    version: str
    settings: str
    levels: tuple[float, ...]
    prepare: Callable[[Spin, float], Callable[[], float]]

    def labelled(self, level: float) -> str:
        """Return what a level means."""
        return f"{level:g} steps/rev" if level >= 1.0 else f"rtol {level:g}"


def spinners() -> Iterator[Spinner]:
    """Yield the methods of all engines that are installed; say which are not."""
    for name in ENGINES:
        try:
            adapter = importlib.import_module(f"{__package__}.{name}")
        except ImportError as error:
            print(f"{name} is skipped: {error}")
            continue
        yield from adapter.methods()
