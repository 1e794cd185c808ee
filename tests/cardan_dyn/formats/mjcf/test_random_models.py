"""Random models of MJCF, with all that public ones have, against MuJoCo's own dynamics.

Mass matrix and bias forces of the tree come from Pinocchio's model of the mechanism. Speeds,
accelerations, efforts of drives and wrenches of closed chains come from a sweep, and there from
MuJoCo's mass matrix, bias forces and Jacobians as one linear system (`testkit.mujoco_loops`).
"""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from testkit.mujoco_loops import (
    SINGLE,
    Closure,
    Loops,
    framed,
    passive_forces,
    same_dynamics,
    same_tree,
    screws,
)

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.description.second_reading import reread

HEAD = """<mujoco><compiler angle="{angle}" eulerseq="{sequence}" inertiafromgeom="{inertia}"
 autolimits="{auto}"/><option gravity="0.3 -0.2 -9.81" {option}/>
<default><geom density="700"/><joint damping="0.1"/><equality solref="0.01 1"/>
<default class="k"><joint axis="0 3 4" pos="0.1 0 0.2" armature="0.03" stiffness="2"/>
<geom type="box" size="0.3 0.2 0.1"/><default class="l"><joint frictionloss="0.4"/>
<geom type="capsule" size="0.1 0.3"/></default></default></default>
<asset><mesh name="m" vertex="0 0 0 .5 0 0 0 .75 0 0 0 .25" scale="1 -1 1"/>
<mesh name="n" vertex="0 0 0 .5 0 0 0 .75 0 .1 0 .25" inertia="shell" refpos=".1 0 .2"/></asset>
<contact><exclude body1="b1" body2="world"/></contact>
<worldbody>{world}</worldbody>{more}</mujoco>"""
SHAPES = (
    'class="{c}"',
    'type="mesh" mesh="m"',
    'type="mesh" mesh="n" density="30"',
    'type="ellipsoid" size="0.1 0.2 0.3"',
    'type="cylinder" size="0.1" fromto="0 0 0 0.3 0.2 0.1"',
    'type="sphere" size="0.2" mass="1.5"',
)
OPTIONS = ("", 'density="1.2" wind="1 2 3"', 'viscosity="0.1"', 'density="2" viscosity="0.1"')
BALL, WELD, OF_JOINTS = (
    int(kind)
    for kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD, mujoco.mjtEq.mjEQ_JOINT)
)


