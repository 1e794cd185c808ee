"""Data of the package, which lie beside its modules as TOML files."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any


def read(name: str | Path) -> dict[str, Any]:
    """Return what a TOML file holds, one of the package unless a whole path is given."""
    return tomllib.loads((Path(__file__).parent / name).read_text(encoding="utf-8"))
