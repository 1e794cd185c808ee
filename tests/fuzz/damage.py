"""Damage: what breaks a description, as XML elements, as text, and as YAML."""

from __future__ import annotations

import copy
from collections.abc import Callable
from random import Random
from xml.etree import ElementTree

import yaml

Element = ElementTree.Element

NUMBERS = (
    *(" 2 ", "1_0", "٢", "１", "²", "inf", "-inf", "nan", "1e308", "-1e308", "1e-320", "1e-300"),
    *("0x10", "-0", "0", "1e", "", " ", "+.5", "5.", ".", "-", "1,5", "1e400", "1d3", "1f", "2;"),
    *("0.1 0.2", "1 2 3 4", "1\t2\n3", "\u00a02", "2\u2009", "--1", "+-1", "1e+", "1.2.3", "True"),
    *("1e5", "-3", "1e12", "1e-12", "9" * 400, "0." + "0" * 400 + "1", "infinity", "NaN(1)", "1L"),
)
NAMES = (
    *(
        "",
        " ",
        "universe",
        "world",
        "root_joint",
        "ground",
        "ä",
        "关节",
        "a b",
        "a:1",
        "b:1",
        "x/y",
    ),
    *("n" * 5000, "\u202e", "a\u0301", "%s", "{0}", "'", "&quot;", "..", "0", "None", "A", "\t"),
    *("speed²", "gravity x", "acceleration", "world_bodies", "equality_1", "loop_1", "a ", " a"),
)
TYPES = (
    *("revolute", "continuous", "prismatic", "fixed", "planar", "floating", "spherical"),
    *("universal", "cylindrical", "ball", "hinge", "slide", "free", "Revolute", "", " fixed", "x"),
)
TAGS = (
    *("inertial", "mass", "inertia", "origin", "axis", "axis2", "link", "joint", "loop", "limit"),
    *("loop_joint", "coupling", "mimic", "robot", "body", "site", "geom", "include", "parent"),
    *("Joint", "velocity_ratios", "gazebo", "x", "dynamics", "equality", "freejoint", "default"),
)
WHOLE = (
    '<link name="loose"/>',
    '<link name="heavy"><inertial><mass value="7"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    "</link>",
    '<joint name="extra" type="fixed"><parent link="ground"/><child link="loose"/></joint>',
    '<coupling name="g"><predecessor link="crank"/><successor link="rocker"/><ratio value="2"/>'
    "</coupling>",
    '<mimic joint="a" multiplier="2"/>',
    '<limit lower="1" upper="-1" effort="x" velocity=""/>',
    '<dynamics damping="3" friction="x"/>',
    '<origin xyz="1 1 1" quat_xyzw="0 0 0 2"/>',
    '<origin xyz="0.5 0 0"/>',
    '<axis xyz="0 0 0"/>',
    '<axis xyz="1e-200 0 0"/>',
    '<axis xyz="1e200 1e200 0"/>',
    '<inertial><mass value="4"/><inertia ixx="1" iyy="1" izz="1"/></inertial>',
    '<inertial><origin rpy="1 2 3"/><mass value="4"/><inertia ixx="1e-9" iyy="1e9" izz="1e9"/>'
    "</inertial>",
    '<mass value="9"/>',
    '<geometry><box size="1 1 1"/></geometry>',
    '<joint name="twist" type="hinge" axis="1 0 0"/>',
    '<joint type="ball"/>',
    "<freejoint/>",
    '<geom type="box" size="1 1 1"/>',
    '<inertial pos="0 0 0" mass="5" diaginertia="1 1 1"/>',
    '<body name="more"><inertial pos="0 0 0" mass="5" diaginertia="1 1 1"/></body>',
    '<include file="nowhere.xml"/>',
    '<include file="model.xml"/>',
    '<connect body1="crank" body2="crank" anchor="0 0 0"/>',
    '<replicate count="3"><body name="r"/></replicate>',
    '<frame pos="1 0 0"/>',
    '<compiler angle="degree" inertiafromgeom="true" coordinate="global"/>',
    '<compiler autolimits="x" eulerseq="abc"/>',
    '<compiler meshdir="/" strippath="maybe"/>',
)


