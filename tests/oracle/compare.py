"""Compares what the package says about a case with what the free bodies say.

Only this file and the tests that call it know the package.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from chains import cut_elsewhere
from free_bodies import OPEN, Oracle, Position, Statics
from scenes import Case, followed, solved
from wound_bushings import wound

import cardan_dyn as cd

Array = np.ndarray
EPS = float(np.finfo(float).eps)

TOLERANCE = 1e-9
"""Relative error that is allowed at conditions up to 1e3, proportionally more beyond."""


@dataclass(frozen=True)
class Difference:
    """Something that differs.

    Attributes:
        what: which result, of which joint.
        size: by how much: relative error over what is allowed; nan where no number tells.
    """

    what: str
    size: float = np.nan

    def __str__(self) -> str:
        return self.what if np.isnan(self.size) else f"{self.what} {self.size:.1e}×"


def scene_of(case: Case) -> cd.Scene:
    """Return the package's scene of a case."""
    loads: dict[str, object] = dict(case.joint_loads)
    for name, (force, moment, axes) in case.link_loads.items():
        loads[name] = cd.Wrench(force, moment, axes)
    return cd.Scene(
        cd.load(case.chain.text),
        drive=list(case.drives),
        held=case.held,
        loads=loads,
        gravity=case.gravity,
        compliance=case.compliance,
    )


def sweep_of(case: Case) -> cd.Sweep:
    """Return the package's sweep of a case."""
    return scene_of(case).sweep(case.positions, speed=case.speeds, acceleration=case.accelerations)


def greatest_moment(sweep: cd.Sweep, case: Case) -> float:
    """Return the greatest moment, or force times length, of a sweep [N·m]; 0 if only rounding.

    Bodies that stand still while joints move beside them bear what accelerations are rounded by.
    """
    mechanism = sweep.mechanism
    length = float(mechanism.characteristic_length)
    found = max(
        max(length * float(np.max(np.abs(one.force))), float(np.max(np.abs(one.moment))))
        for one in sweep.values()
    )
    mass = sum(inertia.mass for inertia in mechanism.model.inertias)
    rates = float(
        np.max(case.speeds**2, initial=0.0) + np.max(np.abs(case.accelerations), initial=0.0)
    )
    return found if found > 1e3 * EPS * mass * length**2 * rates else 0.0


def dissimilar(case: Case, seed: int) -> list[Difference]:
    """Return in what the sweep of a case differs from that of a similar one of another size.

    Lengths and masses are multiplied by up to 1e±9, times by up to 1e±4.
    """
    oracle = Oracle(case.chain)
    exponents = np.random.default_rng(seed).uniform((-9.0, -9.0, -4.0), (9.0, 9.0, 4.0))
    size, mass, time = (10.0**exponents).tolist()
    length = size / case.chain.size
    names = [*case.prescribed, *case.joint_loads]
    slides = oracle.slides[[oracle.rate_columns([name])[0] for name in names]]
    plain, scaled = sweep_of(case), sweep_of(case.scaled(slides, length, mass, time))
    force, unit = mass * length / time**2, float(plain.mechanism.characteristic_length)
    greatest = greatest_moment(plain, case)
    lengths = scaled.mechanism.characteristic_length / length
    errors = {"characteristic length": abs(lengths / unit - 1.0)}
    if np.max(plain.condition) < 1e12:  # Beyond, wrenches are the rounding of nothing.
        change = float(np.max(np.abs(scaled.condition / plain.condition - 1.0)))
        errors["condition"] = 1e-3 * change
    differing = []
    for name in plain.outputs:
        one, other = plain[name], scaled[name]
        error = max(
            unit * float(np.max(np.abs(other.force / force - one.force))),
            float(np.max(np.abs(other.moment / (force * length) - one.moment))),
        )
        errors[f"wrench of {name}"] = error / greatest if greatest else error
        if np.any(one.unique != other.unique):
            differing.append(Difference(f"flags of {name}"))
    allowed = TOLERANCE * max(1.0, float(np.max(plain.condition)) / 1e3)
    return differing + over(errors, allowed)