class Drawn:
    """A model, drawn by its seed.

    Attributes:
        told: what of it acts and is no part of wrenches, as messages call it.
        included: what stands in a file beside the model; empty where nothing does.
    """

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.count = self.bodies = 0
        self.with_sites: list[str] = []
        self.told: list[str] = []
        option = self.rng.choice(OPTIONS)
        self.told += [word for word in ("density", "viscosity") if f'{word}="' in option]
        self.head = {
            "angle": self.rng.choice(["degree", "radian"]),
            "sequence": self.rng.choice(["xyz", "ZYX", "xYz"]),
            "inertia": self.rng.choice(["auto", "true"]),
            "auto": self.rng.choice(["true", "false"]),
            "option": option,
        }
        trees = [self.body(3, is_first=True) for _ in range(self.rng.integers(1, 3))]
        if self.rng.random() < 0.2:
            trees.append(f'<body name="stand" mocap="true" pos="{self.words(3)}"/>')
        self.included = ""
        if self.rng.random() < 0.2:
            self.included = f"<mujocoinclude>{trees[0]}</mujocoinclude>"
            trees[0] = '<include file="part.xml"/>'
        self.world = "".join(trees)
        self.more = self.forces()

    def text(self, sites: dict[str, str], equalities: str = "") -> tuple[str, str]:
        """Return the model and what it includes, with further sites of bodies."""
        more = self.more + (f"<equality>{equalities}</equality>" if equalities else "")
        whole = HEAD.format(**self.head, world=self.world, more=more), self.included
        for body in self.with_sites:
            place = f"<!-- {body} -->"
            whole = tuple(part.replace(place, sites.get(body, "")) for part in whole)
        return whole

    def words(self, count: int, size: float = 1.0) -> str:
        return " ".join(repr(value) for value in (size * self.rng.normal(size=count)).tolist())

    def turned(self) -> str:
        kind = self.rng.choice(["quat", "axisangle", "xyaxes", "zaxis", "euler"])
        count = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}[kind]
        return f'{kind}="{self.words(count)}"'

    def joints(self) -> str:
        text = ""
        for _ in range(self.rng.integers(1, 3)):
            self.count += 1
            kind = self.rng.choice(["hinge", "slide", "ball"], p=[0.6, 0.3, 0.1])
            name = f"j{self.count}"
            stated = ""
            if self.rng.random() < 0.6:
                stated = f'class="{self.rng.choice(["main", "k", "l"])}"'
            if self.rng.random() < 0.5:
                stated += f' axis="{self.words(3)}" pos="{self.words(3)}"'
            if kind != "ball":
                stated += f' ref="{self.words(1, 0.2)}" springref="{self.words(1, 0.3)}"'
            if self.rng.random() < 0.2 and kind != "ball":
                stated += ' limited="true" range="-3 3"'
            text += f'<joint name="{name}" type="{kind}" {stated}/>'
            if kind == "ball":
                return text
        return text

    def body(self, depth: int, is_first: bool = False, is_copied: bool = False) -> str:
        self.bodies += 1
        name = f"b{self.bodies}"
        inside, stated = "", ""
        if is_first and self.rng.random() < 0.25:
            self.count += 1
            align = self.rng.choice(["true", "false", "auto"])
            inside = f'<freejoint name="j{self.count}" align="{align}"/>'
        elif self.rng.random() < 0.85:
            inside = self.joints()
        if self.rng.random() < 0.2:
            stated += f' childclass="{self.rng.choice(["k", "l"])}"'
        if self.rng.random() < 0.05 and inside and not is_copied:
            stated += ' gravcomp="0.5"'
            self.told.append(f"body {name!r}: gravcomp 0.5")
        geom = self.rng.choice(SHAPES).format(c=self.rng.choice(["k", "l"]))
        geom = f"<geom {geom}/>"
        if self.rng.random() < 0.4:
            geom = f'<frame pos="{self.words(3)}" {self.turned()}>{geom}<geom size="0.1"/></frame>'
        if self.rng.random() < 0.4:
            full = "1 1.2 1.3 " + self.words(3, 0.05)
            geom += f'<inertial pos="{self.words(3)}" mass="2" fullinertia="{full}"/>'
        inside += geom
        if not is_copied:
            inside += f"<!-- {name} -->"
            self.with_sites.append(name)
        if depth and not is_copied:
            for _ in range(self.rng.integers(0, 3)):
                if self.rng.random() < 0.1:
                    count = f'count="2" offset="{self.words(3)}" euler="{self.words(3)}" sep="_"'
                    inside += f"<replicate {count}>{self.body(0, is_copied=True)}</replicate>"
                else:
                    inside += self.body(depth - 1)
        text = f'<body name="{name}" pos="{self.words(3)}" {self.turned()}{stated}>{inside}</body>'
        if self.rng.random() < 0.3:
            text = f'<frame pos="{self.words(3)}" {self.turned()}>{text}</frame>'
        return text

    def forces(self) -> str:
        """Return tendons, actuators and what else stands beside the bodies."""
        whole = f"{self.world}{self.included}"
        single = [
            f"j{k}"
            for k in range(1, self.count + 1)
            if any(f'"j{k}" type="{kind}"' in whole for kind in ("hinge", "slide"))
            and "_" not in whole.split(f'"j{k}"')[0].rpartition("<replicate")[2].partition(">")[0]
        ]
        if not single:
            return ""
        joint = self.rng.choice(single)
        text = ""
        if self.rng.random() < 0.3:
            stiffness = self.rng.choice(["0", "3"])
            text += (
                f'<tendon><fixed name="t" stiffness="{stiffness}">'
                f'<joint joint="{joint}" coef="2"/></fixed></tendon>'
                '<sensor><tendonpos tendon="t"/></sensor>'
            )
            self.told += ["tendon 't': stiffness 3"] * (stiffness == "3")
        kind = self.rng.choice(["motor", "position", "velocity", "general", "none"])
        if kind != "none":
            text += f'<actuator><{kind} name="m" joint="{joint}"/></actuator>'
        return text


