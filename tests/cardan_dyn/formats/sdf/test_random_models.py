"""Random models of SDF, with all that public ones have, against MuJoCo's dynamics of the same ones.

What is drawn are placements in the world. Their SDF states each in any frame, in the words of any
version; MuJoCo's model states all in the world, so that none of its bodies but free ones is placed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from testkit.mujoco_loops import (
    Closure,
    Loops,
    framed,
    passive_force,
    passive_forces,
    same_dynamics,
    same_tree,
    screws,
)
from testkit.sdf import INERTIAL, placements

import cardan_dyn as cd

VERSIONS = ("1.4", "1.6", "1.7", "1.9", "1.12")
KINDS = ("revolute", "continuous", "prismatic", "ball", "universal", "fixed", "screw")
OURS = {"ball": "spherical", "screw": "revolute"}
"""SDF's word for a joint to that of a closed one here."""
ROWS = {"ball": 3, "universal": 4, "fixed": 6, "revolute": 5}
ARM = "arm"
"""The model in the model."""


@dataclass
class Joint:
    """A joint, placed in the world, its axes `(3,)` as well."""

    name: str
    kind: str
    parent: str
    child: str
    placement: np.ndarray
    axis: np.ndarray
    axis_2: np.ndarray
    is_cut: bool = False
    pitch: float = 0.0
    dynamics: dict[str, float] = field(default_factory=dict)


@dataclass
class Link:
    """A link, placed in the world.

    Attributes:
        mass, centre, inertia: what MuJoCo is told, the last two in the axes of the link.
        solid: the same for MuJoCo where shapes say it.
    """

    placement: np.ndarray
    text: str
    mass: float = 1.0
    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.eye(3))
    solid: list[tuple[str, np.ndarray]] = field(default_factory=list)