def _all(root: Element) -> list[Element]:
    return list(root.iter())


def _some(rng: Random, root: Element) -> Element:
    """Return an element, in a way that does not prefer the many of one kind."""
    elements = _all(root)
    tag = rng.choice(sorted({str(item.tag) for item in elements}))
    return rng.choice([item for item in elements if item.tag == tag])


def _parents(root: Element) -> dict[Element, Element]:
    return {child: parent for parent in root.iter() for child in parent}


def _numeric(value: str) -> bool:
    return bool(value.strip()) and all(c in "0123456789.+-eE \t\n" for c in value)


def number(rng: Random, root: Element) -> None:
    """Put an odd number in the place of one."""
    attributes = [
        (item, key) for item in _all(root) for key, value in item.items() if _numeric(value)
    ]
    if attributes:
        item, key = rng.choice(attributes)
        words = item.attrib[key].split()
        words[rng.randrange(len(words))] = rng.choice(NUMBERS)
        item.set(key, " ".join(words) if rng.random() < 0.9 else rng.choice(NUMBERS))


def scale(rng: Random, root: Element) -> None:
    """Make all lengths, or all masses, huge or small."""
    factor = rng.choice([1e-12, 1e-6, 1e6, 1e12, 1e150, 1e-150, 1e300, -1.0])
    keys = rng.choice([("xyz", "pos", "anchor"), ("value", "mass"), ("ixx", "iyy", "izz")])
    for item in root.iter():
        for key in keys:
            value = item.get(key, "")
            if _numeric(value):
                try:
                    item.set(key, " ".join(repr(float(word) * factor) for word in value.split()))
                except ValueError:
                    continue


def attribute(rng: Random, root: Element) -> None:
    """Remove, rename, add or swap an attribute."""
    item = _some(rng, root)
    if not item.attrib:
        item.set(rng.choice(["name", "value", "xyz", "type"]), rng.choice(NAMES[:-3]))
        return
    key = rng.choice(list(item.attrib))
    action = rng.randrange(4)
    value = item.attrib[key]
    if action == 0:
        del item.attrib[key]
    elif action == 1:
        del item.attrib[key]
        item.set(rng.choice(["Name", "name ", "xyz", "rpy", "value", "link", "x"]).strip(), value)
    elif action == 2:
        other = _some(rng, root)
        item.set(key, other.get(key, value))
    else:
        new = ["independent", "active", "type", "rpy", "link", "frame", "class", "name", "mocap"]
        item.set(rng.choice(new), rng.choice(["true", "false", "maybe", "1", "", "TRUE", value]))


def element(rng: Random, root: Element) -> None:
    """Remove, double, move or nest an element."""
    parents = _parents(root)
    item = _some(rng, root)
    if item is root:
        return
    parent = parents[item]
    action = rng.randrange(6)
    if action == 0:
        parent.remove(item)
    elif action == 1:
        batch = copy.deepcopy(item)
        parent.insert(rng.randrange(len(parent) + 1), batch)
        if rng.random() < 0.5:
            number(rng, batch)
    elif action == 2:
        target = rng.choice([other for other in _all(root) if other not in set(item.iter())])
        parent.remove(item)
        target.insert(rng.randrange(len(target) + 1), item)
    elif action == 3:
        wrapped = Element(rng.choice(TAGS))
        parent[list(parent).index(item)] = wrapped
        wrapped.append(item)
    elif action == 4:
        item.append(copy.deepcopy(item))
    else:
        children = list(parent)
        rng.shuffle(children)
        parent[:] = children


def insert(rng: Random, root: Element) -> None:
    """Put in an element that may or may not be meant for this place."""
    target = root if rng.random() < 0.3 else _some(rng, root)
    target.insert(rng.randrange(len(target) + 1), ElementTree.fromstring(rng.choice(WHOLE)))


def tag(rng: Random, root: Element) -> None:
    """Give an element another tag."""
    _some(rng, root).tag = rng.choice(TAGS)