class Placed:
    """A model, put where its equalities are to hold, which are drawn."""

    def __init__(self, drawn: Drawn, model: mujoco.MjModel, as_stated: mujoco.MjModel) -> None:
        """Draw equalities.

        Args:
            drawn: the model.
            model: the same one as MuJoCo has it.
            as_stated: that without bodies which `align` turns to their principal axes.
        """
        self.drawn, self.rng, self.model = drawn, drawn.rng, model
        self.data = mujoco.MjData(as_stated)
        self.near: dict[str, float] = {}
        self.q = model.qpos0.copy()
        self.single = [k for k in range(model.njnt) if model.jnt_type[k] in SINGLE]
        if self.rng.random() < 0.5:
            for k in self.single:
                off = 0.1 * self.rng.normal()
                self.near[model.joint(k).name] = float(off)
                self.q[model.jnt_qposadr[k]] += off
                self.data.joint(model.joint(k).name).qpos += off
        mujoco.mj_kinematics(as_stated, self.data)
        self.sites: dict[str, str] = {}
        self.locked: set[str] = set()
        self.held: set[str] = set()
        self.text = self.equalities()

    def at(self, body: str, data: mujoco.MjData | None = None) -> np.ndarray:
        item = (data or self.data).body(body)
        return framed(item.xpos, item.xmat)

    def moves(self, body: int) -> bool:
        first = self.model.body_jntadr[body]
        joints = range(first, first + self.model.body_jntnum[body])
        return any(self.model.joint(k).name not in self.held for k in joints)

    def carrier(self, body: str) -> int:
        """Return the body with joints that carries one; 0, the world, without any."""
        index = self.model.body(body).id
        while index and not self.moves(index):
            index = self.model.body_parentid[index]
        return int(index)

    def site(self, body: str, name: str, place: np.ndarray) -> None:
        quaternion = pin.Quaternion(place[:3, :3]).coeffs()
        stated = f'pos="{listed(place[:3, 3])}" quat="{listed(np.roll(quaternion, 1))}"'
        if self.drawn.head["sequence"] == "ZYX":  # Anything that half of all models have.
            stated += ' class="k"'
        self.sites[body] = self.sites.get(body, "") + f'<site name="{name}" {stated}/>'

    def equalities(self) -> str:
        text, left = "", self.model.nv
        bodies = [self.model.body(k).name for k in range(1, self.model.nbody)]
        kinds = self.rng.choice(
            ["connect", "weld", "weld_off", "sites", "weld_sites", "joint", "held", "idle"], 4
        )
        for count, kind in enumerate(sorted(kinds, key=lambda kind: kind != "held")):
            rows = {"connect": 3, "sites": 3, "joint": 1, "held": 1}.get(kind, 6)
            if rows >= left or (len(bodies) < 2 and rows > 1):
                continue
            text += self.equality(kind, count, bodies)
            left -= rows
        return text

    def equality(self, kind: str, count: int, bodies: list[str]) -> str:
        """Return an equality that holds at the configuration."""
        if kind in ("joint", "held"):
            return self.of_joints(kind, count)
        known = bodies
        if kind in ("sites", "weld_sites"):
            known = self.drawn.with_sites
            if len(known) < 2:
                return ""
        first, second = self.rng.choice(known, 2, replace=False)
        ends = f'name="e{count}" body1="{first}"'
        if self.rng.random() < 0.8:
            ends += f' body2="{second}"'
        else:
            second = "world"
        if self.carrier(first) == self.carrier(second):
            return ""  # What fixed joints make one body is refused.
        anchor = self.rng.normal(size=3)
        if self.near and kind in ("connect", "weld"):  # They hold in the initial configuration.
            kind = "sites" if kind == "connect" else "weld_off"
            if kind == "sites":
                ends = ""
                if not {first, second} <= {*self.drawn.with_sites}:
                    return ""
        if kind in ("sites", "weld_sites"):
            if second == "world":
                return ""
            place = framed(anchor, np.eye(3) if kind == "sites" else turn(self.rng))
            other = np.linalg.solve(self.at(second), self.at(first) @ place)
            if kind == "sites":
                other[:3, :3] = turn(self.rng)
            self.site(first, f"s{count}", place)
            self.site(second, f"r{count}", other)
            word = "connect" if kind == "sites" else "weld"
            return f'<{word} name="e{count}" site1="s{count}" site2="r{count}"/>'
        if kind == "connect":
            return f'<connect {ends} anchor="{listed(anchor)}"/>'
        if kind == "weld":
            return f'<weld {ends} anchor="{listed(anchor)}"/>'
        if kind == "idle":
            return f'<weld {ends} active="false"/>'
        place = framed(anchor, np.eye(3))
        # Of turned bodies, MuJoCo turns sites, but not the pose of a weld.
        data = mujoco.MjData(self.model)
        data.qpos[:] = self.q
        mujoco.mj_kinematics(self.model, data)
        across = np.linalg.solve(self.at(first, data), self.at(second, data) @ place)
        quaternion = np.roll(pin.Quaternion(across[:3, :3]).coeffs(), 1)
        pose = f"{listed(across[:3, 3])} {listed(3.0 * quaternion)}"
        return f'<weld {ends} anchor="{listed(anchor)}" relpose="{pose}"/>'

    def of_joints(self, kind: str, count: int) -> str:
        names = [self.model.joint(k).name for k in self.single]
        names = [name for name in names if name not in self.locked]
        if len(names) < 2:
            return ""
        first, second = self.rng.choice(names, 2, replace=False)
        at = [self.near.get(name, 0.0) for name in (first, second)]
        # A joint is held or follows once.
        self.locked |= {first, second}
        if kind == "held":
            self.near.pop(first, None)
            self.held.add(first)
            return f'<joint name="e{count}" joint1="{first}" polycoef="{at[0]!r} 0 0 0 0"/>'
        ratio = float(self.rng.normal())
        offset = at[0] - ratio * at[1]
        return (
            f'<joint name="e{count}" joint1="{first}" joint2="{second}" '
            f'polycoef="{offset!r} {ratio!r} 0 0 0"/>'
        )