class Drawn:
    """A model, drawn by its seed.

    Attributes:
        couplings: follower, leader and ratio of joints.
        told: what acts and is no part of wrenches, as messages call it.
    """

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.version = str(self.rng.choice(VERSIONS))
        self.has_names = self.version not in ("1.4", "1.6")
        self.told: list[str] = []
        self.couplings: list[tuple[str, str, float]] = []
        self.links: dict[str, Link] = {}
        self.joints: dict[str, Joint] = {}
        self.more = ""
        inner: set[str] = set()
        for index in range(self.rng.integers(2, 8)):
            name = f"l{index}"
            if self.has_names and self.rng.random() < 0.35:
                name = f"{ARM}::{name}"
                inner.add(name)
            self.links[name] = self.link(name)
            if index and self.rng.random() < 0.07:
                continue  # It floats.
            known = [*self.links][:-1] or ["world"]
            parent = "world" if self.rng.random() < 0.2 else str(self.rng.choice(known))
            if index or self.rng.random() < 0.8:
                kind = self.rng.choice(KINDS, p=[0.3, 0.1, 0.15, 0.1, 0.1, 0.15, 0.1])
                self.add(str(kind), parent, name)
        self.couple()
        self.close()

    def frame(self) -> np.ndarray:
        turn = pin.Quaternion(self.rng.normal(size=4)).normalized().matrix()
        return framed(self.rng.normal(size=3), turn)

    def link(self, name: str) -> Link:
        """Return a link with a mass by numbers, by shapes, or by default."""
        placement, rng = self.frame(), self.rng
        text = ""
        if rng.random() < 0.07:
            text = "<gravity>false</gravity>"
            self.told.append(f"link {name!r}: gravity false")
        elif rng.random() < 0.07:
            text = "<velocity_decay><linear>0.1</linear></velocity_decay>"
            self.told.append(f"link {name!r}: velocity_decay: linear 0.1")
        kind = rng.choice(["numbers", "solid", "default"], p=[0.7, 0.2, 0.1])
        if kind == "default":
            return Link(placement, text)
        if kind == "solid":
            return self.solid(placement, text)
        frame, root = self.frame(), rng.normal(size=(3, 3))
        inertia = np.diag([1.0, 1.2, 1.3]) + 0.02 * (root + root.T)
        moments = {
            f"{'xyz'[i]}{'xyz'[j]}": float(inertia[i, j]) for i in range(3) for j in range(i, 3)
        }
        mass = float(rng.uniform(0.5, 3.0))
        angles = pin.rpy.matrixToRpy(frame[:3, :3])
        text += INERTIAL.format(mass=mass, pose=listed([*frame[:3, 3], *angles]), **moments)
        turn = frame[:3, :3]
        return Link(placement, text, mass, frame[:3, 3], turn @ inertia @ turn.T)

    def solid(self, placement: np.ndarray, text: str) -> Link:
        shapes = []
        text += '<inertial auto="true"><density>300</density></inertial>'
        for index in range(self.rng.integers(1, 4)):
            size = self.rng.uniform(0.1, 0.4, 3).tolist()
            kind = self.rng.choice(["box", "sphere", "cylinder", "capsule", "ellipsoid"])
            own = f"<radius>{size[0]}</radius><length>{2.0 * size[1]}</length>"
            theirs = listed(size[: 1 if kind == "sphere" else 2])
            if kind in ("box", "ellipsoid"):
                tag, scale = ("size", 2.0) if kind == "box" else ("radii", 1.0)
                own = f"<{tag}>{listed(scale * np.array(size))}</{tag}>"
                theirs = listed(size)
            elif kind == "sphere":
                own = f"<radius>{size[0]}</radius>"
            density = "<density>500</density>" if self.rng.random() < 0.5 else ""
            frame = self.frame()
            angles = pin.rpy.matrixToRpy(frame[:3, :3])
            text += (
                f'<collision name="c{index}"><pose>{listed([*frame[:3, 3], *angles])}</pose>'
                f"{density}<geometry><{kind}>{own}</{kind}></geometry></collision>"
            )
            weight = 500 if density else 300
            shapes.append((f'type="{kind}" size="{theirs}" density="{weight}"', frame))
        return Link(placement, text, solid=shapes)

    def add(self, kind: str, parent: str, child: str) -> Joint:
        name = f"j{len(self.joints)}"
        if is_inner(parent) and is_inner(child):
            name = f"{ARM}::{name}"
        axis, other = self.rng.normal(size=(2, 3))
        axis /= np.linalg.norm(axis)
        axis_2 = np.cross(axis, other)
        joint = Joint(
            name, kind, parent, child, self.frame(), axis, axis_2 / np.linalg.norm(axis_2)
        )
        if kind in ("revolute", "prismatic") and self.rng.random() < 0.4:
            words = ("damping", "friction", "spring_stiffness", "spring_reference")
            joint.dynamics = {word: float(self.rng.uniform(0.1, 1.0)) for word in words}
        self.joints[name] = joint
        if kind == "screw":
            joint.pitch = float(self.rng.uniform(0.1, 0.5))
            self.couplings.append((f"{name}_slide", name, joint.pitch / (2.0 * np.pi)))
        return joint

    def couple(self) -> None:
        """Add a gearbox or a mimicked axis."""
        hinges = [item for item in self.joints.values() if item.kind == "revolute"]
        pairs = [
            (first, second)
            for first in hinges
            for second in hinges
            if first is not second and first.parent == second.parent != "world"
        ]
        ratio = float(self.rng.uniform(0.5, 2.0))
        if pairs and self.rng.random() < 0.7:
            first, second = pairs[self.rng.integers(len(pairs))]
            self.couplings.append((second.name, first.name, -ratio))
            self.gear = (first, second, ratio)
        elif len(hinges) > 1 and self.rng.random() < 0.3:
            pair = self.rng.choice(len(hinges), 2, replace=False)
            # What is in a model in the model names nothing outside of it.
            leader, follower = sorted((hinges[k].name for k in pair[::-1]), key=is_inner)[::-1]
            self.couplings.append((follower, leader, ratio))
            self.mimic = (leader, follower, ratio)

    gear: tuple[Joint, Joint, float] | None = None
    mimic: tuple[str, str, float] | None = None

    def close(self) -> None:
        """Add joints that close loops, as far as a freedom is left."""
        ways = {"fixed": 0, "ball": 3, "universal": 2}
        left = sum(ways.get(item.kind, 1) for item in self.joints.values())
        left -= sum(item[1] != item[0].removesuffix("_slide") for item in self.couplings)
        for _ in range(2):
            kind = str(self.rng.choice([*ROWS]))
            first, second = self.rng.choice(["world", *self.links], 2, replace=False).tolist()
            if second == "world":
                first, second = second, first
            if ROWS[kind] < left and second not in self.body(first):
                left -= ROWS[kind]
                joint = self.add(kind, first, second)
                joint.dynamics = {}
                joint.is_cut = bool(self.couplings) or kind == "fixed" or self.rng.random() < 0.6

    def body(self, link: str) -> set[str]:
        """Return the links that fixed joints make one body with one."""
        found, size = {link}, 0
        while len(found) > size:
            size = len(found)
            for item in self.joints.values():
                if item.kind == "fixed" and found & {item.parent, item.child}:
                    found |= {item.parent, item.child}
        return found


def is_inner(name: str) -> bool:
    return name.startswith(f"{ARM}::")


