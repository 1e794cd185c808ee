"""Constrained model: accelerations of a mechanism whose loops are kept closed, chain by chain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, consecutive
from ..mechanism.mechanism import Mechanism
from .chains import chains_of
from .constrained_chain import ConstrainedChain
from .free_balls import WithBalls


class ConstrainedModel:
    """The constrained chains of a mechanism, as one.

    Not for several threads at once, as its chains are not.

    Attributes:
        mechanism: the mechanism.
        prescribed: velocity coordinates `(p,)` that are driven or held, ascending.
        chains: one for each chain of the mechanism.
    """

    def __init__(
        self,
        mechanism: Mechanism | WithBalls,
        prescribed: Sequence[int],
        gravity: Array,
        state: Array,
    ) -> None:
        """Make the model.

        Args:
            mechanism: see the attribute.
            prescribed: see the attribute, in any order.
            gravity: `(3,)` [m/s²].
            state: `(size,)` closed coordinates, at which it is scaled.
        """
        self.mechanism = mechanism
        self.prescribed = np.unique(np.array(prescribed, dtype=int))
        chains = chains_of(mechanism)
        made_of = self.prescribed.tolist(), gravity, state
        self.chains = [ConstrainedChain(mechanism, chain, *made_of) for chain in chains]
        # A single chain takes and returns rows as they are.
        self._only = self.chains[0] if len(self.chains) == 1 else None
        self._parts = [
            (
                model,
                consecutive(chain.columns),
                consecutive(chain.rates),
                np.isin(self.prescribed, chain.rates),
            )
            for model, chain in zip(self.chains, chains, strict=True)
        ]

    def accelerations(
        self, x: Array, v: Array, efforts: Array | None = None, prescribed: Array | None = None
    ) -> Array:
        """Return the accelerations `(nv,)` that efforts cause, see `ConstrainedChain`."""
        if self._only is not None:
            return self._only.accelerations(x, v, efforts, prescribed)
        a = np.empty_like(v)
        for model, columns, rates, own in self._parts:
            acting = None if efforts is None else efforts[rates]
            told = None if prescribed is None else prescribed[own]
            a[rates] = model.accelerations(x[columns], v[rates], acting, told)
        return a

    def closed(self, x: Array, v: Array, *, crosses: bool = False) -> tuple[Array, Array]:
        """Return a state whose loops and couplings are closed again, see `ConstrainedChain`."""
        if self._only is not None:
            return self._only.closed(x, v, crosses=crosses)
        near, rates_near = np.empty_like(x), np.empty_like(v)
        for model, columns, rates, _ in self._parts:
            near[columns], rates_near[rates] = model.closed(x[columns], v[rates], crosses=crosses)
        return near, rates_near

    def weakness(self, x: Array) -> float:
        """Return how strong the weakest closure equation is, see `ConstrainedChain`."""
        return min((model.weakness(x[columns]) for model, columns, *_ in self._parts), default=1.0)

    def singular_gap(self, x: Array) -> float:
        """Return the gap of the weakest chain in a singular configuration near coordinates."""
        model, columns, *_ = min(self._parts, key=lambda part: part[0].weakness(x[part[1]]))
        return model.singular_gap(x[columns])

    def closure_error(self, x: Array) -> float:
        """Return the greatest closure error, see `ConstrainedChain`."""
        errors = [model.closure_error(x[columns]) for model, columns, *_ in self._parts]
        return max(errors, default=0.0)
