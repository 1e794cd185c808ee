"""Compiled functions, and what runs where there are none."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from cardan_dyn.core import compiled

needs_kernel = pytest.mark.skipif(compiled.kernel is None, reason="nothing is compiled here")


@contextmanager
def without_kernel() -> Iterator[None]:
    """Leave all to NumPy meanwhile."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "kernel", None)
        yield
