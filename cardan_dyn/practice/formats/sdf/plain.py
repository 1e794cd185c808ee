"""Plain: the model of an SDF text that is read, without what versions of the format say otherwise.

All readings of a text begin here. One model is chosen; models in it become frames with their links
and joints, whose names say where they come from (`arm::hand`); what stands twice and says the same
stands once; a screw becomes a hinge and a slide that follows it; joints that Gazebo's plugin
`DetachableJoint` adds between links of the model are joints. Numbers stay as they are written.
"""

from __future__ import annotations

import math
import re
from copy import deepcopy
from xml.etree.ElementTree import Element, SubElement, fromstring

from ....core.description.elements import one_of, only
from ....kit.errors import ModelError, choices
from .elements import flag, number, text
from .frames import MODEL, WORLD

FIRST_WITH_FRAMES = (1, 7)
"""Version from which on `relative_to`, `attached_to` and `expressed_in` name frames."""
_VERSIONS = ((1, 4), (1, 12))
"""First and last version that is read."""
_AXES_IN_MODEL_UNTIL = (1, 4)
"""Last version whose axes were written in the model's frame."""
TWO_AXES = ("universal", "revolute2", "gearbox")
"""SDF's words for joints that have an `<axis2>`."""
_MASSLESS = """<link><inertial><mass>0</mass>
<inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia></inertial></link>"""
_ZERO_BY_DEFAULT = ("velocity_decay", "dynamics")
"""Elements in which numbers that are not there are zero."""


def plain(
    root: Element, where: str, strict: bool, model: str | None = None
) -> tuple[Element, list[str]]:
    """Return the model of a text, and warnings about what stands beside it.

    Static models beside another one, as the ground in most worlds, touch nothing and are left out.

    Args:
        root: outermost element; it is not changed.
        where: how messages name the source of the text.
        strict: whether what a world includes is refused.
        model: name of the one to read; None where there is only one.

    Raises:
        ModelError: which model is meant is open, or it cannot be said in plain words.
    """
    version = version_of(root, where)
    chosen, warnings = _chosen(root, where, strict, model)
    whole = deepcopy(chosen)
    _merge(whole)
    _flatten(whole, version, where)
    modern(whole, version, where)
    return whole, warnings


def version_of(root: Element, where: str) -> tuple[int, int]:
    """Return the version of the format that a text states."""
    stated = root.get("version") or ""
    if not re.fullmatch(r"[0-9]+\.[0-9]+", stated):
        raise ModelError(f"{where}: <sdf> needs its version, such as 1.9, not {stated!r}")
    major, minor = (int(word) for word in stated.split("."))
    first, last = _VERSIONS
    if not first <= (major, minor) <= last:
        raise ModelError(
            f"{where}: SDF {stated} is not read, only versions {first[0]}.{first[1]} to "
            f"{last[0]}.{last[1]}; `gz sdf -p FILE` converts older ones"
        )
    return major, minor


def modern(model: Element, version: tuple[int, int], where: str) -> None:
    """Let a model name frames as versions from 1.7 on do, whatever its own version is.

    Raises:
        ModelError: it has a word that its version does not know.
    """
    has_names = version >= FIRST_WITH_FRAMES
    word, other = ("relative_to", "frame") if has_names else ("frame", "relative_to")
    joints = model.findall("joint")
    for item in (model, *model.findall("link"), *joints, *model.findall("frame")):
        at = f"{where}: {item.tag}" + f" {item.get('name')!r}" * (item is not model)
        stated = only(item, "pose", at)
        if stated is not None and stated.get(other):
            raise ModelError(f"{at}: pose: in this version of SDF the attribute is called {word!r}")
    for place in model.iter("pose"):
        if "frame" in place.attrib:
            place.set("relative_to", place.get("relative_to") or place.attrib.pop("frame"))
    for joint in joints:
        kind = (joint.get("type") or "").lower()
        for tag in ("axis", "axis2") if kind not in ("fixed", "ball") else ():
            at = f"{where}: joint {joint.get('name')!r}: {tag}"
            axis = only(joint, tag, at)
            if axis is None and (tag == "axis" or kind not in TWO_AXES):
                continue  # Whoever needs it says that it is missing.
            if axis is None:
                axis = SubElement(joint, tag)
            in_model = flag(text(axis, "use_parent_model_frame", "false", at), at)
            xyz = only(axis, "xyz", at)
            if xyz is None:
                xyz = SubElement(axis, "xyz")
            named = xyz.get("expressed_in")
            if named and not has_names:
                raise ModelError(
                    f"{at}: expressed_in is known from SDF 1.7 on; this is an older version"
                )
            if not named and (in_model or version <= _AXES_IN_MODEL_UNTIL):
                xyz.set("expressed_in", MODEL)
            if named or not has_names:  # Else it is to say the same with and without.
                axis[:] = [part for part in axis if part.tag != "use_parent_model_frame"]


