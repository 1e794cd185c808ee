"""Element forces: what all elements of a scene exert at given motions and times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ..mechanism.mechanism import Mechanism
from .element import Element, ElementForce, Exerted, LinkWrench
from .link_loads import LinkLoad
from .link_motions import LinkMotions

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Acted(NamedTuple):
    """What all elements exert together.

    Attributes:
        efforts: `(N, nv)` along the joint coordinates [N·m, N].
        wrenches: on links, of which some may be named more than once; those on the world are left
            out.
        potential_energy: `(N,)` of springs and bushings [J].
        power: `(N,)` at which all elements do work on the mechanism [W].
        dissipation: `(N,)` power that dampers and friction turn into heat [W], not negative.
    """

    efforts: Array
    wrenches: list[LinkWrench]
    potential_energy: Array
    power: Array
    dissipation: Array

    def link_loads(self, mechanism: Mechanism) -> list[LinkLoad]:
        """Return the wrenches placed in the bodies that carry their links."""
        placed = ((mechanism.link_frames[wrench.link], wrench) for wrench in self.wrenches)
        return [
            LinkLoad(body - 1, frame.rotation, frame.translation, wrench.force, wrench.moment, True)
            for (body, frame), wrench in placed
        ]


class ElementForces:
    """Computes what elements exert on a mechanism.

    Attributes:
        elements: the elements.
        acting: each of them on the mechanism.
    """

    def __init__(self, mechanism: Mechanism, elements: Sequence[Element]) -> None:
        """Find what the elements act on.

        Args:
            mechanism: in which every coordinate that an element names is a turn or a slide, as in
                `Scene.mechanism`.
            elements: the elements, checked against it.
        """
        self.elements = tuple(elements)
        pairs = zip(self.elements, labels(self.elements), strict=True)
        self.acting = tuple(element.on(mechanism, label) for element, label in pairs)
        self._nv = mechanism.model.nv
        links = {link for element in self.elements for link in element.links}
        self._fixed = {link for link in links if mechanism.link_frames[link][0] == 0}
        self._motions = LinkMotions(mechanism, links) if links else None

    def at(self, x: Array, v: Array, time: ArrayLike = 0.0) -> Acted:
        """Return what all elements exert.

        Args:
            x: `(N, size)` coordinates, see `Coordinates`; angles count whole turns.
            v: `(N, nv)` joint velocities [rad/s, m/s].
            time: `(N,)` or a number [s].

        Raises:
            ArgumentError: an element's force is not defined: its points coincide, or it is turned
                too far; or an actuator's function fails.
        """
        efforts = np.zeros((len(x), self._nv))
        wrenches: list[LinkWrench] = []
        energy, power, dissipation = (np.zeros(len(x)) for _ in range(3))
        for done in self.exerted(x, v, time):
            for rate, effort in done.efforts.items():
                efforts[:, rate] += effort
            wrenches += [wrench for wrench in done.wrenches if wrench.link not in self._fixed]
            energy += done.force.energy
            power += done.power
            dissipation += done.force.dissipation
        return Acted(efforts, wrenches, energy, power, dissipation)

    def each(self, x: Array, v: Array, time: ArrayLike = 0.0) -> list[ElementForce]:
        """Return what results show of every element; arguments and errors as of `at`."""
        return [done.force for done in self.exerted(x, v, time)]

    def supplied(self, x: Array, v: Array, time: ArrayLike = 0.0) -> Array:
        """Return the power `(N,)` of actuators, less what dampers and friction take [W].

        Arguments and errors as of `at`.
        """
        power = np.zeros(len(x))
        for element, done in zip(self.elements, self.exerted(x, v, time), strict=True):
            power -= done.force.dissipation
            if element.gives_power:
                power += done.power
        return power

    def exerted(self, x: Array, v: Array, time: ArrayLike = 0.0) -> list[Exerted]:
        """Return what every element exerts, and where; arguments and errors as of `at`."""
        times = np.broadcast_to(np.asarray(time, dtype=float), (len(x),))
        links = self._motions.at(x, v) if self._motions else {}
        return [acting.at(x, v, times, links) for acting in self.acting]


def labels(elements: Sequence[Element]) -> tuple[str, ...]:
    """Return how messages call elements: by their index, class and name."""
    return tuple(
        f"elements[{index}] ({type(element).__name__}{f' {name!r}' if name else ''})"
        for index, element in enumerate(elements)
        for name in [element.name]
    )