def cut_differently(case: Case, seed: int) -> list[Difference] | None:
    """Return in what a sweep differs where other joints close the rings of a chain.

    What statics leaves open is compared as well. None if the case cannot be cut elsewhere.
    """
    loads = {name: load for name, load in case.link_loads.items() if load[2] == "link"}
    case = replace(case, compliance={}, link_loads=loads)
    joints = case.chain.joints.values()
    floats = any(joint.type == "floating" for joint in joints)
    if floats or case.chain.couplings or not any(joint.closes for joint in joints):
        return None
    chain, reverse, moved = cut_elsewhere(case.chain, np.random.default_rng([seed, 1]))
    turned = {}
    for name, (force, moment, _) in loads.items():
        axes, point = moved[name][:3, :3], moved[name][:3, 3]
        turned[name] = axes @ force, axes @ moment + np.cross(point, axes @ force), "link"
    first, second = sweep_of(case), sweep_of(replace(case, chain=chain, link_loads=turned))
    length = float(first.mechanism.characteristic_length)
    greatest = greatest_moment(first, case)
    condition = max(float(np.max(item.condition)) for item in (first, second))
    if condition > 1e12 or not greatest:
        return None  # Wrenches are the rounding of nothing.
    ratio = float(second.mechanism.characteristic_length) / length
    errors = {"characteristic length": abs(ratio - 1.0)}
    for name in first.outputs:
        one, other = (item.wrench(name, "world") for item in (first, second))
        sign, way = -1.0 if name in reverse else 1.0, second.origin(name) - first.origin(name)
        force = sign * other.force
        moment = sign * other.moment + np.cross(way, force)
        error = max(
            length * float(np.max(np.abs(force - one.force))),
            float(np.max(np.abs(moment - one.moment))),
        )
        errors[f"wrench of {name}"] = error / greatest
    return over(errors, TOLERANCE * max(1.0, condition / 1e2))


def held_elsewhere(case: Case, seed: int) -> list[Difference] | None:
    """Return in what a scene told to hold joints elsewhere, twice, differs from one made anew.

    Each moves by up to 2.5 rad, or lengths of the mechanism. None if none is held.
    """
    if not case.held:
        return None
    scene, rng = scene_of(case), np.random.default_rng([seed, 2])
    moved = {}
    for joint in rng.permutation(sorted(case.held))[: rng.integers(1, len(case.held) + 1)].tolist():
        slides = scene.mechanism.drivable[joint].slides
        unit = scene.mechanism.characteristic_length if slides else 1.0
        moved[joint] = case.held[joint] + unit * rng.uniform(-2.5, 2.5) * rng.uniform()
    rates = {"speed": case.speeds, "acceleration": case.accelerations}
    sweeps, told = [], []
    with suppress(cd.CardanError):
        aside = rng.choice(sorted(case.held)).item()
        scene = scene.replace(held={aside: case.held[aside] + 0.1 * rng.uniform(-1.0, 1.0)})
    for make in (
        lambda: scene_of(replace(case, held=dict(scene.held) | moved)),
        lambda: scene.replace(held=moved),
    ):
        try:
            sweeps.append(make().sweep(case.positions, **rates))
        except cd.CardanError as error:
            told.append(f"{type(error).__name__}: {error}")
    if told:
        return [] if len(set(told)) < len(told) else [Difference(" beside ".join(told))]
    one, other = sweeps
    length, condition = float(one.mechanism.characteristic_length), float(np.max(one.condition))
    parts = [("force", length), ("moment", 1.0)]
    greatest = greatest_moment(one, case)
    errors = {"coordinates": float(np.max(np.abs(one.motion.q - other.motion.q)))}
    for name in one.outputs:
        error = max(
            scale * float(np.max(np.abs(getattr(one[name], part) - getattr(other[name], part))))
            for part, scale in parts
        )
        errors[f"wrench of {name}"] = error / greatest if greatest else error
    flags = [
        Difference(f"flags of {name}")
        for name in one.outputs
        if np.any(one[name].unique != other[name].unique)
    ]
    return flags + over(errors, 1e-12 * max(1.0, condition))


