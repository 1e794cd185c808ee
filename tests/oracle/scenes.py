"""Random scenes: drives, held joints and loads that make a random chain a regular problem.

Whatever is badly conditioned or near a decision of rank is drawn again, so that every case
that comes out has one right answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from chains import Chain, Redraw, random_chain, turned
from free_bodies import Acting, Oracle, Position, Statics

Array = np.ndarray

MOST_CONDITION = 1e4
"""Condition of the passive closure equations up to which a case counts."""
ZERO, CERTAIN = 1e-10, 1e-5
"""Singular values and influences count as nothing below, as something above; none between."""


@dataclass(frozen=True, eq=False)
class Case:
    """A chain with all that a scene and a sweep prescribe.

    Attributes:
        drives, held: what is prescribed; positions of the held joints [rad, m].
        joint_loads, link_loads, gravity: see `Acting`.
        compliance: joints to `(6,)` or `(6, 6)`.
        positions, speeds, accelerations: of the drives `(N, d)`.
        features: what it has, for grouping failures.
    """

    chain: Chain
    drives: tuple[str, ...]
    held: dict[str, float]
    joint_loads: dict[str, float]
    link_loads: dict[str, tuple[Array, Array, str]]
    gravity: Array
    compliance: dict[str, Array]
    positions: Array
    speeds: Array
    accelerations: Array
    features: frozenset[str]

    @property
    def prescribed(self) -> tuple[str, ...]:
        """Driven and held joints."""
        return (*self.drives, *self.held)

    @property
    def acting(self) -> Acting:
        """What acts on the chain."""
        return Acting(self.gravity, self.joint_loads, self.link_loads)

    def scaled(self, slides: Array, length: float, mass: float, time: float) -> Case:
        """Return the case in other units, or the similar one of another size.

        Args:
            slides: `(D,)` whether each prescribed coordinate and then each load is along a slide.
            length, mass, time: factors.
        """
        names = (*self.drives, *self.held, *self.joint_loads)
        per = {
            name: length if is_slide else 1.0 for name, is_slide in zip(names, slides, strict=True)
        }
        per_drive = np.array([per[name] for name in self.drives])
        force = mass * length / time**2
        compliances = np.repeat([length, 1.0], 3)
        compliances = np.outer(compliances, compliances) / (force * length)
        return replace(
            self,
            chain=self.chain.scaled(length, mass),
            held={name: value * per[name] for name, value in self.held.items()},
            joint_loads={
                name: value * (force if per[name] != 1.0 else force * length)
                for name, value in self.joint_loads.items()
            },
            link_loads={
                name: (force * one, force * length * other, axes)
                for name, (one, other, axes) in self.link_loads.items()
            },
            gravity=self.gravity * length / time**2,
            compliance={
                name: value * (compliances if value.ndim > 1 else np.diag(compliances))
                for name, value in self.compliance.items()
            },
            positions=self.positions * per_drive,
            speeds=self.speeds * per_drive / time,
            accelerations=self.accelerations * per_drive / time**2,
        )

    def matrices(self) -> dict[str, Array]:
        """Return compliances as matrices."""
        return {
            name: np.diag(value) if value.ndim == 1 else value
            for name, value in self.compliance.items()
        }


def solved(case: Case, oracle: Oracle, x: Position, sample: int, length: float) -> Statics:
    """Return the statics of a sample at a closed position."""
    geometry = oracle.geometry(x)
    v, a = oracle.rates(
        geometry,
        dict(zip(case.drives, case.speeds[sample], strict=True)),
        dict(zip(case.drives, case.accelerations[sample], strict=True)),
        case.prescribed,
        length,
    )
    return oracle.statics(geometry, v, a, case.prescribed, case.acting, length, case.matrices())


def followed(case: Case, oracle: Oracle) -> list[Position]:
    """Return closed positions of all samples, each followed from zero in a straight line.

    Raises:
        Redraw: the loops cannot be closed, or the problem is not regular in between.
    """
    zero = oracle.zero()
    check_regular(case, oracle, zero)
    rest = {name: float(zero[name][0]) for name in case.prescribed}
    start = _follow(case, oracle, zero, rest, rest | case.held)
    return [
        _follow(
            case,
            oracle,
            start,
            rest | case.held,
            case.held | dict(zip(case.drives, position.tolist(), strict=True)),
        )
        for position in case.positions
    ]


def _follow(
    case: Case, oracle: Oracle, x: Position, begin: dict[str, float], end: dict[str, float]
) -> Position:
    """Follow the mechanism in steps so small that it cannot get into another assembly mode."""
    size = case.chain.size
    done, step = 0.0, 0.25
    change = {name: end[name] - begin[name] for name in end}
    if not any(change.values()):
        return x
    while done < 1.0:
        step = min(step, 1.0 - done)
        rates, _ = oracle.rates(
            oracle.geometry(x),
            {name: step * value for name, value in change.items()},
            {},
            case.prescribed,
            size,
        )
        guess = oracle.moved(x, rates)
        targets = {name: begin[name] + (done + step) * change[name] for name in change}
        per_rate = np.where(oracle.slides, 1.0 / size, 1.0)
        try:
            closed, correction = oracle.close(guess, targets, case.prescribed, size)
        except Redraw:
            closed, correction = x, np.inf
        ahead = float(np.max(np.abs(rates * per_rate)))
        if correction > 0.1 * ahead + 1e-9 or ahead > 0.3:
            step *= 0.5
            if step < 1e-2:
                raise Redraw("a dead point is near")
            continue
        x, done, step = closed, done + step, 2.0 * step
        check_regular(case, oracle, x)
    return x


def regular(case: Case, oracle: Oracle, x: Position, length: float) -> str:
    """Return why a scene is not regular at a position; nothing if it is."""
    matrix = oracle.scaled(oracle.geometry(x), length)
    passive = matrix[:, oracle.passive(case.prescribed)]
    driven = matrix[:, oracle.rate_columns(case.drives)]
    if passive.shape[1] == 0:
        return "every joint is prescribed"
    if passive.shape[0] < passive.shape[1]:
        return "passive joints are free"
    vectors, values, _ = np.linalg.svd(passive, full_matrices=False)
    if values[-1] * MOST_CONDITION < max(values[0], 1.0):
        return f"passive joints are free, {values[-1]:.1e}"
    against = driven - vectors @ (vectors.T @ driven)
    if np.max(np.abs(against), initial=0.0) > ZERO:
        return "drives depend on each other"
    rates = np.linalg.lstsq(passive, driven, rcond=None)[0]
    if np.max(np.abs(rates), initial=0.0) > 1e2:
        return "a dead point is near"
    return ""


def check_regular(case: Case, oracle: Oracle, x: Position) -> None:
    """Refuse a case that is not regular at a position."""
    reason = regular(case, oracle, x, case.chain.size)
    if reason:
        raise Redraw(reason)


def decided(case: Case, oracle: Oracle, positions: Sequence[Position]) -> None:
    """Refuse a case whose flags or choices hang on a tolerance.

    Raises:
        Redraw: the case is drawn again.
    """
    for sample, x in enumerate(positions):
        statics = solved(case, oracle, x, sample, case.chain.size)
        smallest, rest = statics.spread
        if smallest < CERTAIN or rest > 1e-12:
            raise Redraw("rank of the balance is not clear")
        if statics.residual > 1e-10:
            raise Redraw(f"the balance cannot be met, {statics.residual:.1e}")
        influence = np.concatenate(list(statics.influence.values()))
        if np.any((influence > ZERO) & (influence < CERTAIN)):
            raise Redraw("flags are not clear")
        if np.any((statics.stiffness > ZERO) & (statics.stiffness < 1e-3)):
            raise Redraw("elastic choice is not clear")


@lru_cache(maxsize=64)
def draw(seed: int, turns: bool = False) -> Case:
    """Return the case of a seed, the first one of its drawings that is regular and clear.

    Args:
        seed: any.
        turns: whether the frames of its loops are turned, see `chains.turned`.
    """
    for attempt in range(400):
        rng = np.random.default_rng([seed, attempt])
        try:
            chain = random_chain(rng)
            oracle = Oracle(chain)
            case = _scene(rng, chain, oracle)
            if turns:
                case = with_turned_loops(case, rng)
                oracle = Oracle(case.chain)
            decided(case, oracle, followed(case, oracle))
        except Redraw:
            continue
        return case
    raise RuntimeError(f"seed {seed} gives no case")


def with_turned_loops(case: Case, rng: np.random.Generator) -> Case:
    """Return a case in which coordinates of loops count from elsewhere."""
    chain = case.chain
    joints = {
        name: turned(joint, rng, chain.size) if joint.closes else joint
        for name, joint in chain.joints.items()
    }
    zero = {
        name: 0.0 if joints[name].zero is None else float(joints[name].zero[0])
        for name in case.prescribed
    }
    return replace(
        case,
        chain=replace(chain, joints=joints),
        held={name: value + zero[name] for name, value in case.held.items()},
        positions=case.positions + [zero[name] for name in case.drives],
        features=case.features | {"turned loops"},
    )


def _scene(rng: np.random.Generator, chain: Chain, oracle: Oracle) -> Case:
    matrix = oracle.scaled(oracle.geometry(oracle.zero()), chain.size)
    _, values, vectors = np.linalg.svd(matrix)
    rank = int(np.sum(values > 1e-9 * values[0]))
    if values[rank - 1] < 1e-3 or not 1 <= oracle.count - rank <= 4:
        raise Redraw("mobility")
    motions = vectors[rank:].T
    names = list(oracle.single())
    chosen = _independent(rng, oracle, names, motions)
    count = int(rng.integers(1, len(chosen) + 1))
    drives, held_names = chosen[:count], chosen[count:]
    features = set(chain.features)
    # Motions that are left when the held joints stay; what rests in them may be held as well.
    if held_names:
        rows = motions[oracle.rate_columns(held_names)]
        motions = motions @ np.linalg.svd(rows)[2][len(held_names) :].T
    resting = [
        name
        for name in names
        if name not in chosen and np.max(np.abs(motions[oracle.rate_columns([name])])) < 1e-12
    ]
    extra: list[str] = []
    if resting and rng.random() < 0.5:
        extra = [str(rng.choice(resting))]
        features.add("held twice")
    scale = {
        name: chain.size if oracle.slides[oracle.rate_columns([name])[0]] else 1.0 for name in names
    }
    displaced = rng.random() < 0.4 and not extra
    held = {
        name: float(scale[name] * rng.uniform(-0.15, 0.15)) if displaced else 0.0
        for name in held_names
    }
    held.update(dict.fromkeys(extra, 0.0))
    per_drive = np.array([scale[name] for name in drives])
    positions = rng.uniform(-0.2, 0.2, size=(3, len(drives)))
    if rng.random() < 0.6:
        positions[0] = 0.0
    speeds = rng.uniform(-3.0, 3.0, size=positions.shape)
    accelerations = rng.uniform(-5.0, 5.0, size=positions.shape)
    if rng.random() < 0.3:
        speeds, accelerations = np.zeros_like(speeds), np.zeros_like(accelerations)
        features.add("quasi-static")
    gravity = 9.81 * rng.normal(size=3) if rng.random() < 0.7 else np.zeros(3)
    joint_loads = {
        name: float(rng.normal() * 10.0 * (1.0 if scale[name] != 1.0 else chain.size))
        for name in names
        if rng.random() < 0.25
    }
    moving = [name for name in chain.links if oracle.body_of[name] != oracle.root]
    link_loads = {
        str(name): (
            10.0 * rng.normal(size=3),
            10.0 * chain.size * rng.normal(size=3),
            str(rng.choice(["link", "world"])),
        )
        for name in moving
        if rng.random() < 0.25
    }
    compliance: dict[str, Array] = {}
    if rng.random() < 0.3:
        compliance = _compliance(rng, chain, [joint.name for joint in oracle.wrenched])
        features.add("compliance")
    if held:
        features.add("held")
    if len(drives) > 1:
        features.add("several drives")
    return Case(
        chain,
        tuple(drives),
        held,
        joint_loads,
        link_loads,
        gravity,
        compliance,
        positions * per_drive,
        speeds * per_drive,
        accelerations * per_drive,
        frozenset(features),
    )


def _independent(
    rng: np.random.Generator, oracle: Oracle, names: list[str], motions: Array
) -> list[str]:
    """Return joints that together decide the motion, in random order, those of the tree first."""
    order = list(rng.permutation(names))
    if rng.random() < 0.8:
        order.sort(key=lambda name: oracle.chain.joints[name].closes)
    chosen: list[str] = []
    for name in order:
        rows = motions[oracle.rate_columns([*chosen, str(name)])]
        if np.linalg.svd(rows, compute_uv=False)[-1] > 0.05 and len(rows) <= motions.shape[1]:
            chosen.append(str(name))
        if len(chosen) == motions.shape[1]:
            return [str(name) for name in rng.permutation(chosen)]
    raise Redraw("no joints decide the motion")


def _compliance(rng: np.random.Generator, chain: Chain, names: list[str]) -> dict[str, Array]:
    """Return compliances of some joints, stiff in some directions now and then."""
    per_component = np.repeat([chain.size, 1.0], 3)
    result = {}
    for name in names:
        kind = rng.integers(4)
        if kind == 0:
            continue
        if kind == 1:
            root = rng.normal(size=(6, 6)) * per_component[:, None]
            whole = 1e-8 * root @ root.T
            result[name] = 0.5 * (whole + whole.T)
            continue
        values = 1e-8 * rng.uniform(0.5, 2.0, size=6) * per_component**2
        if kind == 2:
            values[rng.random(6) < 0.5] = 0.0
        result[name] = values
    return result
