"""Files: a description written to a file, in the notation that its suffix names."""

from __future__ import annotations

import os
from pathlib import Path

from ..checks import described
from ..errors import ArgumentError
from .description import Description

_SUFFIXES = (".urdf", ".xml", ".mjcf")


def write(description: Description, path: str | os.PathLike[str]) -> Path:
    """Write a description to a file, in place of what it contained; return its path.

    Args:
        description: what to write.
        path: `.urdf` for URDF+, `.xml` or `.mjcf` for MJCF.

    Raises:
        ArgumentError: the suffix is unknown, or the file cannot be written.
        ModelError: the notation cannot say something of the description.
    """
    target = _path(path)
    if target.suffix.lower() == ".urdf":
        from .write import to_urdf

        text = to_urdf(description)
    else:
        from .mjcf.writer import to_mjcf

        text = to_mjcf(description)
    try:
        target.write_text(text, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise ArgumentError(f"{target}: cannot be written ({error})") from error
    return target


def _path(path: object) -> Path:
    """Return where to write.

    Raises:
        ArgumentError: it is no path, of no known notation, or in no directory.
    """
    try:
        target = Path(os.fspath(path))  # type: ignore[call-overload]
    except Exception as error:  # The path may be an object of any class, which may raise anything.
        raise ArgumentError(f"path is {described(path)}, expected a path") from error
    if target.suffix.lower() not in _SUFFIXES:
        raise ArgumentError(
            f"{target}: the suffix {target.suffix!r} names no notation; write .urdf for URDF+, "
            ".xml or .mjcf for MJCF"
        )
    try:
        exists = target.parent.is_dir()
    except (OSError, ValueError):  # A name that is too long, or contains a null character.
        exists = False
    if not exists:
        raise ArgumentError(f"{target}: the directory {str(target.parent)!r} does not exist")
    return target
