"""Elements: what URDF-like XML elements say, read and checked."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, ParseError, fromstring

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from .description import IDENTITY, TWO_AXES, Dynamics, LoopDescription, kinds_of

JOINT_TYPES = frozenset({"revolute", "continuous", "prismatic", "fixed", "planar", "floating"})
"""Types of tree joints that URDF has."""
ADDED_TYPES = frozenset({"spherical", "universal", "cylindrical"})
"""Types that this package adds to those of URDF, for loops and for tree joints."""
TREE_TYPES = JOINT_TYPES | ADDED_TYPES
"""Types of tree joints that can be loaded."""
SINGLE_TYPES = frozenset({"revolute", "continuous", "prismatic"})
"""Types of joints that have one coordinate."""
ADJUSTABLE_TYPES = frozenset({"revolute", "prismatic"})
"""What fixed joints may become in scenes that hold or drive them."""
LOOP_TYPES = TREE_TYPES - {"floating"}
"""Types of loops that can be closed."""

MOST_LINKS = 2000
"""Greatest number of links of a description: larger ones were never tested."""
GREATEST = 1e50
"""Greatest number in a description: products of several of them are still far from overflow."""
LEAST_MASS = 1e-50
"""Least positive mass [kg]; `GREATEST` bounds its reciprocal as well."""
_LEAST = 1e-150
"""Smaller numbers are read as zero: their squares would vanish (1e-300 is about the least double),
so that a vector of them had components but no length."""
DIRECTION_TOLERANCE = 1e-9
"""Greatest sine between axes of one direction, and greatest cosine between those at right angles:
what axes written with ten digits have."""
ROTATION_TOLERANCE = 1e-9
"""Greatest difference between a matrix and the rotation that is written for it. Rotations that were
read differ by some 1e-15; whatever is no rotation (a reflection, a scaled one) by much more."""
_ENCODING = re.compile(rb"""\s*<\?xml[^>]*?\sencoding\s*=\s*["']([^"']+)""")
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)
_ELSEWHERE = re.compile("""<!(?:DOCTYPE|ENTITY)\\s[^>"']*?\\s(?:SYSTEM|PUBLIC)\\s""")
"""What refers to another document."""
_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_NUMBERS = re.compile(rf"[ \t\r\n]*{_NUMBER}(?:[ \t\r\n]+{_NUMBER})*[ \t\r\n]*")
"""Decimal numbers as XML Schema has them, with blanks between and around them."""


def check_size(links: int, where: str) -> None:
    """Refuse a description that is larger than anything was tested with.

    Raises:
        ModelError: it has more than `MOST_LINKS` links.
    """
    if links > MOST_LINKS:
        raise ModelError(
            f"{where}: there are {links} links, the limit is {MOST_LINKS}; describe what moves "
            "together as one link, or load parts of it"
        )


def file_text(path: Path, where: str) -> str | bytes:
    """Return a file's text where it is in UTF-16 or UTF-32, or a byte order mark says what it is.

    Else its bytes: the parsers of XML and YAML find out the rest from them.

    Raises:
        ModelError: it cannot be read, or is not what its first bytes say.
    """
    try:
        data = path.read_bytes()
        codec = json.detect_encoding(data)  # It goes by null bytes and marks, whatever follows.
        return data if codec == "utf-8" else data.decode(codec)
    except (OSError, MemoryError, ValueError) as error:
        raise ModelError(f"{where}: cannot be read ({error})") from error


