"""Prescribed: what a scene and its results have in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..frozen import Frozen
from ..mechanism.mechanism import Mechanism
from ..problem.problem import Problem

if TYPE_CHECKING:
    from ..elements.element import Element


class Prescribed(Frozen):
    """Something that belongs to a scene."""

    _problem: Problem

    @property
    def problem(self) -> Problem:
        """The checked arguments of the scene: for what is built on scenes and their results."""
        return self._problem

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism, with those balls as turns of which the scene names an angle."""
        return self._problem.mechanism

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of the driven joints and coordinates, whose motion is prescribed."""
        return self._problem.drives

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free joints and coordinates, whose motion is found."""
        return self._problem.free

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the driven, then of the free ones: columns of positions, speeds and efforts."""
        return self._problem.independent

    @property
    def held(self) -> Mapping[str, float]:
        """Held joints and coordinates, and their positions [rad or m]."""
        return self._problem.held

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the joints whose wrenches are results."""
        return self._problem.outputs

    @property
    def elements(self) -> tuple[Element, ...]:
        """Springs, dampers, bushings, friction and actuators."""
        return self._problem.elements
