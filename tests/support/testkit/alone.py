"""Samples solved one by one, with orders of elimination chosen at each, instead of by tapes."""

from __future__ import annotations

import pytest

from cardan_dyn.core.dynamics.taped import TapedSolver


def without_tapes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no tape hold for any sample."""
    monkeypatch.setattr(TapedSolver, "_by_tapes", lambda self, *given: (given[5], given[4]))