def listed(values: np.ndarray | list[float]) -> str:
    return " ".join(map(repr, np.asarray(values, dtype=float).tolist()))


class Text:
    """Writes a drawn model, every pose and axis in a frame drawn by lot."""

    def __init__(self, drawn: Drawn) -> None:
        self.drawn, self.rng = drawn, drawn.rng
        # Frames of the model and of the one in it: what may be named there, to placements.
        self.known = {"": {}, ARM: {}}
        for scope in self.known:
            self.known[scope]["__model__"] = drawn.frame()

    def whole(self) -> str:
        drawn, rng = self.drawn, self.rng
        has_arm = any(map(is_inner, drawn.links))
        inner = self.contents(ARM) if has_arm else []
        outer = self.known[""]
        if has_arm:
            frames = self.known[ARM]
            place = self.pose(frames["__model__"], "", "__model__")
            inner = [place, *inner]
            outer[ARM] = frames["__model__"]
            outer |= {f"{ARM}::{name}": at for name, at in frames.items() if name[0] != "_"}
            inner = [f'<model name="{ARM}">{"".join(inner)}</model>']
        parts = [*inner, *self.contents("")]
        attributes, frame = "", outer["__model__"]
        if drawn.has_names and not has_arm and rng.random() < 0.3:
            # The model's pose is that of one of its frames.
            name = str(rng.choice([*drawn.links]))
            attributes, frame = f' placement_frame="{name}"', drawn.links[name].placement
        placed = self.numbers(frame, "")
        if rng.random() < 0.2:
            parts.append('<plugin name="p" filename="p"><a>1</a></plugin>')
        return (
            f'<sdf version="{drawn.version}"><model name="m"{attributes}>{placed}'
            f"{''.join(parts)}</model></sdf>"
        )

    def contents(self, scope: str) -> list[str]:
        """Return links, joints and frames of a model in any order."""
        drawn, known = self.drawn, self.known[scope]
        parts = []
        for name, link in drawn.links.items():
            if is_inner(name) == bool(scope):
                own = self.called(name, scope)
                at = self.pose(link.placement, scope, "__model__")
                parts.append(f'<link name="{own}">{at}{link.text}</link>')
                known[own] = link.placement
        if drawn.has_names and self.rng.random() < 0.5:
            frame, carrier = drawn.frame(), str(self.rng.choice([*known]))
            at = self.pose(frame, scope, carrier)
            parts.append(f'<frame name="f" attached_to="{carrier}">{at}</frame>')
            known["f"] = frame
        parts += [
            self.joint(item, scope)
            for item in drawn.joints.values()
            if is_inner(item.name) == bool(scope)
        ]
        if drawn.gear and not scope:
            parts.append(self.gearbox(*drawn.gear))
        self.rng.shuffle(parts)
        return parts

    def called(self, name: str, scope: str) -> str:
        return name.removeprefix(f"{ARM}::") if scope else name

    def pose(self, frame: np.ndarray, scope: str, default: str) -> str:
        """Return a pose in a frame drawn by lot; old versions know the default one alone."""
        known, base = self.known[scope], default
        if self.drawn.has_names and self.rng.random() < 0.7:
            base = str(self.rng.choice([*known]))
        at = known.get(base, np.eye(4))
        return self.numbers(np.linalg.solve(at, frame), "" if base == default else base)

    def numbers(self, local: np.ndarray, base: str) -> str:
        kind = "rpy"
        if self.drawn.version in ("1.9", "1.12"):
            kind = self.rng.choice(["rpy", "degrees", "quaternion"])
        angles = pin.rpy.matrixToRpy(local[:3, :3])
        stated, turn = "", angles
        if kind == "degrees":
            stated, turn = ' degrees="true"', np.degrees(angles)
        elif kind == "quaternion":
            stated = ' rotation_format="quat_xyzw"'
            turn = 2.0 * pin.Quaternion(local[:3, :3]).coeffs()
        if base:
            stated += f' relative_to="{base}"'
        return f"<pose{stated}>{listed([*local[:3, 3], *turn])}</pose>"

    def axis(self, tag: str, joint: Joint, axis: np.ndarray, scope: str, more: str = "") -> str:
        """Return an axis, which is given in the joint's frame."""
        known, turn = self.known[scope], joint.placement[:3, :3]
        named = flag = ""
        if self.drawn.version == "1.4":
            axis = known["__model__"][:3, :3].T @ turn @ axis
        elif self.drawn.version == "1.6" and self.rng.random() < 0.5:
            axis = known["__model__"][:3, :3].T @ turn @ axis
            flag = "<use_parent_model_frame>1</use_parent_model_frame>"
        elif self.drawn.has_names and self.rng.random() < 0.5:
            base = str(self.rng.choice([*known]))
            axis = known[base][:3, :3].T @ turn @ axis
            named = f' expressed_in="{base}"'
        return f"<{tag}><xyz{named}>{listed(3.0 * axis)}</xyz>{flag}{more}</{tag}>"

    def joint(self, item: Joint, scope: str) -> str:
        drawn = self.drawn
        parent, child = (self.called(link, scope) for link in (item.parent, item.child))
        at = self.pose(item.placement, scope, child)
        if not drawn.has_names:
            at = self.numbers(
                np.linalg.solve(drawn.links[item.child].placement, item.placement), ""
            )
        axes, more = "", ""
        if item.kind not in ("fixed", "ball"):
            if item.dynamics:
                words = "".join(f"<{tag}>{value!r}</{tag}>" for tag, value in item.dynamics.items())
                more += f"<dynamics>{words}</dynamics>"
            if item.kind in ("revolute", "prismatic"):
                more += "<limit><lower>-2</lower><upper>2</upper></limit>"
            if drawn.mimic and drawn.mimic[1] == item.name:
                leader, _, ratio = drawn.mimic
                of = self.called(leader, scope)
                more += f'<mimic joint="{of}"><multiplier>{ratio!r}</multiplier></mimic>'
            axes = self.axis("axis", item, item.axis, scope, more)
        if item.kind == "universal":
            axes += self.axis("axis2", item, item.axis_2, scope)
        if item.kind == "screw":
            axes += f"<screw_thread_pitch>{item.pitch!r}</screw_thread_pitch>"
        if item.is_cut:
            cut = "<must_be_loop_joint>true</must_be_loop_joint>"
            axes += f"<physics><simbody>{cut}</simbody></physics>"
        name = self.called(item.name, scope)
        return (
            f'<joint name="{name}" type="{item.kind}"><parent>{parent}</parent>'
            f"<child>{child}</child>{at}{axes}</joint>"
        )

    def gearbox(self, first: Joint, second: Joint, ratio: float) -> str:
        frame = self.drawn.links[second.child].placement  # The default of a joint's pose.
        here = Joint("gear", "", "", "", frame, first.axis, second.axis)
        axes = ""
        for tag, of in (("axis", first), ("axis2", second)):
            axis = frame[:3, :3].T @ of.placement[:3, :3] @ of.axis
            axes += self.axis(tag, here, axis, "")
        return (
            f'<joint name="gear" type="gearbox"><parent>{first.child}</parent>'
            f"<child>{second.child}</child><gearbox_ratio>{ratio!r}</gearbox_ratio>"
            f"<gearbox_reference_body>{first.parent}</gearbox_reference_body>{axes}</joint>"
        )


