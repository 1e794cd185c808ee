"""Includes of MJCF: elements of other files in the place of each `<include>`."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from xml.etree import ElementTree

from ...errors import ModelError
from ..elements import file_text, xml_root
from ..words import check_words

DEPTH = 300
"""Greatest depth of elements within each other; the root counts as 1. Deeper models were never
tested."""


def with_includes(root: ElementTree.Element, where: str, path: Path | None) -> ElementTree.Element:
    """Return a model in which included files' elements, and theirs in turn, replace `<include>`.

    As in MuJoCo, a path is taken from beside the main file, or else from beside the including
    one, and a file is included once.

    Args:
        root: outermost element of the main file; it stays as it is.
        where: how messages name the main file.
        path: the main file; None for text.

    Raises:
        ModelError: a file is missing, malformed or included twice, or elements are nested deeper
            than `DEPTH`.
    """
    seen = set() if path is None else {path.resolve()}
    main = None if path is None else path.parent
    result = ElementTree.Element(root.tag, root.attrib)
    waiting = [(root, result, main, 1)]
    while waiting:
        parent, resolved, beside, depth = waiting.pop()
        if depth > DEPTH:
            raise ModelError(
                f"{where}: <{parent.tag}> is nested {depth} elements deep; the limit is {DEPTH}"
            )
        content = deque((child, beside) for child in parent)
        while content:
            child, folder = content.popleft()
            if child.tag != "include":
                copied = ElementTree.SubElement(resolved, child.tag, child.attrib)
                waiting.append((child, copied, folder, depth + 1))
                continue
            included, file = _included(child, where, main, folder)
            if file.resolve() in seen:
                raise ModelError(
                    f"{where}: <include file={child.get('file')!r}>: the file is included twice, "
                    "or includes itself; include it once"
                )
            seen.add(file.resolve())
            content.extendleft((item, file.parent) for item in reversed(included))
    return result


def _included(
    element: ElementTree.Element, where: str, main: Path | None, beside: Path | None
) -> tuple[ElementTree.Element, Path]:
    """Return the outermost element of an included file, and the file."""
    name = element.get("file")
    at = f"{where}: <include file={name!r}>"
    check_words(element, "mjcf", where)
    if not name:
        raise ModelError(f'{where}: an <include> needs file="..."')
    if len(element):
        raise ModelError(f"{at}: it has elements of its own; an <include> has none")
    if main is None or beside is None:
        raise ModelError(f"{at}: text has no directory to find it in; load the file by its path")
    try:
        existing = [file for file in (main / name, beside / name) if file.is_file()]
        if not existing:
            raise ModelError(f"{at}: there is no file {str(main / name)!r}")
    except (OSError, ValueError) as error:  # A name that is too long, or has a null character.
        raise ModelError(f"{at}: cannot be read ({error})") from error
    return xml_root(file_text(existing[0], at).strip(), at)[0], existing[0]
