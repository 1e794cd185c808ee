"""Element results: what every force element of a scene exerts at the samples of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from ...kit.errors import ModelError, choices
from ...kit.frozen import Frozen

if TYPE_CHECKING:
    from ..elements.element import Element, ElementForce


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
