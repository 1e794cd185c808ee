"""Words: the elements and attributes that URDF and SDF know, and misspelled ones.

A misspelled word would be passed over without a message, and the mechanism would be another one: a
loop left open, an axis along x. `words.json` lists the words of each notation by the element that
they stand in. Elements that it does not list are not looked into; of those that have no list of one
kind, anything of that kind is passed over.

The words of SDF are those of SDFormat 1.12 and what versions from 1.4 on knew besides.
MuJoCo checks those of MJCF itself.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

from ...kit.errors import ModelError, choices

_LONG = 6
"""Letters from which on a word may have two mistakes; shorter ones may have one. Words of published
robots that mean something else are farther from URDF's: `gear_velocity`, `surface`, `rotor`."""
_LEAST_SIMILARITY = 0.6
"""Of words with one or two letters, see `difflib.get_close_matches`: its default."""
_PASSED_OVER = "load(..., strict=False) passes it over"


class _MayHave(NamedTuple):
    """What an element may have; None where nothing says what that is."""

    attributes: frozenset[str] | None
    elements: frozenset[str] | None


@cache
def _known(notation: str) -> dict[str, _MayHave]:
    listed = json.loads(Path(__file__).with_name("words.json").read_text(encoding="utf-8"))
    result = {}
    for elements, words in listed[notation].items():
        sets = (words.get(kind) for kind in _MayHave._fields)
        known = _MayHave(*(None if text is None else frozenset(text.split()) for text in sets))
        result.update(dict.fromkeys(elements.split(), known))
    return result


def check_words(root: Element, notation: str, where: str, strict: bool = True) -> list[str]:
    """Refuse unknown elements and attributes; return warnings about those that are passed over.

    In URDF, where other programs have words of their own, only those are refused that resemble a
    known one. What stands in a namespace belongs to another program; but xacro is refused, and so
    are elements of URDF in a namespace, where nobody would look for them.

    Args:
        root: outermost element of what is checked.
        notation: `urdf` or `sdf`.
        where: how messages name the source of the text.
        strict: whether to refuse any.

    Raises:
        ModelError: a word is not known; the message says what it may have been.
    """
    known = _known(notation)
    unknown: dict[str, int] = {}
    spaces: dict[str, None] = {}
    waiting = [root]
    # Written with few calls: it grows while it is gone through, and a description is long.
    for element in waiting:
        attributes, elements = known[element.tag]
        odd: list[tuple[str, str, Iterable[str]]] = []
        if attributes is not None and not attributes.issuperset(element.attrib):
            odd += [("attribute", key, attributes) for key in element.attrib]
        for child in element:
            if "}" in child.tag:
                spaces[_namespace(child.tag, notation, where)] = None
            elif elements is not None and child.tag not in elements:
                odd += [("element", child.tag, elements)]
            elif child.tag in known:
                waiting += [child]
        for kind, word, listed in odd:
            if word in listed or "}" in word:
                continue
            similar = similar_word(word.lower(), listed)
            if strict and (similar or notation == "sdf"):
                name = f" {element.get('name')!r}" if element.get("name") else ""
                raise ModelError(
                    f"{where}: <{element.tag}>{name}: {kind} {word!r} is unknown; "
                    + (f"did you mean {similar!r}? " if similar else "")
                    + f"{kind}s: {choices(listed, None if similar else word)}; {_PASSED_OVER}"
                )
            label = f"{kind} {word!r} of <{element.tag}>"
            unknown[label] = unknown.get(label, 0) + 1
    return [
        f"{where}: {label} is unknown and was passed over" + (f" ({count} times)" * (count > 1))
        for label, count in unknown.items()
    ] + [f"{where}: elements of the namespace {space!r} were passed over" for space in spaces]


def _namespace(tag: str, notation: str, where: str) -> str:
    """Return the namespace of an element; refuse those of URDF in one, and xacro."""
    space, _, name = tag[1:].partition("}")
    if notation == "urdf" and "xacro" in space:
        raise ModelError(
            f"{where}: <xacro:{name}> is to be processed first: xacro FILE > FILE.urdf"
        )
    if notation == "urdf" and name in _known(notation):
        raise ModelError(
            f"{where}: <{name}> stands in the namespace {space!r}, where no reader of URDF looks "
            "for it; take it out of there"
        )
    return space


def similar_word(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that a misspelled one stands for, if there is one."""
    known = sorted(known)
    mistakes = 1 if len(word) < _LONG else 2
    similarity = max((len(word) - mistakes) / max(len(word), 1), _LEAST_SIMILARITY)
    near = [other for other in known if sorted(other) == sorted(word)]
    from difflib import get_close_matches  # Most descriptions are spelled right.

    near += get_close_matches(word, known, n=1, cutoff=similarity)
    return near[0] if near else None


def unknown_keys(
    keys: Iterable[object], known: Iterable[str], where: str, strict: bool
) -> list[str]:
    """Return warnings about keys of a mapping that are not known.

    Args:
        keys: of the mapping.
        known: keys that it may have.
        where: how messages name the mapping.
        strict: whether to refuse keys that resemble known ones.

    Raises:
        ModelError: a key is misspelled.
    """
    known = sorted(known)
    unknown = dict.fromkeys(str(key) for key in keys if key not in known)
    for key in unknown if strict else ():
        similar = similar_word(key.lower(), known)
        if similar:
            raise ModelError(
                f"{where}: key {key!r} is unknown; did you mean {similar!r}? "
                f"keys: {choices(known)}; {_PASSED_OVER}"
            )
    return [f"{where}: {key} is unknown and was passed over" for key in unknown]