class InWorld:
    """A drawn model as MuJoCo's, whose joints are those of a tree that the reader chose."""

    def __init__(self, drawn: Drawn, mechanism: cd.Mechanism) -> None:
        self.drawn = drawn
        self.loops = [loop.joint for loop in mechanism.loops]
        self.floating = [name for name in drawn.links if f"{name}_floating" in mechanism.joints]
        self.carried: dict[str, str] = {}
        text = ""
        self.left = [item for item in drawn.joints.values() if item.name not in self.loops]
        for name in self.floating:
            free = f'<freejoint name="{name}_floating"/>'
            text += self.body(name, free, np.eye(4), drawn.links[name].placement)
        text += self.children("world", np.eye(4))
        assert not self.left
        self.text = (
            '<mujoco><compiler angle="radian" autolimits="false"/>'
            '<option gravity="0.3 -0.2 -9.81"/>'
            f"<worldbody>{text}</worldbody></mujoco>"
        )

    def children(self, parent: str, at: np.ndarray) -> str:
        text = ""
        for item in list(self.left):
            reverses = item.kind == "fixed" and item.child == parent
            if item not in self.left or not (item.parent == parent or reverses):
                continue
            self.left.remove(item)
            child = item.parent if reverses else item.child
            self.carried[item.name] = child
            text += self.body(child, self.joint(item), at, np.eye(4))
        return text

    def body(self, link: str, joints: str, parent: np.ndarray, at: np.ndarray) -> str:
        """Return a body whose frame is at a placement in the world, where its parent's is too."""
        item = self.drawn.links[link]
        inside = np.linalg.solve(at, item.placement)
        text = joints
        for stated, frame in item.solid:
            text += f"<geom {stated} {placed(inside @ frame)}/>"
        if not item.solid:
            turn = inside[:3, :3]
            tensor = turn @ item.inertia @ turn.T
            full = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            centre = inside[:3, :3] @ item.centre + inside[:3, 3]
            text += (
                f'<inertial pos="{listed(centre)}" mass="{item.mass!r}" '
                f'fullinertia="{listed(full)}"/>'
            )
        text += self.children(link, at)
        return f'<body name="{link}" {placed(np.linalg.solve(parent, at))}>{text}</body>'

    def joint(self, item: Joint) -> str:
        turn, place = item.placement[:3, :3], item.placement[:3, 3]
        if item.child not in self.drawn.links or item.kind == "fixed":
            return ""

        def one(name: str, kind: str, axis: np.ndarray, more: str = "") -> str:
            return (
                f'<joint name="{name}" type="{kind}" pos="{listed(place)}" '
                f'axis="{listed(turn @ axis)}" {more}/>'
            )

        if item.kind == "ball":
            return one(item.name, "ball", item.axis)
        if item.kind == "universal":
            return one(f"{item.name}.turn_1", "hinge", item.axis) + one(
                f"{item.name}.turn_2", "hinge", item.axis_2
            )
        if item.kind == "screw":
            return one(item.name, "hinge", item.axis) + one(
                f"{item.name}_slide", "slide", item.axis
            )
        words = {
            "damping": "damping",
            "friction": "frictionloss",
            "spring_stiffness": "stiffness",
            "spring_reference": "springref",
        }
        more = " ".join(f'{words[tag]}="{value!r}"' for tag, value in item.dynamics.items())
        return one(item.name, "slide" if item.kind == "prismatic" else "hinge", item.axis, more)


