"""Bodies on balls, and chains of two, that turn past right angles, against quaternions.

Absolute rotations as quaternions, accelerations by Jacobians of the centres of mass.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import cardan_dyn as cd

Array = np.ndarray
MOST_ERROR = 1e3
"""Error of rotations, and of energy, in tolerances of a step..."""
GROWN = 30.0
"""...or in errors of the same integration of quaternions with that tolerance."""
FINE = 1e-12
"""Tolerance of the quaternions."""


class Body(NamedTuple):
    """A body: mass, centre, inertia about it, and the next body's ball, from its own ball."""

    mass: float
    centre: Array
    inertia: Array
    end: Array


def _skew(vector: Array) -> Array:
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _matrix(q: Array) -> Array:
    x, y, z, w = (q / np.sqrt(q @ q)).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def turned(bodies: list[Body], start: Array, gravity: Array, end: float, rtol: float):
    """Integrate quaternions `(4 n)` of bodies and their angular velocities `(3 n)`, in bodies."""
    count = len(bodies)

    def rates(_: float, row: Array) -> Array:
        q, w = row[: 4 * count].reshape(count, 4), row[4 * count :].reshape(count, 3)
        turns, spins = [_matrix(item) for item in q], [_skew(item) for item in w]
        mass, force = np.zeros((3 * count, 3 * count)), np.zeros(3 * count)
        for i, body in enumerate(bodies):
            jacobian, bent = np.zeros((3, 3 * count)), np.zeros(3)
            for j in range(i + 1):
                arm = bodies[j].end if j < i else body.centre
                jacobian[:, 3 * j : 3 * j + 3] = -turns[j] @ _skew(arm)
                bent += turns[j] @ spins[j] @ spins[j] @ arm
            own = slice(3 * i, 3 * i + 3)
            mass += body.mass * jacobian.T @ jacobian
            force += jacobian.T @ (body.mass * (gravity - bent))
            mass[own, own] += body.inertia
            force[own] -= spins[i] @ body.inertia @ w[i]
        turning = [
            [*(0.5 * (a[3] * b + _skew(a[:3]) @ b)), -0.5 * a[:3] @ b]
            for a, b in zip(q, w, strict=True)
        ]
        return np.concatenate([np.ravel(turning), np.linalg.solve(mass, force)])

    return solve_ivp(rates, (0.0, end), start, "DOP853", rtol=rtol, atol=1e-13, dense_output=True)


def _text(bodies: list[Body], kind: str) -> tuple[str, list[str]]:
    """Return the description, and the names of the angles about x, y, z in a row."""

    def words(values: Array) -> str:
        return " ".join(repr(float(value)) for value in values)

    parts, names, parent, at = ['<link name="world"/>'], [], "world", np.zeros(3)
    for i, body in enumerate(bodies):
        tensor = " ".join(
            f'i{"xyz"[a]}{"xyz"[b]}="{float(body.inertia[a, b])!r}"'
            for a in range(3)
            for b in range(a, 3)
        )
        parts.append(
            f'<link name="b{i}"><inertial><origin xyz="{words(body.centre)}"/>'
            f'<mass value="{body.mass!r}"/><inertia {tensor}/></inertial></link>'
        )
        origin = f'<origin xyz="{words(at)}"/>'
        if kind == "spherical":
            parts.append(
                f'<joint name="j{i}" type="spherical">{origin}<parent link="{parent}"/>'
                f'<child link="b{i}"/></joint>'
            )
            names += [f"j{i}.{axis}" for axis in "xyz"]
        else:
            parts.append(f'<link name="r{i}"/><link name="s{i}"/>')
            ends = (parent, f"r{i}", f"s{i}", f"b{i}")
            for k, axis in enumerate("xyz"):
                parts.append(
                    f'<joint name="j{i}{axis}" type="continuous">{origin if not k else ""}'
                    f'<axis xyz="{words(np.eye(3)[k])}"/><parent link="{ends[k]}"/>'
                    f'<child link="{ends[k + 1]}"/></joint>'
                )
                names.append(f"j{i}{axis}")
        parent, at = f"b{i}", body.end
    return f'<robot name="turning">{"".join(parts)}</robot>', names


