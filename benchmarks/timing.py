"""Fair times on a machine that others use: candidates take turns, the least time of each counts."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pinocchio

import cardan_dyn as cd

_TURN = 0.005  # Least time that a candidate runs when it has its turn [s].


def least_seconds(
    candidates: Mapping[str, Callable[[], object]],
    repeats: int = 5,
    patience: float = 2.0,
    clock: Callable[[], float] | None = None,
) -> dict[str, float]:
    """Return the least time of each candidate [s].

    Args:
        candidates: what to time.
        repeats: rounds in which every candidate has its turn.
        patience: a candidate that has used more time than this [s] sits out further rounds.
        clock: what tells the time [s], `time.perf_counter` if None. `time.process_time` leaves out
            what other processes take: of a single thread it is the time on an idle machine.
    """
    now = clock or time.perf_counter
    least = dict.fromkeys(candidates, float("inf"))
    used = dict.fromkeys(candidates, 0.0)
    for _ in range(repeats):
        for name, candidate in candidates.items():
            if used[name] > patience:
                continue
            gc.collect()
            gc.disable()
            turn = 0.0
            # Collecting garbage empties the caches: what is short is run until they are warm.
            while turn < _TURN:
                start = now()
                candidate()
                seconds = now() - start
                least[name] = min(least[name], seconds)
                turn += seconds
            gc.enable()
            used[name] += turn
    return least


def rnea_seconds(mechanism: cd.Mechanism) -> float:
    """Return R, the time of one `pin.rnea` call from Python on a mechanism's model [s]."""
    model = mechanism.model
    data, q = model.createData(), pinocchio.neutral(model)
    v = np.zeros(model.nv)

    def calls() -> None:
        for _ in range(100):
            pinocchio.rnea(model, data, q, v, v)

    return least_seconds({"R": calls}, repeats=10)["R"] / 100.0


def quick(values: Sequence[float], fast: bool) -> Sequence[float]:
    """Return all values, or only the ends of them for a fast look."""
    return [values[0], values[-1]] if fast and len(values) > 2 else values
