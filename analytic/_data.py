"""Data of the package, which lie beside its modules as TOML files."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any


def read(name: str | Path) -> dict[str, Any]:
    """Return what a TOML file holds, one of the package unless a whole path is given."""
    text = (Path(__file__).parent / name).read_text(encoding="utf-8")
    if sys.version_info >= (3, 11):
        import tomllib

        return tomllib.loads(text)
    else:
        import tomlkit

        return tomlkit.parse(text).unwrap()
