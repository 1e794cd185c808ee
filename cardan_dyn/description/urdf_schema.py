"""Words of URDF: the elements and attributes that are known, by the element that they stand in.

A misspelled word would be passed over without a message, and the mechanism would be another one: a
loop left open, an axis along x. So words that resemble known ones are refused, and all others that
are not known are named in the warnings.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree

from ..errors import ModelError, choices
from .elements import DYNAMICS_WORDS
from .words import similar_word

_POSE = "xyz rpy"
_KNOWN: dict[str, str] = {
    "robot": "name version",
    "robot/": (
        "link joint loop loop_joint constraint coupling material transmission gazebo mujoco drake"
    ),
    "link": "name type",
    "link/": "inertial visual collision contact",
    "inertial/": "origin mass inertia",
    "mass": "value",
    "inertia": "ixx ixy ixz iyy iyz izz",
    "origin": f"{_POSE} quat_xyzw",
    "joint": "name type independent adjustable",
    "joint/": "origin parent child axis axis2 limit dynamics mimic calibration safety_controller",
    "parent": "link",
    "child": "link",
    "axis": "xyz",
    "axis2": "xyz",
    "limit": "lower upper velocity effort",
    "dynamics": " ".join(DYNAMICS_WORDS),
    "mimic": "joint multiplier offset name",
    "loop": "name type",
    "loop/": "predecessor successor axis axis2 dynamics",
    "predecessor": f"link {_POSE}",
    "predecessor/": "origin",
    "successor": f"link {_POSE}",
    "successor/": "origin",
    "loop_joint": "name type",
    "loop_joint/": "link1 link2 axis axis2",
    "link1": f"link {_POSE}",
    "link1/": "origin",
    "link2": f"link {_POSE}",
    "link2/": "origin",
    "constraint": "name type",
    "constraint/": "parent child parent_origin child_origin parent_axis child_axis",
    "parent_origin": f"{_POSE} quat_xyzw",
    "child_origin": f"{_POSE} quat_xyzw",
    "parent_axis": "xyz",
    "child_axis": "xyz",
    "coupling": "name",
    "coupling/": "predecessor successor ratio",
    "ratio": "value",
}
_ATTRIBUTES = {
    tag: frozenset(words.split()) for tag, words in _KNOWN.items() if not tag.endswith("/")
}
"""Element to its attributes, for the elements that are read."""
_CHILDREN = {
    tag[:-1]: frozenset(words.split()) for tag, words in _KNOWN.items() if tag.endswith("/")
}
"""Element to its children, for the elements that are read."""
_NOT_OF_WRENCHES = frozenset(
    {"material", "visual", "collision", "contact", "calibration", "safety_controller"}
)
"""Known elements that have nothing to do with wrenches; what is in them is not read."""


def check_words(robot: ElementTree.Element, where: str, strict: bool) -> list[str]:
    """Refuse misspelled elements and attributes; return warnings about unknown ones.

    Args:
        robot: outermost element of a URDF.
        where: how messages name the source of the text.
        strict: whether words that resemble known ones are refused, too.

    Raises:
        ModelError: a word is not known but resembles a known one.
    """
    unknown: dict[str, int] = {}
    for element in _elements_read(robot):
        children = [child.tag for child in element]
        for kind, words, known in (
            ("element", children, _CHILDREN.get(element.tag)),
            ("attribute", element.keys(), _ATTRIBUTES.get(element.tag)),
        ):
            if known is None or known.issuperset(words):
                continue
            for word in _unknown(words, known):
                similar = similar_word(word.lower(), known)
                if similar and strict:
                    name = f" {element.get('name')!r}" if element.get("name") else ""
                    raise ModelError(
                        f"{where}: <{element.tag}>{name}: {kind} {word!r} is unknown and would be "
                        f"passed over; did you mean {similar!r}? {kind}s: {choices(known)}; "
                        "load(..., strict=False) passes it over"
                    )
                label = f"{kind} {word!r} of <{element.tag}>"
                unknown[label] = unknown.get(label, 0) + 1
    spaces = {
        child.tag[1:].partition("}")[0]: None
        for element in _elements_read(robot)
        for child in element
        if isinstance(child.tag, str) and child.tag.startswith("{")
    }
    return [
        f"{where}: {label} is unknown and was passed over" + (f" ({count} times)" * (count > 1))
        for label, count in unknown.items()
    ] + [f"{where}: elements of the namespace {space!r} were passed over" for space in spaces]


def _elements_read(robot: ElementTree.Element) -> list[ElementTree.Element]:
    """Return the elements whose contents count for wrenches."""
    elements = [robot]
    read = [robot]
    while elements:
        element = elements.pop()
        known = _CHILDREN.get(element.tag, frozenset()) - _NOT_OF_WRENCHES
        children = [child for child in element if child.tag in known]
        read += children
        elements += children
    return read


def _unknown(words: Iterable[str], known: frozenset[str]) -> list[str]:
    """Return the words that are not known and stand in no namespace of another program."""
    return [
        word for word in words if isinstance(word, str) and word not in known and "}" not in word
    ]