def misjudged(seed: int) -> list[Difference]:
    """Return what is wrong with the efforts of a bushing that is wound over many turns.

    Where its rotation is sure, it may be refused only for its stiffness.
    """
    case = wound(seed)
    links = (case.links[end] for end in case.ends)
    bushing = cd.Bushing(*links, case.origin, case.stiffness, origin_b=case.origin_b)
    drives = [f"j{index}" for index in range(len(case.axes))]
    scene = cd.Scene(cd.load(case.text), drive=drives, elements=[bushing])
    differing = []
    for target in case.targets:
        vector, sure = case.followed(target)
        try:
            sweep = scene.sweep(target[None] if len(target) > 1 else target)
        except cd.ArgumentError as error:
            if sure and "principal axes of its rotational stiffness" not in str(error):
                differing.append(Difference(f"refused at {target}: {error}"))
            continue
        expected = case.efforts(target, vector)
        size = max(float(np.max(np.abs(expected))), float(np.linalg.norm(vector)), 1e-3)
        errors = {
            f"effort at {target}": float(np.max(np.abs(sweep.drive_effort - expected))) / size
        }
        differing += over(errors, 1e-6)
    return differing


def position_of(sweep: cd.Sweep, oracle: Oracle, sample: int) -> Position:
    """Return joint coordinates of a sample as the package gives them."""
    result = oracle.zero()
    for name in result:
        if result[name].size:
            result[name] = np.atleast_1d(sweep.motion.position(name)[sample])
    return result


def differences(case: Case, sweep: cd.Sweep) -> list[Difference]:
    """Return everything in which a sweep differs from the free bodies."""
    oracle = Oracle(case.chain)
    length = float(sweep.mechanism.characteristic_length)
    differing: list[Difference] = []
    closest = followed(case, oracle)
    statics = []
    for sample, near in enumerate(closest):
        x = position_of(sweep, oracle, sample)
        allowed = TOLERANCE * max(1.0, float(sweep.condition[sample]) / 1e3)
        differing += _position(case, oracle, x, near, sample, allowed)
        differing += _rates(case, oracle, sweep, x, sample, length, allowed)
        statics.append(solved(case, oracle, x, sample, length))
        scale = max(statics[-1].scale, 1e-3 * _acting(case, oracle, sample))
        differing += _wrenches(case, sweep, oracle, statics[-1], sample, scale, allowed)
    return differing + _flags(oracle, sweep, statics)


def _position(
    case: Case, oracle: Oracle, x: Position, near: Position, sample: int, allowed: float
) -> list[Difference]:
    geometry, size = oracle.geometry(x), case.chain.size
    gaps = oracle.gaps(geometry).reshape(-1, 6)
    distance = np.linalg.norm(gaps[:, :3], axis=1).max(initial=0.0) / size
    angle = np.linalg.norm(gaps[:, 3:], axis=1).max(initial=0.0)
    rows = np.abs(oracle.coupling_rows) * np.where(oracle.slides, size, 1.0)
    couplings = np.abs(oracle.coupling_gaps(x)) / rows.max(axis=1, initial=1e-300)
    errors = {
        "loops are open": max(distance, angle),
        "couplings are not met": float(couplings.max(initial=0.0)),
    }
    targets = {**case.held, **dict(zip(case.drives, case.positions[sample], strict=True))}
    for name, value in targets.items():
        scale = size if oracle.slides[oracle.rate_columns([name])[0]] else 1.0
        errors[f"{name} is not where it was prescribed"] = abs(x[name][0] - value) / scale
    # Two assembly modes differ by much more than this.
    apart = 0.0
    for name, expected in oracle.geometry(near).frames.items():
        computed = geometry.frames[name]
        apart = max(apart, float(np.abs(expected[:3, :3] - computed[:3, :3]).max()))
        apart = max(apart, float(np.abs(expected[:3, 3] - computed[:3, 3]).max()) / size)
    differing = over(errors, allowed)
    if apart > 1e-6:
        differing.append(Difference(f"another assembly mode, {apart:.1e} away"))
    return differing


def _rates(
    case: Case,
    oracle: Oracle,
    sweep: cd.Sweep,
    x: Position,
    sample: int,
    length: float,
    allowed: float,
) -> list[Difference]:
    v, a = oracle.rates(
        oracle.geometry(x),
        dict(zip(case.drives, case.speeds[sample], strict=True)),
        dict(zip(case.drives, case.accelerations[sample], strict=True)),
        case.prescribed,
        length,
    )
    per_rate = np.where(oracle.slides, 1.0 / length, 1.0)
    # Accelerations carry squares of velocities.
    fastest = max(np.max(np.abs(v) * per_rate), 1e-100)
    greatest = max(np.max(np.abs(a) * per_rate), fastest**2)
    errors = {}
    for name, span in oracle.columns.items():
        if span.stop == span.start:
            continue
        for what, expected, computed, scale in (
            ("velocity", v, sweep.motion.velocity(name), fastest),
            ("acceleration", a, sweep.motion.acceleration(name), greatest),
        ):
            error = np.abs(np.atleast_1d(computed[sample]) - expected[span]) * per_rate[span]
            errors[f"{what} of {name}"] = float(error.max()) / scale
    return over(errors, allowed)