def xml_root(source: str | bytes, where: str) -> tuple[Element, str]:
    """Return the outermost element of an XML text or file, and the text.

    Raises:
        ModelError: it is malformed; or its DOCTYPE, or an entity that this defines, is in another
            document, so that it would silently be read as nothing.
    """
    try:
        text = source
        if isinstance(text, bytes):
            declared = _ENCODING.match(text)
            text = text.decode(declared[1].decode() if declared else "utf-8")
        plain = _COMMENT.sub("", text)
        try:
            root = fromstring(text)
        except ParseError as error:
            # Gazebo, ROS and MuJoCo read comments with "--" in them, and blanks ahead of it all.
            try:
                text = plain.strip()
                root = fromstring(text)
            except ParseError:
                raise error from None
    except (ParseError, ValueError, LookupError) as error:
        hint = ""
        if isinstance(source, bytes) and not source.isascii():
            hint = "; is it in the encoding that it declares, UTF-8 where it declares none?"
        if where.endswith(".toml"):
            hint = "; drive lines in TOML are for `cardan-dyn driveline` and cd.drive_lines"
        raise ModelError(f"{where}: malformed XML: {error}{hint}") from error
    if _ELSEWHERE.search(plain):
        raise ModelError(f"{where}: its DOCTYPE refers to another document, which is not read")
    return root, text


def only(element: Element, tag: str, at: str) -> Element | None:
    """Return the child element of a kind, None without one.

    Raises:
        ModelError: there are several, and it is open which of them counts.
    """
    children = element.findall(tag)
    if children[1:]:
        word = tag.removeprefix("{*}")
        raise ModelError(f"{at}: there are {len(children)} <{word}> in <{element.tag}>; keep one")
    return children[0] if children else None


DYNAMICS_WORDS = ("damping", "friction", "spring_stiffness", "spring_reference")
"""Words of URDF and SDF for the fields of `Dynamics`; URDF itself has the first two."""


def dynamics_of(joint: Element, at: str) -> Dynamics:
    """Return what the `<dynamics>` of a `<joint>` or `<loop>` states, zero where it states none.

    Raises:
        ModelError: they are no numbers.
    """
    dynamics = only(joint, "dynamics", at)
    if dynamics is None:
        return Dynamics()
    return Dynamics(
        *(number(dynamics.get(key), "0", f"{at}: dynamics {key}") for key in DYNAMICS_WORDS)
    )


def armature_of(joint: Element, kind: str, at: str) -> tuple[float, ...]:
    """Return the armature that the `<dynamics>` of a `<joint>` or `<loop>` of a type states.

    Raises:
        ModelError: it is neither a number nor one for each part.
    """
    dynamics = joint.find("dynamics")  # Whoever reads its forces asks whether it is the only one.
    stated = None if dynamics is None else dynamics.get("armature")
    if stated is None:
        return ()
    at = f"{at}: dynamics armature"
    return armature(listed(stated, at), kind, at)


def armature(values: Sequence[float], kind: str, at: str) -> tuple[float, ...]:
    """Return the armature of a joint type's parts; none if it is zero, or the joint is fixed.

    Args:
        values: of all parts, or of each.
        kind: the joint type.
        at: how messages name it.

    Raises:
        ModelError: it is negative or beyond `GREATEST`, there are not as many, or a plane's slides,
            which lie in it as they like, have different ones.
    """
    kinds = kinds_of(kind)
    if not kinds or not any(values):
        return ()
    if min(values) < 0.0:
        raise ModelError(f"{at}: {min(values):g} is negative, which no inertia is")
    if not all(value <= GREATEST for value in values):
        raise ModelError(
            f"{at}: {words(values)} is beyond {GREATEST:.0e}; choose units in which numbers are "
            "not so far from 1"
        )
    if len(values) not in (1, len(kinds)):
        raise ModelError(
            f"{at}: there are {len(values)} numbers; write one for all motions of the {kind} "
            f"joint, or one for each, from the parent outwards: {', '.join(kinds)}"
        )
    found = tuple(values) if len(values) == len(kinds) else tuple(values) * len(kinds)
    if len({value for value, part in zip(found, kinds, strict=True) if part == "prismatic"}) > 1:
        raise ModelError(
            f"{at}: the slides of a {kind} joint have no directions of their own, and so one "
            f"inertia, not {words(found)}; write joints that slide in a row"
        )
    return found


