"""Routes: the fewest joints around a loop, past others that are closed.

The loops of a long chain may all reach down to its foot, as those of lazy tongs that were described
as two chains side by side: the rows of the last loop would hold every joint before it, though only
four joints surround its cell. Where an earlier loop is closed, its weld holds two bodies together
as a rigid body does, so the way around a loop may lead across it. The closure equations of such
ways are those of the loops in the description, less those of the loops that are crossed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

from .structure import Structure

_AT_MOST = 0.5
"""Part of the bodies on a loop that another way may have in order to be taken: what it saves has to
outweigh that inertia is accounted for apart."""


class Crossing(NamedTuple):
    """A closed loop that is crossed, outwards from the base of a group.

    Attributes:
        loop: its index in `Mechanism.loops`.
        forward: whether its predecessor carries its successor; otherwise it is carried.
    """

    loop: int
    forward: bool


_Step = int | Crossing | None
"""How a way goes on: by the joint that carries a body, across a loop, or outwards from here."""


class Route(NamedTuple):
    """A way around a loop.

    Attributes:
        base: the body (0-based) from which both sides hang, -1 for the world.
        bodies: those that their joints carry: outwards on the predecessor's side, then on the
            successor's.
        crossed: the loops across which other bodies are carried.
    """

    base: int
    bodies: list[int]
    crossed: tuple[Crossing, ...]


class Routes:
    """Finds ways across the loops that are closed so far."""

    def __init__(self, structure: Structure) -> None:
        self._structure = structure
        model = structure.mechanism.model
        self._parents = [parent - 1 for parent in list(model.parents)[1:]]
        self._children: dict[int, list[int]] = {}
        for body, parent in enumerate(self._parents):
            self._children.setdefault(parent, []).append(body)
        self._welds: dict[int, list[tuple[int, Crossing]]] = {}

    def cross(self, loop: int) -> None:
        """Let later ways lead across a loop, since it is closed before theirs."""
        weld = self._structure.mechanism.loops[loop]
        # The wrench of a `fixed` loop is that of its weld, which would change with what crosses it.
        if weld.is_fixed or not weld.successor:
            return
        first, second = weld.predecessor - 1, weld.successor - 1
        self._welds.setdefault(first, []).append((second, Crossing(loop, True)))
        self._welds.setdefault(second, []).append((first, Crossing(loop, False)))

    def around(self, loop: int) -> Route | None:
        """Return a way around a loop that is much shorter than along the tree; None without."""
        most = int(_AT_MOST * len(self._structure.paths[loop]))
        if not self._welds or most < 1:
            return None
        weld = self._structure.mechanism.loops[loop]
        # Inwards from the predecessor to the base, then outwards.
        start, end = (weld.predecessor - 1, False), (weld.successor - 1, True)
        reached: dict[tuple[int, bool], tuple[int, tuple[int, bool] | None, _Step]] = {
            start: (0, None, None)
        }
        queue = deque([start])
        while queue and queue[0] != end:
            place = queue.popleft()
            length = reached[place][0]
            for following, step in self._steps(*place):
                longer = length + isinstance(step, int)
                if longer > most or (following in reached and reached[following][0] <= longer):
                    continue
                reached[following] = longer, place, step
                (queue.append if longer > length else queue.appendleft)(following)
        if end not in reached:
            return None
        inner: list[int] = []
        outer: list[int] = []
        crossed: list[Crossing] = []
        place, base = end, end[0]
        while place != start:
            _, previous, step = reached[place]
            assert previous is not None
            if isinstance(step, int):
                (outer if place[1] else inner).append(step)
            elif step is not None:
                # Inwards, what is left is carried by what is reached.
                crossed.append(step if place[1] else Crossing(step.loop, not step.forward))
            if place[1] and not previous[1]:
                base = place[0]
            place = previous
        return Route(base, inner + outer[::-1], tuple(crossed)) if crossed else None

    def _steps(self, body: int, outwards: bool) -> Iterator[tuple[tuple[int, bool], _Step]]:
        """Yield where a body leads, and how."""
        for other, crossing in self._welds.get(body, ()):
            yield (other, outwards), crossing
        if outwards:
            for child in self._children.get(body, ()):
                yield (child, True), child
        else:
            yield (body, True), None
            if body >= 0:
                yield (self._parents[body], False), body
