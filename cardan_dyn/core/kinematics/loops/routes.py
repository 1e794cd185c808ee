"""Routes: the fewest joints around each loop, past the welds of other loops.

The loops of a long chain may all reach down to its foot, as those of lazy tongs that were described
as two chains side by side: the rows of the last loop would hold every joint before it, though only
four joints surround its cell. A weld holds two bodies together as a rigid body does, so the way
around a loop may lead across that of another one. The closure equations of such ways are those of
the loops in the description, less those of the loops that are crossed: as each way crosses only
loops that come before its own, the former hold if and only if the latter do.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import pinocchio

from ...mechanism.mechanism import Mechanism


class Crossing(NamedTuple):
    """A loop that is crossed, outwards from the base of a group.

    Attributes:
        loop: its index in `Mechanism.loops`.
        forward: whether its predecessor carries its successor; otherwise it is carried.
    """

    loop: int
    forward: bool


class Route(NamedTuple):
    """A way around a loop.

    Attributes:
        base: the body (0-based) from which both sides hang, -1 for the world.
        bodies: those that their joints carry, each after what carries it.
        crossed: the loops across which other bodies are carried.
    """

    base: int
    bodies: list[int]
    crossed: tuple[Crossing, ...]


Carriers = dict[int, tuple[int, pinocchio.SE3]]
"""Bodies (0-based) to those that carry them across a weld, and where they are there."""


def carriers_of(mechanism: Mechanism, crossed: Sequence[Crossing]) -> Carriers:
    """Return which bodies are carried where loops are crossed."""
    carriers = {}
    for crossing in crossed:
        loop = mechanism.loops[crossing.loop]
        first, second = loop.predecessor_placement, loop.successor_placement
        if crossing.forward:
            at = first * second.inverse()
            carriers[loop.successor - 1] = loop.predecessor - 1, at
        else:
            at = second * first.inverse()
            carriers[loop.predecessor - 1] = loop.successor - 1, at
    return carriers


def carried(body: int, carriers: Carriers) -> tuple[int, pinocchio.SE3 | None]:
    """Return the body that carries another one (both 0-based) as a rigid body does.

    Returns:
        That body, and where the other one is there; None if both are the same.
    """
    at = None
    while body in carriers:
        body, here = carriers[body]
        at = here if at is None else here * at
    return body, at


def merged(mechanism: Mechanism, routes: Sequence[Route]) -> Route | None:
    """Return the bodies of several ways as those of one, None if they contradict each other."""
    crossed = tuple(dict.fromkeys(item for route in routes for item in route.crossed))
    bodies = list(dict.fromkeys(body for route in routes for body in route.bodies))
    carriers = carriers_of(mechanism, crossed)
    # Every body hangs in one way, from one base.
    is_one = len({route.base for route in routes}) == 1 and len(carriers) == len(crossed)
    if not is_one or not carriers.keys().isdisjoint({routes[0].base, *bodies}):
        return None
    return Route(routes[0].base, bodies, crossed)


def short_routes(mechanism: Mechanism, paths: Sequence[list[int]]) -> dict[int, Route]:
    """Return ways around loops that are much shorter than those along the tree, if there are any.

    Args:
        mechanism: the mechanism.
        paths: per loop, the bodies (0-based) on it along the tree.
    """
    finder, found = _Finder(mechanism), {}
    for loop in sorted(range(len(mechanism.loops)), key=lambda loop: (len(paths[loop]), loop)):
        # By half: what it saves has to outweigh that inertia is accounted for apart.
        route = finder.around(loop, len(paths[loop]) // 2)
        if route is not None:
            found[loop] = route
        finder.cross(loop)
    return found


_Step = int | Crossing | None
"""How a way goes on: by the joint that carries a body, across a loop, or outwards from here."""


class _Finder:
    """Finds ways across the loops that were added."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._loops = mechanism.loops
        self._parents = [parent - 1 for parent in list(mechanism.model.parents)[1:]]
        self._children: dict[int, list[int]] = {}
        for body, parent in enumerate(self._parents):
            self._children.setdefault(parent, []).append(body)
        self._welds: dict[int, list[tuple[int, Crossing]]] = {}

    def cross(self, loop: int) -> None:
        """Let later ways lead across a loop."""
        weld = self._loops[loop]
        # The wrench of a `fixed` loop is that of its weld, which would change with what crosses it.
        if weld.is_fixed or not weld.successor:
            return
        first, second = weld.predecessor - 1, weld.successor - 1
        self._welds.setdefault(first, []).append((second, Crossing(loop, True)))
        self._welds.setdefault(second, []).append((first, Crossing(loop, False)))

    def around(self, loop: int, most: int) -> Route | None:
        """Return the shortest way across other loops by so many bodies at most."""
        if not self._welds or most < 1:
            return None
        weld = self._loops[loop]
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
        inner: list[int] = []
        outer: list[int] = []
        crossed: list[Crossing] = []
        place, base = end, end[0]
        while place in reached:
            _, previous, step = reached[place]
            if previous is None:
                return Route(base, inner + outer[::-1], tuple(crossed)) if crossed else None
            if isinstance(step, int):
                (outer if place[1] else inner).append(step)
            elif step is not None:
                # Inwards, what is left is carried by what is reached.
                crossed.append(step if place[1] else Crossing(step.loop, not step.forward))
            if place[1] and not previous[1]:
                base = place[0]
            place = previous
        return None

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