def _wrenches(
    case: Case,
    sweep: cd.Sweep,
    oracle: Oracle,
    statics: Statics,
    sample: int,
    scale: float,
    allowed: float,
) -> list[Difference]:
    length = float(sweep.mechanism.characteristic_length)
    lengths = np.repeat([length, 1.0], 3)
    # How far from equal stiffness in all directions: rounding of the choice grows with it.
    stiff = statics.stiffness[statics.stiffness > OPEN]
    contrast = float(stiff.max() / stiff.min()) ** 2 if stiff.size else 1.0
    errors: dict[str, float] = {}
    open_errors: dict[str, float] = {}
    for joint in oracle.wrenched:
        computed = sweep[joint.name]
        wrench = np.concatenate([computed.force[sample], computed.moment[sample]])
        error = np.abs(wrench - statics.wrench[joint.name]) * lengths / scale
        is_open = statics.influence[joint.name] > OPEN
        errors[f"wrench of {joint.name}"] = float(error[~is_open].max(initial=0.0))
        open_errors[f"open wrench of {joint.name}"] = float(error[is_open].max(initial=0.0))
    exerted = np.atleast_2d(sweep.drive_effort.T).T[sample]
    efforts = {f"effort of {name}": (name, exerted[k]) for k, name in enumerate(case.drives)}
    for name in case.held:
        efforts[f"holding effort of {name}"] = (name, sweep.holding_effort[name][sample])
    for label, (name, computed) in efforts.items():
        if np.isnan(statics.effort[name]):
            continue
        per_effort = length if oracle.slides[oracle.rate_columns([name])[0]] else 1.0
        # An effort that hangs on an open component is as exact as this one.
        hangs = float(statics.influence[name].max()) > OPEN if name in statics.influence else False
        table = open_errors if hangs else errors
        table[label] = abs(computed - statics.effort[name]) * per_effort / scale
    return [*over(errors, allowed), *over(open_errors, 10.0 * allowed * contrast)]


def _acting(case: Case, oracle: Oracle, sample: int) -> float:
    """Return the size of what could act, where wrenches are nothing but rounding of it [N·m]."""
    size = case.chain.size
    mass = sum(link.mass for link in case.chain.links.values())
    per_rate = np.where(oracle.slides[oracle.rate_columns(case.drives)], 1.0 / size, 1.0)
    rates = [case.speeds[sample] ** 2 * per_rate**2, np.abs(case.accelerations[sample]) * per_rate]
    sizes = [mass * size**2 * float(np.max(terms)) for terms in rates]
    sizes.append(mass * size * float(np.linalg.norm(case.gravity)))
    for name, load in case.joint_loads.items():
        sizes.append(abs(load) * (size if oracle.slides[oracle.rate_columns([name])[0]] else 1.0))
    for force, moment, _ in case.link_loads.values():
        sizes += [size * float(np.linalg.norm(force)), float(np.linalg.norm(moment))]
    return max(sizes)


def _flags(oracle: Oracle, sweep: cd.Sweep, statics: list[Statics]) -> list[Difference]:
    differing = []
    for joint in oracle.wrenched:
        influence = np.max([item.influence[joint.name] for item in statics], axis=0)
        expected, given = influence < OPEN, np.asarray(sweep[joint.name].unique)
        if np.any(expected != given):
            shown = "".join("U" if flag else "o" for flag in given)
            right = "".join("U" if flag else "o" for flag in expected)
            differing.append(
                Difference(f"flags of {joint.name} ({joint.type}) {shown} not {right}")
            )
    return differing


def over(errors: Mapping[str, float], allowed: float) -> list[Difference]:
    """Return what is greater than what is allowed."""
    # Written so that nan is an error.
    return [
        Difference(what, error / allowed) for what, error in errors.items() if not error <= allowed
    ]