def of_urdf(robot: Element, where: str) -> tuple[Element, bool]:
    """Return the model that sdformat makes of a URDF for the joints that `<gazebo>` adds to it.

    Links are placed relative to each other, as joints of the URDF say. These are frames on their
    children, which `<gazebo>` may add to, unless the second value says that a joint has
    `<use_parent_model_frame>`: such a model is one of SDF 1.6, the last version that knows it.
    """
    added = robot.findall("gazebo/joint")
    is_flagged = any(joint.find("*/use_parent_model_frame") is not None for joint in added)
    carried: dict[str, tuple[str, Element]] = {}
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            carried.setdefault(child.get("link", ""), (parent.get("link", ""), joint))
    model, links = Element("model"), [link.get("name", "") for link in robot.findall("link")]
    for link in links:
        if link == WORLD and link not in carried:
            continue
        body = SubElement(model, "link", name=link)
        if link in carried:
            base, joint = carried[link]
            origin = joint.find("origin")
            stated = {} if origin is None else origin.attrib
            pose = SubElement(body, "pose", {"frame" if is_flagged else "relative_to": base})
            pose.text = f"{stated.get('xyz', '0 0 0')} {stated.get('rpy', '0 0 0')}"
    if not is_flagged:
        taken = {*links, *(item.get("name") for item in added)}
        for link, (_, joint) in carried.items():
            if joint.get("name") not in taken:
                SubElement(model, "frame", name=joint.get("name", ""), attached_to=link)
        model.extend(deepcopy(robot.findall("gazebo/frame")))
    model.extend(deepcopy(added))
    modern(model, (1, 6) if is_flagged else (1, 7), where)
    return model, is_flagged


def is_static(model: Element, where: str) -> bool:
    """Return whether a model stands still as a whole."""
    at = f"{where}: model {model.get('name')!r}"
    return flag(text(model, "static", "false", at), f"{at}: static")


def _chosen(root: Element, where: str, strict: bool, name: str | None) -> tuple[Element, list[str]]:
    scopes = [root, *root.findall("world")]
    models = [model for scope in scopes for model in scope.findall("model")]
    chosen = [model for model in models if not is_static(model, where)] or models
    if name is not None:
        chosen = [model for model in models if model.get("name") == name]
        one_of(name, [model.get("name", "") for model in models], "model", where)
    if len(chosen) != 1:
        listed = choices([model.get("name", "") for model in chosen])
        raise ModelError(
            f"{where}: there are {len(chosen)} models ({listed}), expected one; models act on each "
            'other by contact alone, which is not considered: load(..., model="NAME") reads one'
        )
    left = [model for model in models if model is not chosen[0]]
    warnings = [
        f"{where}: {'static ' * is_static(model, where)}model {model.get('name')!r} left out"
        for model in left
    ]
    for tag in ("include", "frame", "joint"):
        for world in root.findall("world"):
            count = len(world.findall(tag))
            if count and (strict or tag != "include"):
                raise ModelError(
                    f"{where}: <{tag}> in <world> is not read: write it into the <model>"
                    + ("; load(..., strict=False) leaves it out" if tag == "include" else "")
                )
            if count:
                warnings.append(f"{where}: {count} <include> of the world left out")
    return chosen[0], warnings


def _merge(element: Element) -> None:
    """Remove children that stand twice, where the second says nothing else than the first."""
    for child in element:
        _merge(child)
    first: dict[str, Element] = {}
    for child in list(element):
        if child.get("name") is not None:
            continue
        known = first.setdefault(child.tag, child)
        if known is not child and _adds_nothing(child, known):
            element.remove(child)


def _adds_nothing(second: Element, first: Element) -> bool:
    """Return whether all that an element says is said by another one, or zero by default."""
    if second.attrib != first.attrib or _said(second) not in ("", _said(first)):
        return False
    for child in second:
        known = first.find(child.tag)
        if known is None:
            if first.tag not in _ZERO_BY_DEFAULT or len(child) or not _is_zero(_said(child)):
                return False
        elif not _adds_nothing(child, known):
            return False
    return True


def _said(element: Element) -> str:
    return (element.text or "").strip()


def _is_zero(word: str) -> bool:
    try:
        return not word or float(word) == 0.0
    except ValueError:
        return False


