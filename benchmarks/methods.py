"""The library's methods of computing reactions: the sweep, and the response where it exists."""

from __future__ import annotations

from typing import Any

import cardan_dyn as cd


def methods() -> tuple[str, ...]:
    """Return `sweep`, and `response` where the library has it."""
    return ("sweep", "response") if hasattr(cd.Scene, "response") else ("sweep",)


def prepared(scene: cd.Scene, method: str, span: tuple[float, float] | None = None) -> Any:
    """Return what sweeps positions: the scene, or its response."""
    if method == "sweep":
        return scene
    return scene.response(interval=span)  # type: ignore[attr-defined]