def names(robot: Element, tag: str, where: str) -> list[str]:
    """Return the names of all elements of a kind, each of which occurs once."""
    listed = [name_of(element, where) for element in robot.findall(tag)]
    check_unique(listed, tag, where)
    return listed


def check_unique(names: list[str], what: str, where: str) -> None:
    """Refuse names that occur twice.

    Raises:
        ModelError: which ones do; `what` says in the message of what kind they are.
    """
    if len(set(names)) < len(names):
        repeated = [name for name, count in Counter(names).items() if count > 1]
        raise ModelError(f"{where}: {what} names that occur twice: {choices(repeated)}")


def unique(name: str, taken: set[str]) -> str:
    """Return a name that was not taken, and is then: `name`, if need be with a number behind it."""
    candidate, count = name, 1
    while candidate in taken:
        count += 1
        candidate = f"{name}_{count}"
    taken.add(candidate)
    return candidate


def name_of(element: Element, where: str) -> str:
    """Return the name of an element, which must have one."""
    name = element.get("name")
    if not name:
        raise ModelError(f"{where}: a <{element.tag}> has no name")
    return name


def one_of(
    name: str | None, known: Collection[str], what: str, at: str, fault: str = "does not exist"
) -> str:
    """Return a name that is known.

    Raises:
        ModelError: it is not; the message lists those that are.
    """
    if name is None or name not in known:
        listed = choices(known, name)
        raise ModelError(f"{at}: {what} {name!r} {fault}; {what.split()[-1]}s: {listed}")
    return name


def link_of(element: Element, tag: str, links: Collection[str], at: str) -> str:
    """Return the name of an existing link that a child element points to."""
    child = only(element, tag, at)
    if child is None or not child.get("link"):
        raise ModelError(f'{at}: <{tag} link="..."/> is missing')
    return one_of(child.get("link"), links, f"{tag} link", at)


def ends_of(joint: Element) -> tuple[str, str]:
    """Return the links that a joint's text names as parent and child; empty where it names none."""
    parent, child = (
        "" if end is None else end.get("link", "") for end in map(joint.find, ("parent", "child"))
    )
    return parent, child


def numbers(text: str | None, count: int, default: str, at: str) -> Array:
    """Return the numbers `(count,)` that an attribute lists.

    They are decimal numbers as XML knows them, with blanks between and around them. Python would
    also accept `1_0` and digits of other scripts, which other programs read differently or not
    at all.

    Args:
        text: the attribute's value; None where the element does not have the attribute.
        count: how many numbers it has to list.
        default: the text that counts without the attribute; empty where it must be there.
        at: how messages name the attribute.

    Raises:
        ModelError: these are not `count` finite numbers up to `GREATEST`.
    """
    return np.array(_numbers(text, count, default, at))


def _numbers(
    text: str | None, count: int, default: str, at: str, greatest: float = GREATEST
) -> list[float]:
    """Return what an attribute lists, see `numbers`."""
    stated = default if text is None else text
    values = []
    # Written with few calls: a description has hundreds of attributes.
    for word in stated.split() if _NUMBERS.fullmatch(stated) else ():
        value = float(word)
        if not -greatest <= value <= greatest:
            raise ModelError(
                f"{at}: {text!r} is beyond {GREATEST:.0e}; choose units in which numbers are not "
                "so far from 1"
            )
        values += [0.0 if -_LEAST < value < _LEAST else value]
    if len(values) != count:
        raise ModelError(f"{at}: {text!r} is not {count} finite number{'s' * (count != 1)}")
    return values


def listed(text: str, at: str) -> tuple[float, ...]:
    """Return the numbers that an attribute lists, however many; see `numbers`."""
    return tuple(_numbers(text, max(len(text.split()), 1), "", at))


def words(values: Iterable[float]) -> str:
    """Return numbers as text from which they are read back to the last bit."""
    # Adding zero removes the sign of negative zeros.
    return " ".join(repr(float(value) + 0.0) for value in values)


