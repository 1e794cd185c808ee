"""Element results: what every force element of a scene exerts at the samples of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..errors import ModelError, choices
from ..frozen import Frozen, read_only

if TYPE_CHECKING:
    from ..elements.element import ElementForce
    from ..elements.element_forces import ElementForces
    from .motion import Motion


class ElementResults(Frozen, Mapping["int | str", "ElementForce"]):
    """Elements to what they exert: by the index in `Scene.elements`, or by name.

    Iteration gives the name of an element, or its index where it has none.
    """

    def __init__(self, forces: ElementForces | None, results: list[ElementForce]) -> None:
        """Keep results.

        Args:
            forces: of the scene; None without elements.
            results: of each of them.
        """
        elements = () if forces is None else forces.elements
        names = [element.name or index for index, element in enumerate(elements)]
        self._results = dict(zip(names, results, strict=True))
        self._indices: dict[object, int | str] = dict(enumerate(names))
        self._made_of = forces, results
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        return ElementResults, self._made_of

    def __getitem__(self, element: int | str) -> ElementForce:
        """Return what an element exerts.

        Raises:
            ModelError: there is no such element.
        """
        try:
            return self._results[self._indices.get(element, element)]
        except (KeyError, TypeError):
            valid = [str(name) for name in self._results]
            listed = f"elements: {choices(valid)}" if valid else "the scene has no elements"
            raise ModelError(f"no element {element!r}; {listed}") from None

    def __contains__(self, element: object) -> bool:
        try:
            return element in self._results or element in self._indices
        except TypeError:
            return False

    def __iter__(self) -> Iterator[int | str]:
        return iter(self._results)

    def __len__(self) -> int:
        return len(self._results)

    def __repr__(self) -> str:
        return f"<ElementResults of {choices([str(name) for name in self]) or 'no elements'}>"


def element_results(forces: ElementForces | None, motion: Motion, time: Array) -> ElementResults:
    """Return what elements exert during a motion.

    Args:
        forces: of the scene; None without elements.
        motion: of N samples.
        time: of any shape that broadcasts with theirs [s].
    """
    if forces is None:
        return ElementResults(None, [])
    times = np.broadcast_to(time, motion.shape).reshape(-1)
    rows = motion.rows
    rates = motion.v.reshape(len(rows), -1)
    return ElementResults(
        forces,
        [
            type(force)(
                *(read_only(values.reshape(*motion.shape, *values.shape[1:])) for values in force)
            )
            for force in forces.each(rows, rates, times)
        ],
    )
