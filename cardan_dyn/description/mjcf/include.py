"""Includes of MJCF: other files' elements put in place."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from xml.etree import ElementTree

from ...errors import ModelError
from .schema import check_attributes

DEPTH = 300
"""Greatest number of elements within each other."""


def with_includes(root: ElementTree.Element, where: str, path: Path | None) -> None:
    """Put what other files contain in the place of every `<include>`, files in files as well.

    As in MuJoCo, a path is taken from beside the main file, or else from beside the including
    one, and a file is included once.

    Raises:
        ModelError: a file is missing, malformed or included twice, or elements are nested deeper
            than `DEPTH`.
    """
    seen = set() if path is None else {path.resolve()}
    main = None if path is None else path.parent
    waiting = [(root, main, 1)]
    while waiting:
        parent, beside, depth = waiting.pop()
        if depth > DEPTH:
            raise ModelError(
                f"{where}: <{parent.tag}> is nested {depth} elements deep; the limit is {DEPTH}"
            )
        content = deque((child, beside) for child in parent)
        children = []
        while content:
            child, folder = content.popleft()
            if child.tag != "include":
                children.append(child)
                waiting.append((child, folder, depth + 1))
                continue
            included, file = _included(child, where, main, folder)
            if file.resolve() in seen:
                raise ModelError(
                    f"{where}: <include file={child.get('file')!r}>: the file is included twice, "
                    "or includes itself; include it once"
                )
            seen.add(file.resolve())
            content.extendleft((item, file.parent) for item in reversed(included))
        parent[:] = children


def _included(
    element: ElementTree.Element, where: str, main: Path | None, beside: Path | None
) -> tuple[ElementTree.Element, Path]:
    """Return the outermost element of an included file, and the file."""
    name = element.get("file")
    at = f"{where}: <include file={name!r}>"
    check_attributes(element, at)
    if not name:
        raise ModelError(f'{where}: an <include> needs file="..."')
    if len(element):
        raise ModelError(f"{at}: it has elements of its own; an <include> has none")
    if main is None or beside is None:
        raise ModelError(f"{at}: text has no directory to find it in; load the file by its path")
    try:
        found = [file for file in (main / name, beside / name) if file.is_file()]
        if not found:
            raise ModelError(f"{at}: there is no file {str(main / name)!r}")
        content = found[0].read_text(encoding="utf-8-sig")
        return ElementTree.fromstring(content.lstrip(" \t\r\n")), found[0]
    except ElementTree.ParseError as error:
        raise ModelError(f"{at}: malformed XML: {error}") from error
    except (OSError, ValueError) as error:
        raise ModelError(f"{at}: cannot be read as text ({error})") from error
