"""Random models of MJCF against MuJoCo's own dynamics.

Mass matrix and bias forces of the tree come from Pinocchio's model of the mechanism, rows of
equalities from the description's frames by Pinocchio's Jacobians.
"""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.description.second_reading import reread

HEAD = """<mujoco><compiler angle="{angle}" eulerseq="{sequence}" inertiafromgeom="{inertia}"/>
<default><geom density="700"/><joint damping="0.1"/><default class="k"><joint axis="0 3 4"
 pos="0.1 0 0.2" armature="0.03"/><geom type="box" size="0.3 0.2 0.1"/><default class="l">
<geom type="capsule" size="0.1 0.3"/></default></default></default>
<asset><mesh name="m" vertex="0 0 0 .5 0 0 0 .75 0 0 0 .25" scale="1 -1 1"/></asset><worldbody>"""
SHAPES = (
    'class="{c}"',
    'type="mesh" mesh="m"',
    'type="ellipsoid" size="0.1 0.2 0.3"',
    'type="cylinder" size="0.1" fromto="0 0 0 0.3 0.2 0.1"',
    'type="sphere" size="0.2" mass="1.5"',
)


class Drawn:
    """A model, drawn by its seed."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.count = self.bodies = 0
        self.moving: list[str] = []
        self.singles: list[str] = []
        angle = self.rng.choice(["degree", "radian"])
        head = HEAD.format(
            angle=angle,
            sequence=self.rng.choice(["xyz", "ZYX", "xYz"]),
            inertia=self.rng.choice(["auto", "true"]),
        )
        trees = "".join(self.body(3) for _ in range(self.rng.integers(1, 3)))
        self.text = f"{head}{trees}</worldbody>"

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
            stated = f'class="{self.rng.choice(["main", "k", "l"])}"'
            if self.rng.random() < 0.5:
                stated += f' axis="{self.words(3)}" pos="{self.words(3)}"'
            if kind != "ball":
                self.singles.append(name)
                stated += f' ref="{self.words(1, 0.2)}"'
            text += f'<joint name="{name}" type="{kind}" {stated}/>'
            if kind == "ball":
                return text
        return text

    def body(self, depth: int) -> str:
        self.bodies += 1
        name = f"b{self.bodies}"
        inside = ""
        if self.rng.random() < 0.85:
            inside += self.joints()
            self.moving.append(name)
        geom = self.rng.choice(SHAPES).format(c=self.rng.choice(["k", "l"]))
        geom = f"<geom {geom}/>"
        if self.rng.random() < 0.4:
            geom = f'<frame pos="{self.words(3)}" {self.turned()}>{geom}<geom size="0.1"/></frame>'
        if self.rng.random() < 0.4:
            full = "1 1.2 1.3 " + self.words(3, 0.05)
            geom += f'<inertial pos="{self.words(3)}" mass="2" fullinertia="{full}"/>'
        inside += geom + f'<site name="s{self.bodies}" pos="{self.words(3)}" {self.turned()}/>'
        if depth:
            inside += "".join(self.body(depth - 1) for _ in range(self.rng.integers(0, 3)))
        text = f'<body name="{name}" pos="{self.words(3)}" {self.turned()}>{inside}</body>'
        if self.rng.random() < 0.3:
            text = f'<frame pos="{self.words(3)}" {self.turned()}>{text}</frame>'
        return text

    def equalities(self) -> str:
        text = ""
        for _ in range(3):
            if len(self.moving) < 2:
                return ""
            first, second = self.rng.choice(self.moving, 2, replace=False)
            a, b = f'body1="{first}"', f'body2="{second}"'
            text += self.rng.choice(
                [
                    f'<connect {a} {b} anchor="{self.words(3)}"/>',
                    f'<weld {a} {b} anchor="{self.words(3)}"/>',
                    f'<weld {a} anchor="{self.words(3)}"/>',
                ]
            )
        if len(self.singles) > 1:
            first, second = self.rng.choice(self.singles, 2, replace=False)
            ratio = self.words(1)
            text += f'<joint joint1="{first}" joint2="{second}" polycoef="0 {ratio} 0 0 0"/>'
        return f"<equality>{text}</equality>" if text else ""


def columns(mechanism: cd.Mechanism, model: mujoco.MjModel) -> list[int]:
    """Return the velocity coordinate of Pinocchio's model for each one of MuJoCo's."""
    result = []
    for index in range(model.njnt):
        own = mechanism.joints[model.joint(index).name].id
        result += range(
            mechanism.model.idx_vs[own], mechanism.model.idx_vs[own] + mechanism.model.nvs[own]
        )
    return result


def same_tree(text: str, rng: np.random.Generator) -> cd.Mechanism:
    """Hold mass matrix and bias forces against MuJoCo's at a random state."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mechanism = cd.load(text, strict=False)
    ours = mechanism.model
    order = columns(mechanism, model)
    step, v = rng.normal(size=(2, model.nv))
    mujoco.mj_integratePos(model, data.qpos, step, 1.0)
    data.qvel[:] = v
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    our_step, our_v = np.zeros((2, ours.nv))
    our_step[order], our_v[order] = step, v
    ours.gravity.linear = model.opt.gravity.copy()
    q = pin.integrate(ours, pin.neutral(ours), our_step)
    place = ours.createData()
    found = pin.crba(ours, place, q)
    found = np.triu(found) + np.triu(found, 1).T
    bias = pin.nonLinearEffects(ours, ours.createData(), q, our_v)
    scale = max(np.max(np.abs(mass)), np.max(np.abs(data.qfrc_bias)))
    for mine, theirs in ((found[np.ix_(order, order)], mass), (bias[order], data.qfrc_bias)):
        np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-10 * scale)
    return mechanism