def listed(values: np.ndarray) -> str:
    return " ".join(map(repr, np.asarray(values).tolist()))


def turn(rng: np.random.Generator) -> np.ndarray:
    return pin.Quaternion(rng.normal(size=4)).normalized().matrix()


def written(folder: Path, parts: tuple[str, str]) -> str:
    """Write a model that includes a file; return the path, or the text of one that does not."""
    text, included = parts
    if not included:
        return text
    (folder / "part.xml").write_text(included, encoding="utf-8")
    (folder / "model.xml").write_text(text, encoding="utf-8")
    return str(folder / "model.xml")


def theirs(source: str) -> mujoco.MjModel:
    is_text = source.startswith("<")
    from_ = mujoco.MjModel.from_xml_string if is_text else mujoco.MjModel.from_xml_path
    return from_(source)


def same_numbers(first: Description, second: Description) -> None:
    """Hold all numbers of two descriptions against each other."""
    for kind in ("links", "joints", "loops", "couplings"):
        for one, other in zip(getattr(first, kind), getattr(second, kind), strict=True):
            for field in fields(one):
                mine, their = (getattr(item, field.name) for item in (one, other))
                if isinstance(mine, float | tuple | np.ndarray):
                    size = np.max(np.abs(mine), initial=1.0)
                    np.testing.assert_allclose(mine, their, rtol=0.0, atol=1e-12 * size)


def closures(model: mujoco.MjModel, data: mujoco.MjData) -> list[Closure]:
    """Return the loops that active equalities are, where MuJoCo has them."""
    result = []
    for k in range(model.neq):
        kind, numbers = model.eq_type[k], model.eq_data[k]
        if not model.eq_active0[k] or kind not in (BALL, WELD):
            continue
        ends = model.eq_obj1id[k], model.eq_obj2id[k]
        if model.eq_objtype[k] == int(mujoco.mjtObj.mjOBJ_SITE):
            place = framed(data.site_xpos[ends[0]], data.site_xmat[ends[0]])
            ends = tuple(model.site_bodyid[list(ends)])
        else:
            point = numbers[3:6] if kind == WELD else numbers[:3]
            body = framed(data.xpos[ends[0]], data.xmat[ends[0]])
            place = body @ framed(point, np.eye(3))
        joint = "spherical" if kind == BALL else "fixed"
        result.append(Closure(model.equality(k).name, *ends, place, screws(joint, np.eye(3)[0])))
    return result