def _flatten(model: Element, version: tuple[int, int], where: str) -> None:
    """Make frames, links and joints of the models in a model, of its plugins and screws."""
    for inner in model.findall("model"):
        name = inner.get("name") or ""
        at = f"{where}: model {name!r} in {model.get('name')!r}"
        if version < FIRST_WITH_FRAMES:
            raise ModelError(
                f"{at} is not read before SDF 1.7, where frames have names: write its links and "
                "joints into the outer one"
            )
        if not name:
            raise ModelError(f"{at}: it needs a name")
        if inner.get("placement_frame"):
            raise ModelError(f"{at}: placement_frame is not read there; write a <pose>")
        if is_static(inner, where) and not is_static(model, where):
            raise ModelError(f"{at}: a static model in one that moves; fix it to the world instead")
        _flatten(inner, version, where)
        links = [link.get("name", "") for link in inner.findall("link")]
        if not links:
            raise ModelError(f"{at}: it has no <link>")
        model.remove(inner)
        carrier = inner.get("canonical_link") or links[0]
        frame = SubElement(model, "frame", name=name, attached_to=_within(carrier, name))
        stated = only(inner, "pose", at)
        place = Element("pose") if stated is None else stated
        place.set("relative_to", place.get("relative_to") or MODEL)
        frame.append(place)
        for child in inner:
            if child.tag in ("link", "joint", "frame"):
                _rename(child, name)
                model.append(child)
            elif child.tag in ("include", "plugin", "gripper") or (
                child.tag == "enable_wind" and model.find("enable_wind") is None
            ):
                model.append(child)
    _attach(model, where)
    word = "relative_to" if version >= FIRST_WITH_FRAMES else "frame"
    for joint in model.findall("joint"):
        if (joint.get("type") or "").lower() == "screw":
            _replace_screw(model, joint, word, f"{where}: joint {joint.get('name')!r}")


def _within(name: str, model: str) -> str:
    """Return how a model names a frame of a model in it."""
    if name in (WORLD, ""):
        return name
    return model if name == MODEL else f"{model}::{name}"


def _rename(element: Element, model: str) -> None:
    """Let a link, joint or frame of a model in the model stand in the outer one."""
    element.set("name", _within(element.get("name", ""), model))
    for part in element.iter():
        for word in ("relative_to", "attached_to", "expressed_in", "joint"):
            if part.get(word) and (word != "joint" or part.tag == "mimic"):
                part.set(word, _within(part.get(word, ""), model))
    for tag in ("parent", "child", "gearbox_reference_body"):
        for part in element.findall(tag):
            part.text = _within(_said(part), model)
    if element.tag == "link" or (element.tag == "frame" and not element.get("attached_to")):
        place = element.find("pose")
        if place is None:
            place = SubElement(element, "pose")
        place.set("relative_to", place.get("relative_to") or model)
    if element.tag == "frame":
        element.set("attached_to", element.get("attached_to") or model)


def _attach(model: Element, where: str) -> None:
    """Make joints of plugins that hold two links of the model together."""
    names = {item.get("name", "") for item in model.findall("joint")}
    for plugin in model.findall("plugin"):
        at = f"{where}: plugin {plugin.get('name')!r}"
        own = text(plugin, "child_model", "", at) in (MODEL, model.get("name"))
        if not (own and (plugin.get("name") or "").endswith("DetachableJoint")):
            continue
        ends = [text(plugin, f"{end}_link", "", at) for end in ("parent", "child")]
        name = "_to_".join(ends)
        while name in names:
            name += "_"
        names.add(name)
        joint = SubElement(model, "joint", name=name, type="fixed")
        for tag, link in zip(("parent", "child"), ends, strict=True):
            SubElement(joint, tag).text = link
        model.remove(plugin)


def _replace_screw(model: Element, joint: Element, word: str, at: str) -> None:
    """Make a hinge of a screw, and a slide that follows it by the pitch of a turn."""
    pitch, turns = only(joint, "screw_thread_pitch", at), only(joint, "thread_pitch", at)
    if pitch is not None:
        ratio = number(joint, "screw_thread_pitch", "", at) / (2.0 * math.pi)
    elif turns is not None:
        # As Gazebo had it: radians per metre of a left-handed thread.
        turned = number(joint, "thread_pitch", "", at)
        ratio = -1.0 / turned if turned else 0.0
    else:
        raise ModelError(f"{at}: <screw_thread_pitch> is missing: metres per turn")
    if not ratio or not math.isfinite(ratio):
        raise ModelError(f"{at}: a screw without a pitch is a hinge: type revolute")
    name, nut = joint.get("name", ""), f"{joint.get('name')}_nut"
    slide, child = deepcopy(joint), text(joint, "child", "", at)
    joint.set("type", "revolute")
    slide.set("type", "prismatic")
    slide.set("name", f"{name}_slide")
    for item, end in ((joint, "child"), (slide, "parent")):
        for part in item.findall(end):
            part.text = nut
    axis = only(slide, "axis", at)
    if axis is None:
        raise ModelError(f"{at}: <axis><xyz>0 0 1</xyz></axis> is missing")
    for part in [*axis.findall("mimic"), *axis.findall("dynamics"), *axis.findall("limit")]:
        axis.remove(part)
    SubElement(SubElement(axis, "mimic", joint=name), "multiplier").text = repr(ratio)
    between = fromstring(_MASSLESS)
    between.set("name", nut)
    SubElement(between, "pose", {word: child})
    model.append(between)
    model.insert(list(model).index(joint) + 1, slide)
