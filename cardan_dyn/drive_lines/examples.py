"""Examples: drive lines that come with the package, by name."""

from __future__ import annotations

from pathlib import Path

_DIRECTORY = Path(__file__).parent / "lines"


def examples() -> tuple[str, ...]:
    """Return the names of the lines that come with the package; `DriveLine.from_toml` reads them.

    Their dimensions are representative, and each file says where its figures are from.
    """
    return tuple(sorted(path.stem for path in _DIRECTORY.glob("*.toml")))


def example_path(name: str) -> Path | None:
    """Return the file of a line that comes with the package; None if there is none of this name."""
    return _DIRECTORY / f"{name}.toml" if name in examples() else None