def placed(frame: np.ndarray) -> str:
    quaternion = np.roll(pin.Quaternion(frame[:3, :3]).coeffs(), 1)
    return f'pos="{listed(frame[:3, 3])}" quat="{listed(quaternion)}"'


def along(dynamics: dict[str, float]) -> Callable[[float], float]:
    """Return what a joint at its zero exerts along itself, by its speed."""
    damping, friction, stiffness, rest = dynamics.values()
    return lambda v: passive_force(-rest, v, stiffness, damping, friction)


def compare(seed: int) -> int:
    """Compare a model; return how many components of wrenches were compared."""
    drawn = Drawn(seed)
    text = Text(drawn).whole()
    mechanism = cd.load(text, strict=False)
    for told in drawn.told:
        assert any(told in warning for warning in mechanism.warnings), told
    if drawn.told:
        with pytest.raises(cd.ModelError, match="forces that wrenches leave out"):
            cd.load(text)
    # The frames of all links, those of models in the model as well.
    for name, at in placements(mechanism.description).items():
        if name in drawn.links:
            np.testing.assert_allclose(at, drawn.links[name].placement, atol=1e-12)
    ours = InWorld(drawn, mechanism)
    model = mujoco.MjModel.from_xml_string(ours.text)
    if not model.nv:
        return 0
    turns: Mapping[str, np.ndarray] = {
        item.name: item.placement[:3, :3] for item in drawn.joints.values() if item.kind == "ball"
    }
    if not mechanism.loops and not drawn.couplings:
        same_tree(mechanism, model, drawn.rng, turns)
    rates = {model.joint(k).name: int(model.jnt_dofadr[k]) for k in range(model.njnt)}
    closures = []
    for name in ours.loops:
        item = drawn.joints[name]
        ends = (model.body(link).id for link in (item.parent, item.child))
        ways = screws(OURS.get(item.kind, item.kind), item.axis, item.axis_2)
        force = along(item.dynamics) if item.dynamics else None
        closures.append(Closure(name, *ends, item.placement, ways, force))
    couplings = [(rates[a], rates[b], ratio) for a, b, ratio in drawn.couplings]
    bodies = {
        name: model.body(link).id for name, link in ours.carried.items() if name in mechanism.joints
    }
    bodies |= {f"{link}_floating": model.body(link).id for link in ours.floating}
    return same_dynamics(
        mechanism,
        Loops(model, model.qpos0, closures, couplings),
        drawn.rng,
        {},
        lambda v: passive_forces(model, v, model.qpos0),
        bodies,
        turns,
    )


@pytest.fixture(autouse=True)
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where inertias are very different, MuJoCo's dynamics write a log beside the caller."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("seed", range(8))
def test_against_mujoco(seed: int) -> None:
    compare(seed)


@pytest.mark.campaign
@pytest.mark.slow
def test_three_hundred_models() -> None:
    held = [compare(seed) for seed in range(100, 400)]
    assert np.count_nonzero(held) > 180
