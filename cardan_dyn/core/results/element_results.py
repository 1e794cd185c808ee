"""Element results: what every force element of a scene exerts at the samples of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from ...kit.frozen import Frozen, read_only

if TYPE_CHECKING:
    from ..elements.element import Element, ElementForce
    from ..problem.problem import Problem


class ElementResults(Frozen, Mapping["int | str", "ElementForce"]):
    """Elements to what they exert: by the index in `Scene.elements`, or by name.

    Iteration gives the name of an element, or its index where it has none.
    """

    def __init__(self, elements: Sequence[Element], results: Sequence[ElementForce]) -> None:
        """Keep the results of elements."""
        names = [element.name or index for index, element in enumerate(elements)]
        self._results, self._made_of = dict(zip(names, results, strict=True)), (elements, results)
        self._indices: dict[object, int | str] = dict(enumerate(names))
        self._freeze()

    @classmethod
    def of(
        cls, problem: Problem, x: Array, v: Array, time: Array, shape: tuple[int, ...]
    ) -> ElementResults:
        """Return what the elements of a scene exert at states.

        Args:
            problem: of the scene.
            x: coordinates `(N, size)`, all turns counted.
            v: velocities `(N, nv)`.
            time: which broadcasts with the shape [s].
            shape: of the N samples.
        """
        forces = problem.element_forces
        if forces is None:
            return cls((), ())
        each = forces.each(x, v, np.broadcast_to(time, shape).reshape(-1))
        return cls(
            forces.elements,
            [
                type(of)(*(read_only(part.reshape(*shape, *part.shape[1:])) for part in of))
                for of in each
            ],
        )

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
            valid = [str(name) for name in self]
            listed = f"elements: {choices(valid)}" if valid else "the scene has no elements"
            raise ModelError(f"no element {element!r}; {listed}") from None

    def __contains__(self, element: Any) -> bool:
        with suppress(ModelError):
            return bool(self[element])
        return False

    def __iter__(self) -> Iterator[int | str]:
        return iter(self._results)

    def __len__(self) -> int:
        return len(self._results)

    def __repr__(self) -> str:
        return f"<ElementResults of {choices([str(name) for name in self]) or 'no elements'}>"