def rows_of_mujoco(model: mujoco.MjModel, q: np.ndarray) -> tuple[np.ndarray, float]:
    """Return MuJoCo's own rows of equalities, and how far these are open."""
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(model)
    data.qpos[:] = q
    for step in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_makeConstraint):
        step(model, data)
    rows = data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    # Rows that vanish are left out of those for which there was room.
    found = data.efc_J.ravel()[: data.nefc * model.nv].reshape(data.nefc, model.nv)
    rows = rows[: data.nefc]
    return found[rows], float(np.max(np.abs(data.efc_pos[: data.nefc][rows]), initial=0.0))


def same_rows(first: np.ndarray, second: np.ndarray) -> None:
    """Hold the spans of rows against each other."""
    for rows_in, rows_of in ((first, second), (second, first)):
        _, sizes, basis = np.linalg.svd(rows_of)
        basis = basis[: np.count_nonzero(sizes > 1e-9 * np.max(sizes, initial=1e-300))]
        left = rows_in - rows_in @ basis.T @ basis
        np.testing.assert_allclose(
            left, 0.0, atol=1e-9 * max(1.0, np.max(np.abs(rows_in), initial=0.0))
        )


def compare(seed: int, folder: Path) -> int:
    """Compare a model; return how many components of wrenches were compared."""
    drawn = Drawn(seed)
    if not drawn.count:
        return 0
    parts = drawn.text({})
    unturned = tuple(re.sub(' align="[a-z]*"', ' align="false"', part) for part in parts)
    as_stated = theirs(written(folder, unturned))
    bare = written(folder, parts)
    same_tree(cd.load(bare, strict=False), theirs(bare), drawn.rng)
    placed = Placed(drawn, theirs(bare), as_stated)
    source = written(folder, drawn.text(placed.sites, placed.text))
    mechanism = cd.load(source, strict=False)
    for told in drawn.told:
        assert any(told in warning for warning in mechanism.warnings), told
    if drawn.told:
        with pytest.raises(cd.ModelError, match="forces that wrenches leave out"):
            cd.load(source)
    same_numbers(mechanism.description, reread(mechanism.description))
    model = theirs(source)
    rows, gap = rows_of_mujoco(model, placed.q)
    assert gap < 1e-12
    model = theirs(source)
    data = mujoco.MjData(model)
    data.qpos[:] = placed.q
    mujoco.mj_kinematics(model, data)
    couplings = [
        (
            int(model.jnt_dofadr[model.eq_obj1id[k]]),
            int(model.jnt_dofadr[model.eq_obj2id[k]]) if model.eq_obj2id[k] >= 0 else -1,
            float(model.eq_data[k][1]),
        )
        for k in range(model.neq)
        if model.eq_type[k] == OF_JOINTS
    ]
    loops = Loops(model, placed.q, closures(model, data), couplings)
    same_rows(loops.jacobian, rows)
    bodies = {
        model.joint(k).name: int(model.jnt_bodyid[k])
        for k in range(model.njnt)
        if model.joint(k).name in mechanism.joints
    }
    return same_dynamics(
        mechanism,
        loops,
        drawn.rng,
        placed.near,
        lambda v: passive_forces(model, v, placed.q),
        bodies,
    )


@pytest.fixture(autouse=True)
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where inertias are very different, MuJoCo's dynamics write a log beside the caller."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 9, 12, 13])
def test_against_mujoco(seed: int, tmp_path: Path) -> None:
    compare(seed, tmp_path)


@pytest.mark.campaign
@pytest.mark.slow
def test_three_hundred_models(tmp_path: Path) -> None:
    held = [compare(seed, tmp_path) for seed in range(100, 400)]
    assert np.count_nonzero(held) > 150
