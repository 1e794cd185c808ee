"""Element efforts: what force elements exert, along all coordinates, one state at a time.

`ElementForces` computes the same for many states at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from ...kit.arrays import Array
from ..mechanism.mechanism import Mechanism
from .element import Element
from .element_forces import ElementForces
from .one_state import ByArrays, OneState

_MANY = 8
"""Linear laws from which on arrays take less time than one after the other."""


class ElementEfforts:
    """Efforts of elements along all coordinates.

    Attributes:
        is_conservative: whether all elements store energy and do nothing else.
        has_functions: whether users' functions say what some exert.
        act_on_links: whether elements act on links, not along coordinates.
        rates: velocity coordinates along which elements act.
        bodies: bodies of the mechanism's model on which elements act.
    """

    def __init__(self, mechanism: Mechanism, elements: Sequence[Element]) -> None:
        """Place the elements.

        Args:
            mechanism: the mechanism.
            elements: checked against it.
        """
        acting = ElementForces(mechanism, elements).acting
        placed = [
            (item, done if hasattr(done, "add") else ByArrays(item, done, mechanism))
            for item, done in zip(elements, acting, strict=True)
        ]
        self._along: list[Any] = [done for item, done in placed if not item.links]
        lines = [line for done in self._along if (line := getattr(done, "line", None))]
        self._has_lines = len(lines) >= _MANY
        if self._has_lines:
            self._along = [done for done in self._along if not getattr(done, "line", None)]
            columns, rates, *self._lines = (np.array(values) for values in zip(*lines, strict=True))
            self._columns, self._rates = columns, rates
        self._on_links: list[Any] = [done for item, done in placed if item.links]
        self.has_functions = any(item.has_functions for item in elements)
        self.is_conservative = all(item.conserves for item in elements)
        self.act_on_links = bool(self._on_links)
        named = mechanism.coordinates.named
        self.rates = {named[name].rate for item in elements for name in item.joints}
        self.bodies = {
            int(mechanism.link_frames[link][0]) for item in elements for link in item.links
        }

    def add_along_coordinates(self, efforts: Array, time: float, x: Array, v: Array) -> None:
        """Add what joint elements exert at a state to efforts `(nv,)`; see `Forces.efforts`."""
        if self._has_lines:
            stiffness, damping, rest = self._lines
            pull = stiffness * (x[self._columns] - rest) + damping * v[self._rates]
            np.subtract.at(efforts, self._rates, pull)
        if self._along:
            state = OneState(time, x, v, x.tolist(), v.tolist())
            for acting in self._along:
                acting.add(efforts, state)

    def add_on_links(
        self,
        efforts: Array,
        model: Any,
        data: Any,
        time: float,
        states: tuple[Array, Array],
        x: Array,
        v: Array,
    ) -> None:
        """Add what elements exert on links to efforts `(nv,)`; see `Forces.on_links`.

        Args:
            efforts: along the velocities of the model.
            model: Pinocchio's.
            data: of the model.
            time: [s].
            states: configuration and velocities of the model.
            x: coordinates of the mechanism.
            v: its velocities.
        """
        if self._on_links:
            pinocchio.forwardKinematics(model, data, *states)
            pinocchio.computeJointJacobians(model, data, states[0])
            state = OneState(time, x, v, x.tolist(), v.tolist(), model, data)
            for acting in self._on_links:
                acting.add(efforts, state)
