"""Orders: orders of elimination of the closure rows of a motion, chosen where they are needed.

They are chosen at scouts, closed configurations that are the same for all scenes that move alike,
so that they do not depend on what was asked for first. The first order is chosen at all of them; it
serves nearly everywhere, and nearly always alone. Each other one is chosen where those before it
serve worst, the third one over the motion of the scene itself.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ....kit.arrays import Array
from ...mechanics import closure
from ...mechanics.bodies import Tree
from ...mechanics.elimination import THRESHOLD, Order, UnsuitableError, chosen, eliminated
from ...mechanics.placements import placed
from ...mechanics.sample import Roles, passive_rows
from ...mechanism.kept import Kept


class Chosen(NamedTuple):
    """An order, and where it is chosen.

    Attributes:
        order: of elimination.
        at: `(size, S)` closed coordinates in units of the tree.
        scene: where the scene starts over whose motion it is chosen; empty if for all scenes.
    """

    order: Order
    at: Array
    scene: bytes


class Orders:
    """Orders of elimination, each chosen when it is first asked for. Threads may share them.

    Attributes:
        key: all that those chosen at the scouts near by follow from, besides the mechanism.
    """

    def __init__(
        self,
        near: Array,
        own: Callable[[], Array],
        of: Hashable,
        start: bytes,
        tree: Tree,
        roles: Roles,
        kept: Kept,
    ) -> None:
        """Begin with those that other scenes of the mechanism asked for.

        Args:
            near: `(S, size)` closed coordinates, the same for all scenes that move alike.
            own: finds those all over the motion of the scene; lines begin at the first one.
            of: what the former follow from.
            start: where the scene starts, from which the latter follow as well.
            tree: the mechanism, with the loops and couplings that are solved.
            roles: of its coordinates.
            kept: of the mechanism.
        """
        self._near, self._own, self._tree, self._roles = near, own, tree, roles
        rows = tuple(block[:2] for block in roles.blocks)
        self.key = of, roles.drives, rows, tree.loops, tree.couplings, tree.spins
        # From the start, and from anywhere; None behind the last one.
        self._found: dict[bytes, dict[tuple[int, bool], Chosen | None]] = {
            scene: kept.of("orders", (self.key, scene), dict) for scene in (b"", start)
        }

    def at(self, index: int, from_start: bool = False) -> Chosen | None:
        """Return an order; None if there is none.

        Args:
            index: which one, 0 for the first.
            from_start: whether those after the first have to serve at the start as well, where
                lines begin.
        """
        key = index, from_start and index > 0
        for scene, found in list(self._found.items())[index > 1 : 1 + (index > 0)]:
            if key not in found:
                found.setdefault(key, self._next(*key, scene))
            if found[key] is not None:
                return found[key]
        return None

    def _next(self, index: int, from_start: bool, scene: bytes) -> Chosen | None:
        """Return the order chosen where those before it serve worst; None if it is one of them."""
        found: list[Order] = []
        for before in range(index):
            chosen_before = self.at(before, from_start)
            if chosen_before is None:
                return None
            found.append(chosen_before.order)
        scouts = self._own() if scene else self._near
        x = (scouts / self._tree.coordinate_units(scouts.shape[1])).T
        if not found:
            return self._chosen(x, scene)
        rows, growth = self._rows(x), np.full(x.shape[1], np.inf)
        for order in found:
            with np.errstate(all="ignore"):  # A pivot may vanish at a sample.
                growth = np.fmin(growth, eliminated(rows, order).growth)
        quarter = -(-len(growth) // 4)
        least = min(1.0 / THRESHOLD, np.partition(growth, -quarter)[-quarter])
        (worst,) = np.nonzero(growth >= least)
        result = self._chosen(x[:, np.union1d([0], worst) if from_start else worst], scene)
        is_new = result and all(result.order.places != order.places for order in found)
        return result if is_new else None

    def _chosen(self, x: Array, scene: bytes) -> Chosen | None:
        """Return the order chosen at coordinates `(size, S)`; None if none suits them."""
        with suppress(UnsuitableError):
            blocks = [block[:2] for block in self._roles.blocks]
            return Chosen(chosen(self._rows(x), blocks), x, scene)
        return None

    def _rows(self, x: Array) -> list[dict[int, Array]]:
        """Return the closure rows at coordinates `(size, S)`: column to entries `(S,)`."""
        tree, roles = self._tree, self._roles
        moving = {*roles.drives, *roles.passives}
        rows = closure.rows(tree, placed(tree, dict(enumerate(x))), moving)
        count = x.shape[1]
        return [
            {c: np.broadcast_to(entry, count) for c, entry in row.items()}
            for row in passive_rows(rows, roles)
        ]