def rename(rng: Random, root: Element) -> None:
    """Give something another name, everywhere or in one place."""
    named = [item for item in _all(root) if "name" in item.attrib]
    if not named:
        return
    item = rng.choice(named)
    old = item.attrib["name"]
    new = rng.choice(NAMES) if rng.random() < 0.7 else rng.choice(named).attrib["name"]
    everywhere = rng.random() < 0.6
    for other in root.iter() if everywhere else [item]:
        for key, value in other.items():
            if value == old:
                other.set(key, new)


def retype(rng: Random, root: Element) -> None:
    """Change the type of a joint or loop."""
    typed = [item for item in _all(root) if "type" in item.attrib]
    if typed:
        rng.choice(typed).set("type", rng.choice(TYPES))


def rewire(rng: Random, root: Element) -> None:
    """Let joints and loops connect other links: rings, two parents, a link with itself."""
    keys = ("link", "body1", "body2", "site1", "site2")
    ends = [(item, key) for item in _all(root) for key in keys if key in item.attrib]
    if not ends:
        return
    for _ in range(rng.choice([1, 1, 2])):
        item, key = rng.choice(ends)
        if rng.random() < 0.85:
            item.set(key, rng.choice([other.attrib[name] for other, name in ends]))
        else:
            item.set(key, rng.choice(NAMES))


def inertia(rng: Random, root: Element) -> None:
    """Break an inertia."""
    elements = [item for item in _all(root) if item.tag in ("inertia", "mass", "inertial")]
    if not elements:
        return
    item = rng.choice(elements)
    odd = ["-1", "0", "1e9", "1e-320", "1e300", "1e-30", "0.05500000001", "1e154"]
    key = rng.choice(["ixx", "iyy", "izz", "ixy", "ixz", "iyz"])
    if item.tag == "mass":
        key = "value"
    elif item.tag == "inertial":
        key = rng.choice(["mass", "pos", "quat", "diaginertia", "fullinertia"])
        size = {"mass": 1, "pos": 3, "quat": 4, "diaginertia": 3, "fullinertia": 6}[key]
        item.set(key, " ".join(rng.choice(odd) for _ in range(size)))
        return
    item.set(key, rng.choice(odd))


ELEMENTS: tuple[tuple[float, Callable[[Random, Element], None]], ...] = (
    (6.0, number),
    (1.0, scale),
    (4.0, attribute),
    (4.0, element),
    (3.0, insert),
    (1.0, tag),
    (3.0, rename),
    (2.0, retype),
    (3.0, rewire),
    (2.0, inertia),
)


def break_elements(rng: Random, root: Element) -> str:
    """Break a tree of elements in one way; return which."""
    (damage,) = rng.choices([damage for _, damage in ELEMENTS], [weight for weight, _ in ELEMENTS])
    damage(rng, root)
    return damage.__name__


def _entities(text: str, depth: int) -> str:
    """Put entities before a text that expand tenfold per level."""
    levels = ['<!ENTITY e0 "0 ">']
    levels += [f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, depth + 1)]
    body = text.replace('xyz="', f'xyz="&e{depth};', 1)
    return f"<!DOCTYPE robot [{''.join(levels)}]>{body}"