def number(text: str | None, default: str, at: str) -> float:
    """Return the number that an attribute states, see `numbers`."""
    return _numbers(text, 1, default, at)[0]


def bound(text: str | None, sign: float, default: str, at: str) -> float:
    """Return the number that a limit states, see `numbers`; `sign` times infinite beyond them.

    SDFormat writes the greatest double where there is no limit.
    """
    value = _numbers(text, 1, default, at, math.inf)[0]
    return sign * math.inf if sign * value > GREATEST else number(text, default, at)


def at_point(point: Array) -> Array:
    """Return the `(4, 4)` placement at a point `(3,)`, axes parallel."""
    result = np.eye(4)
    result[:3, 3] = point
    return result


def placement(element: Element, at: str) -> Array:
    """Return the `(4, 4)` placement of an element's <origin>; identity where it has none."""
    origin = only(element, "origin", at)
    return IDENTITY if origin is None else pose(origin, at)


def pose(origin: Element, at: str) -> Array:
    """Return the `(4, 4)` placement that an element's attributes xyz and rpy describe."""
    if origin.get("quat_xyzw") is not None:
        raise ModelError(f"{at}: origin quat_xyzw is not read; write rpy instead")
    result = IDENTITY.copy()
    result[:3, 3] = _numbers(origin.get("xyz"), 3, "0 0 0", f"{at}: origin xyz")
    angles = origin.get("rpy")
    if angles is not None:
        result[:3, :3] = rotation(*_numbers(angles, 3, "", f"{at}: origin rpy"))
    return result


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Return the `(3, 3)` rotation of angles [rad] about the fixed axes x, then y, then z."""
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def unit(vector: Array, at: str) -> Array:
    """Return a vector scaled to the length 1.

    Raises:
        ModelError: it has no direction.
    """
    # The squares of very small components would vanish.
    greatest = float(np.max(np.abs(vector)))
    if greatest == 0.0:
        raise ModelError(f"{at}: a vector of zeros has no direction")
    scaled = vector / greatest
    return scaled / np.linalg.norm(scaled)


def rotation_of_quaternion(quaternion: Array, at: str) -> Array:
    """Return the `(3, 3)` rotation of a quaternion w x y z of any length."""
    w, x, y, z = unit(quaternion, at)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def axis_of(element: Element, at: str, tag: str = "axis") -> Array:
    """Return the `(3,)` unit axis of an element."""
    child = only(element, tag, at)
    if child is not None and child.get("xyz") is None:
        raise ModelError(f'{at}: <{tag}> has no xyz; write <{tag} xyz="0 0 1"/>, or leave it out')
    axis = numbers(None if child is None else child.get("xyz"), 3, "1 0 0", f"{at}: {tag} xyz")
    return direction(axis, f"{at}: the {tag}")


def direction(axis: Array, at: str) -> Array:
    """Return the `(3,)` unit vector of an axis.

    Raises:
        ModelError: it has none; `at` says in the message what it is.
    """
    length = math.sqrt(axis @ axis)
    # The squares of the components of shorter axes lose digits, and so does their direction.
    if length < 1.0 / GREATEST:
        raise ModelError(
            f"{at} {axis.tolist()} has no direction; its length is to be 1 and may be from "
            f"{1.0 / GREATEST:.0e} to {GREATEST:.0e}"
        )
    return axis / length


def axes_of(
    element: Element, kind: str, at: str, tags: tuple[str, str] = ("axis", "axis2")
) -> tuple[Array, Array]:
    """Return both `(3,)` unit axes of a joint of a kind, which are one but for `TWO_AXES`.

    Args:
        element: the joint.
        kind: its type.
        at: how messages name it.
        tags: the elements that state its axes.

    Raises:
        ModelError: an axis has no direction, or two are not at right angles.
    """
    first, second = tags
    axis = axis_of(element, at, first)
    if kind not in TWO_AXES and (first == "axis" or element.find(second) is None):
        return axis, axis
    axis_2 = axis_of(element, at, second)
    if kind not in TWO_AXES:
        # Both frames turn about it or slide along it, so that it has the same components in both.
        if kind in SINGLE_TYPES and np.linalg.norm(np.cross(axis, axis_2)) > DIRECTION_TOLERANCE:
            raise ModelError(
                f"{at}: {first} {axis.tolist()} and {second} {axis_2.tolist()} differ, and both "
                f"frames share the axis of a hinge or slide; turn one origin, or leave {second} out"
            )
    elif abs(float(axis @ axis_2)) > DIRECTION_TOLERANCE:
        raise ModelError(
            f"{at}: a {kind} joint needs <{first}> and <{second}> at right angles, not "
            f"{axis.tolist()} and {axis_2.tolist()}"
        )
    return axis, axis_2


class _Words(NamedTuple):
    """In what words a notation writes a loop.

    Attributes:
        sides: elements that name the links of predecessor and successor.
        axes: elements that state its axes.
        types: its word for a type to that type.
    """

    sides: tuple[str, str]
    axes: tuple[str, str] = ("axis", "axis2")
    types: Mapping[str, str] = dict(zip(LOOP_TYPES, LOOP_TYPES, strict=True))


_CUT = ("revolute", "prismatic", "universal", "spherical")
NOTATIONS = {
    "loop": _Words(("predecessor", "successor")),
    "loop_joint": _Words(("link1", "link2")),
    "constraint": _Words(
        ("parent", "child"),
        ("parent_axis", "child_axis"),
        {f"{kind}{end}": kind for end in ("", "_joint") for kind in _CUT} | {"link": "fixed"},
    ),
}
"""Elements that are loops: of URDF+, of Isaac, and as proposed for ROS."""


def loop(element: Element, links: Collection[str], where: str) -> LoopDescription:
    """Return the loop that an element of `NOTATIONS` states.

    Args:
        element: with `name`, `type`, a child per side, and axes.
        links: names of all links.
        where: how messages name the source of the text.

    Raises:
        ModelError: what is wrong with it.
    """
    name, words = name_of(element, where), NOTATIONS[element.tag]
    at = f"{where}: {element.tag} {name!r}"
    kind = words.types[one_of(element.get("type"), words.types, "type", at, "is not supported")]
    first, second = words.sides
    ends = link_of(element, first, links, at), link_of(element, second, links, at)
    origins = _end(element, first, at), _end(element, second, at)
    axis, axis_2 = axes_of(element, kind, at, words.axes)
    stated = dynamics_of(element, at), armature_of(element, kind, at)
    return LoopDescription(name, kind, *ends, *origins, axis, axis_2, *stated)


def _end(element: Element, tag: str, at: str) -> Array:
    """Return the placement of a loop's frame in the link of a side."""
    side = only(element, tag, at)
    if element.tag == "constraint" or side is None:
        origin = only(element, f"{tag}_origin", at)
        return IDENTITY if origin is None else pose(origin, at)
    # URDF+ has an <origin> in each side; Isaac writes its attributes on the side itself.
    if side.find("origin") is None:
        return pose(side, at)
    if side.get("xyz") is not None or side.get("rpy") is not None:
        raise ModelError(f"{at}: <{tag}> has attributes xyz or rpy and an <origin>; keep one")
    return placement(side, at)


def adjustable_type(element: Element, kind: str, at: str) -> str:
    """Return what a fixed joint becomes where a scene holds or drives it; empty if it stays fixed.

    Raises:
        ModelError: the joint is not fixed, or cannot become that.
    """
    becomes = element.get("adjustable", "")
    if becomes and kind != "fixed":
        raise ModelError(f"{at}: only fixed joints are adjustable, and its type is {kind!r}")
    if becomes and becomes not in ADJUSTABLE_TYPES:
        raise ModelError(
            f"{at}: a joint cannot be adjustable {becomes!r}; types: "
            f"{choices(ADJUSTABLE_TYPES, becomes)}"
        )
    return becomes