def _body(rng: np.random.Generator) -> Body:
    a, b, c = 0.1 * rng.uniform(0.5, 2.0, 3)
    axes = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
    centre = 0.2 * rng.normal(size=3) * (rng.random() < 0.8)
    tensor = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
    return Body(float(rng.uniform(0.5, 2.0)), centre, tensor, 0.3 * rng.normal(size=3))


def _rates_to_spin(angles: Array) -> Array:
    """Matrix `(3, 3)` from rates of the angles to the angular velocity in the body."""
    _, y, z = (Rotation.from_euler("xyz"[k], angles[k]).as_matrix() for k in range(3))
    return np.column_stack([z.T @ y.T @ [1.0, 0.0, 0.0], z.T @ [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def ask(seed: int) -> tuple[list[str], list[str]]:
    """Return what is wrong with one motion, and what became of it."""
    rng = np.random.default_rng(seed)
    count, kind = int(rng.choice([1] * 9 + [2])), str(rng.choice(["spherical", "hinges"]))
    gravity = np.array([0.0, 0.0, -9.81]) * (rng.random() < 0.6)
    bodies = [_body(rng) for _ in range(count)]
    angles, rates = rng.uniform(-3.0, 3.0, (count, 3)), np.zeros((count, 3))
    aimed = rng.random() < 0.6
    for i in range(count):
        spin = 4.0 * rng.normal(size=3)
        if aimed:  # Past the position in which both outer axes coincide, or through it.
            miss = 10.0 ** rng.uniform(-12, -1) if rng.random() < 0.8 else 0.0
            way = rng.choice([-1, 1]) * rng.uniform(1.0, 5.0)
            rates[i] = [miss * rng.normal(), way, miss * rng.normal()]
        elif abs(np.cos(angles[i, 1])) > 0.05:
            rates[i] = np.linalg.solve(_rates_to_spin(angles[i]), spin)
        else:
            rates[i] = [0.0, 1.0, 0.0]
    if rng.random() < 0.1:
        angles[0, 1] = 0.5 * np.pi * rng.choice([-1, 1])
    turn, spin, quaternions, spins = np.eye(3), np.zeros(3), [], []
    for item, rate in zip(angles, rates, strict=True):
        own = Rotation.from_euler("XYZ", item).as_matrix()
        spin = own.T @ spin + _rates_to_spin(item) @ rate
        turn = turn @ own
        quaternions.append(Rotation.from_matrix(turn).as_quat())
        spins.append(spin)
    start = np.concatenate([*quaternions, *spins])
    end, rtol = float(rng.uniform(1.0, 4.0)), float(10.0 ** rng.uniform(-11, -7))

    text, names = _text(bodies, kind)
    scene = cd.Scene(cd.load(text), free=names, gravity=gravity)
    what = f"{count} {kind}, rtol {rtol:.0e}"
    try:
        moved = scene.simulate(
            end,
            position=dict(zip(names, angles.ravel().tolist(), strict=True)),
            speed=dict(zip(names, rates.ravel().tolist(), strict=True)),
            rtol=rtol,
        )
        times = np.linspace(0.0, end, 61)
        places = moved.at(times).position.reshape(-1, count, 3)
    except cd.CardanError as refused:
        return [f"{what}: {type(refused).__name__}: {refused}"], [kind]
    fine = turned(bodies, start, gravity, end, FINE)
    own = fine.sol(times)[: 4 * count].T.reshape(-1, count, 4)
    error, turn = 0.0, np.broadcast_to(np.eye(3), (len(times), 3, 3))
    for i in range(count):
        turn = turn @ Rotation.from_euler("XYZ", places[:, i]).as_matrix()
        error = max(error, float(np.max(np.abs(turn - Rotation.from_quat(own[:, i]).as_matrix()))))
    allowed = MOST_ERROR * rtol
    if error > allowed:
        coarse = turned(bodies, start, gravity, end, rtol).sol(times)[: 4 * count].T
        allowed += GROWN * float(np.max(np.abs(coarse - own.reshape(len(times), -1))))
    wrong = [f"{what}: rotations off by {error:.1e}"] if not error <= allowed else []
    if len(moved) > 1.2 * len(fine.t) + 20:
        wrong.append(f"{what}: {len(moved)} steps, quaternions {len(fine.t)}")
    if not moved.energy_residual <= MOST_ERROR * rtol:
        wrong.append(f"{what}: energy off by {moved.energy_residual:.1e}")
    return wrong, [kind, "past right angles" if aimed else "any motion"]