def break_text(rng: Random, text: str) -> str:
    """Damage XML as text; some of it stays well-formed and has to be read as it is meant."""
    cut = rng.randrange(len(text) + 1)
    gap = text.find(">", cut) + 1 or len(text)
    value = text.find('value="', cut)
    start = text.find("<", 1)
    damages: list[Callable[[], str]] = [
        lambda: text[:cut],
        lambda: text[:cut] + rng.choice("<>&\"'\x00 \x0bé=/") + text[cut + 1 :],
        lambda: text[:gap] + "<!-- a -- b -->" + text[gap:],
        lambda: text[:gap] + "<!-- <link name='x'/> -->" + text[gap:],
        lambda: text[:gap] + "<![CDATA[<link name='x'/>]]>" + text[gap:],
        lambda: text[:gap] + "<?note value='1'?>" + text[gap:],
        lambda: text[:gap] + "stray text" + text[gap:],
        lambda: "\ufeff" + text,
        lambda: "\n \t" + text,
        lambda: text + text,
        lambda: text.replace("<robot ", '<robot xmlns="http://example.org/robot" ', 1),
        lambda: text.replace("<robot ", '<robot xmlns:x="http://example.org/x" x:name="y" ', 1),
        lambda: text.replace("<joint ", '<x:joint xmlns:x="http://example.org/x" ', 1),
        lambda: '<?xml version="1.0" encoding="utf-16"?>' + text,
        lambda: '<?xml version="1.1"?>' + text,
        lambda: '<?xml version="1.0" encoding="nonsense"?>' + text,
        lambda: _entities(text, rng.choice([1, 2, 9])),
        lambda: '<!DOCTYPE robot SYSTEM "file:///nowhere.dtd">' + text,
        lambda: '<!DOCTYPE r [<!ENTITY m "3">]>' + text[:value] + 'value="&m;" ' + text[value:],
        lambda: text[:value] + 'value="&#50;" old_' + text[value:] if value > 0 else text,
        lambda: text[:value] + 'value="&#10;2&#9;" old_' + text[value:] if value > 0 else text,
        lambda: text[:value] + 'value="3" ' + text[value:] if value > 0 else text,
        lambda: text.replace('"', "'"),
        lambda: text.replace("<", "< ", rng.randint(1, 3)),
        lambda: text[:start] + text[start:].upper(),
        lambda: text.replace(".", ",", 3),
        lambda: text.replace(" ", "\r\n"),
        lambda: text[:gap] + "<x>" * 400 + "</x>" * 400 + text[gap:],
        lambda: "",
        lambda: "<",
    ]
    return rng.choice(damages)()


VALUES: tuple[object, ...] = (
    *(None, True, 3, -1.5, float("nan"), "x", "", "3d", "6D", "a", "universe", {}, {"a": 1}, []),
    *([[]], [[["tip"]]], ["tip", "end"], [["tip", "end"], ["tip", "end"]], [["tip", "tip"]]),
    *([[1, 2]], [None], [{"tip": "end"}], ["6d", 3], ["3d", "6d"], [["tip", "end", "tip"]]),
    *(["fixed"], ["floating"], ["spherical"], ["a", "a"], ["b", "d"], "tip", 10**400, [["tip", 1]]),
    *(["tip_joint"], ["end_joint"], ["revolute"], [["tip", ["end"]]], ["a", ["b"]], [{}], [True]),
)
KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type", "other")
LINES = (
    *("\t- x", "a: &a [*a]", "closed_loop: *nowhere"),
    *("--- 1", "%YAML 9.9", "? [1]: 2", "!!python/x"),
    *("{", "]: [", "a: !!binary x", "2001-13-99: 1"),
    *("<<: 3", "a: b: c", "\x00", "- - - -", "type:"),
    *("closed_loop: !!set {a, b}", "1: 2", "[1, 2]: 3", "'", "a: 0x", "name_mot: 2001-01-01"),
)


def break_yaml(rng: Random, text: str) -> str:
    """Damage a YAML file: values of wrong types, missing or strange keys, or the text itself."""
    action = rng.randrange(6)
    if action == 0:
        return text[: rng.randrange(len(text) + 1)]
    if action == 1:
        lines = text.splitlines()
        lines.insert(rng.randrange(len(lines) + 1), rng.choice(LINES))
        return "\n".join(lines)
    if action == 2:
        return yaml.safe_dump(rng.choice(VALUES))
    if action == 3 and rng.random() < 0.3:
        return "a: " + "[" * 3000 + "]" * 3000
    try:
        content = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError):
        return text
    if not isinstance(content, dict):
        return text
    if action == 4 and content:
        content.pop(rng.choice(list(content)))
    else:
        content[rng.choice(KEYS)] = rng.choice(VALUES)
    return yaml.safe_dump(content)
