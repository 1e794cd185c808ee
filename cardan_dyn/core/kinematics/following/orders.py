"""Orders: orders of elimination of the closure rows of a motion, chosen where they are needed.

They are chosen at scouts, closed configurations that follow from the start alone, so that they do
not depend on what was asked for first. The first order is chosen at all scouts; it serves nearly
everywhere, and nearly always alone. Each other one is chosen where those before it serve worst.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TypeAlias

import numpy as np

from ....kit.arrays import Array
from ...mechanics import closure
from ...mechanics.bodies import Tree
from ...mechanics.elimination import MOST_GROWTH, Order, UnsuitableError, chosen, eliminated
from ...mechanics.placements import placed
from ...mechanics.sample import Roles, passive_rows
from ...mechanism.kept import Kept

_Chosen: TypeAlias = tuple[Order, Array]
"""An order, and the scouts (index) at which it is chosen."""


class Orders:
    """Orders of elimination, each chosen when it is first asked for. Threads may share them.

    Attributes:
        scouts: `(size, S)` coordinates in units of the tree; the start is the first one.
    """

    def __init__(self, scouts: Array, tree: Tree, roles: Roles) -> None:
        """Choose the first one.

        Args:
            scouts: `(S, size)` closed coordinates, those at which lines begin first.
            tree: the mechanism, with the loops and couplings that are solved.
            roles: of its coordinates.
        """
        self.scouts: Array = (scouts / tree.coordinate_units(scouts.shape[1])).T
        self._blocks = [block[:2] for block in roles.blocks]
        at = placed(tree, dict(enumerate(self.scouts)))
        rows = passive_rows(closure.rows(tree, at, {*roles.drives, *roles.passives}), roles)
        count = self.scouts.shape[1]
        self._rows = [{c: np.broadcast_to(x, count) for c, x in row.items()} for row in rows]
        first = self._chosen(np.arange(count))
        # From the start, and from anywhere; None behind the last one.
        self._found: dict[bool, list[_Chosen | None]] = {True: [first], False: [first]}
        self._lock = threading.RLock()

    @staticmethod
    def kept(scouts: Callable[[], Array], tree: Tree, roles: Roles, kept: Kept) -> Orders:
        """Return those of all scenes of a mechanism that move alike.

        Args:
            scouts: finds them.
            tree: see `Orders`.
            roles: likewise.
            kept: of the mechanism.
        """
        rows = tuple(block[:2] for block in roles.blocks)
        key = roles.drives, rows, tree.loops, tree.couplings, tree.spins
        return kept.of("orders", key, lambda: Orders(scouts(), tree, roles))

    def at(self, index: int, from_start: bool = False) -> _Chosen | None:
        """Return an order, and the scouts (index) it is chosen at; None if there is none.

        Args:
            index: which one, 0 for the first.
            from_start: whether those after the first have to serve at the start as well, where
                lines begin.
        """
        with self._lock:
            found = self._found[from_start]
            while len(found) <= index and found[-1] is not None:
                found.append(self._next(list(filter(None, found)), from_start))
            return found[min(index, len(found) - 1)]

    def _next(self, found: list[_Chosen], from_start: bool) -> _Chosen | None:
        """Return the order chosen where those that were found serve worst; None for one of them."""
        count = self.scouts.shape[1]
        growth, quarter = np.full(count, np.inf), -(-count // 4)
        for order, _ in found:
            with np.errstate(all="ignore"):  # A pivot may vanish at a sample.
                growth = np.fmin(growth, eliminated(self._rows, order).growth)
        (worst,) = np.nonzero(growth >= min(MOST_GROWTH, np.partition(growth, -quarter)[-quarter]))
        found_next = self._chosen(np.union1d([0], worst) if from_start else worst)
        is_new = found_next and all(found_next[0].places != other.places for other, _ in found)
        return found_next if is_new else None

    def _chosen(self, samples: Array) -> _Chosen | None:
        """Return the order chosen at some scouts, by their indices; None if none suits them."""
        own = [{column: entry[samples] for column, entry in row.items()} for row in self._rows]
        with suppress(UnsuitableError):
            return chosen(own, self._blocks), samples
        return None