def same_numbers(first: Description, second: Description) -> None:
    """Hold all numbers of two descriptions against each other."""
    for kind in ("links", "joints", "loops", "couplings"):
        for one, other in zip(getattr(first, kind), getattr(second, kind), strict=True):
            for field in fields(one):
                mine, theirs = (getattr(item, field.name) for item in (one, other))
                if isinstance(mine, float | tuple | np.ndarray):
                    size = np.max(np.abs(mine), initial=1.0)
                    np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-12 * size)


def same_equalities(tree: cd.Mechanism, text: str) -> int:
    """Hold the rows of all equalities, as one linear system, against MuJoCo's; return the rank."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(model)
    for step in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_makeConstraint):
        step(model, data)
    ours, order = tree.model, columns(tree, model)
    rows = data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    # Rows that vanish are left out of those for which there was room.
    theirs = data.efc_J.ravel()[: data.nefc * model.nv].reshape(data.nefc, model.nv)
    theirs = theirs[rows[: data.nefc]]
    place = ours.createData()
    pin.computeJointJacobians(ours, place, pin.neutral(ours))
    pin.updateGlobalPlacements(ours, place)
    description = cd.load(text, strict=False).description
    same_numbers(description, reread(description))
    found = []
    for loop in description.loops:
        ends = []
        for link, origin in (
            (loop.predecessor, loop.predecessor_origin),
            (loop.successor, loop.successor_origin),
        ):
            body, frame = tree.links[link]
            at = place.oMi[body] * frame * pin.SE3(origin)
            spatial = pin.getJointJacobian(ours, place, body, pin.ReferenceFrame.WORLD)
            turning = np.eye(6)
            turning[:3, 3:] = -pin.skew(at.translation)
            ends.append((at, turning @ spatial))
        (first, one), (second, other) = ends
        np.testing.assert_allclose(first.homogeneous, second.homogeneous, atol=1e-12)
        found.append((one - other)[: 3 if loop.type == "spherical" else 6])
    for coupling in description.couplings:
        row = np.zeros((1, ours.nv))
        row[0, ours.idx_vs[tree.joints[coupling.successor].id]] = 1.0
        row[0, ours.idx_vs[tree.joints[coupling.predecessor].id]] = -coupling.ratio
        found.append(row)
    mine = np.vstack(found)[:, order]
    for rows_in, rows_of in ((mine, theirs), (theirs, mine)):
        _, sizes, basis = np.linalg.svd(rows_of)
        basis = basis[: np.count_nonzero(sizes > 1e-9 * np.max(sizes, initial=1e-300))]
        left = rows_in - rows_in @ basis.T @ basis
        np.testing.assert_allclose(left, 0.0, atol=1e-10 * max(1.0, np.max(np.abs(rows_in))))
    return len(basis)


def compare(seed: int) -> int:
    drawn = Drawn(seed)
    text = drawn.text + "</mujoco>"
    if not drawn.count:
        return 0
    tree = same_tree(text, drawn.rng)
    equalities = drawn.equalities()
    return same_equalities(tree, f"{drawn.text}{equalities}</mujoco>") if equalities else 0


@pytest.fixture(autouse=True)
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where inertias are very different, MuJoCo's dynamics write a log beside the caller."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("seed", range(8))
def test_against_mujoco(seed: int) -> None:
    compare(seed)


@pytest.mark.campaign
@pytest.mark.slow
def test_a_hundred_models() -> None:
    ranks = [compare(seed) for seed in range(100, 200)]
    assert np.count_nonzero(ranks) > 50
