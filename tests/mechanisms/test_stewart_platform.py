"""The Stewart-Gough platform: six drives at once, against leg geometry and virtual work.

A pose of the platform is chosen, and the lengths of the legs follow from it with all their rates.
The forces of the drives follow from the principle of virtual work over all bodies. The inverse
way, from the legs to the pose, is left to the package under test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from testkit.jets import Jet, spin
from testkit.urdf_reader import Body, Reader, rotation, text, vector

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver

READER = Reader(text("stewart_platform"))
NUMBERS = range(1, 7)
LEGS = [f"leg_{k}" for k in NUMBERS]
GRAVITY = np.array([0.0, 0.0, -9.81])
SAMPLES = 5
Z = np.array([0.0, 0.0, 1.0])


def turned_by(name: str) -> np.ndarray:
    """Axes of a tree joint in its parent at zero, in columns."""
    return rotation(vector(READER.element("joint", name).find("origin"), "rpy"))


FEET = np.array([READER.origin(f"base_{k}_x") for k in NUMBERS])
FOOT_AXES = [turned_by(f"base_{k}_x") for k in NUMBERS]
MIDDLE_LENGTHS = np.array([READER.origin(leg)[2] for leg in LEGS])
# The platform's middle as seen from ball 1, and the other balls on the platform.
SEAT = -READER.origin("seat_on_platform")
BALLS = np.array([SEAT, *(READER.ends(f"ball_{k}")[1] for k in range(2, 7))])
HEIGHT = FEET[0] + MIDDLE_LENGTHS[0] * FOOT_AXES[0][:, 2] - SEAT


@dataclass(frozen=True)
class Poses:
    """Poses of the platform with twists and accelerations, all in world axes."""

    axes: np.ndarray
    position: np.ndarray
    omega: np.ndarray
    velocity: np.ndarray
    alpha: np.ndarray
    acceleration: np.ndarray

    def moving(self, twist: np.ndarray) -> Poses:
        """Return the same poses with a twist (velocity, ω) and no acceleration."""
        still = np.zeros_like(self.position)
        return Poses(self.axes, self.position, still + twist[3:], still + twist[:3], still, still)

    def carried(self, arm: np.ndarray) -> Jet:
        """Vectors fixed in the platform."""
        return Jet.carried(self.axes @ arm, self.omega, self.alpha)

    def point(self, local: np.ndarray) -> Jet:
        return Jet(self.position, self.velocity, self.acceleration) + self.carried(local)


@dataclass(frozen=True)
class MovingBody:
    """A body with the motion of its frame's origin and of its axes."""

    body: Body
    origin: Jet
    axes: tuple[Jet, Jet, Jet]

    @property
    def centre(self) -> Jet:
        result = self.origin
        for component, axis in zip(self.body.centre, self.axes, strict=True):
            result = result + axis * component
        return result

    def inertia_wrench(self) -> tuple[np.ndarray, np.ndarray]:
        """m (a - g) and Iα + ω × Iω, about the centre of mass."""
        omega, alpha = spin(self.axes)
        columns = np.stack([axis.value for axis in self.axes], axis=2)
        inertia = columns @ self.body.inertia @ columns.transpose(0, 2, 1)
        moment = np.einsum("nij,nj->ni", inertia, alpha)
        moment += np.cross(omega, np.einsum("nij,nj->ni", inertia, omega))
        return self.body.mass * (self.centre.second - GRAVITY), moment


def body(link: str) -> Body:
    read = READER.body(link)
    assert read is not None
    return read


def legs(poses: Poses) -> list[Jet]:
    """Vectors from the universal joints to the balls."""
    feet = [Jet.constant(np.broadcast_to(foot, poses.position.shape)) for foot in FEET]
    return [poses.point(ball) - foot for ball, foot in zip(BALLS, feet, strict=True)]


def lengths(poses: Poses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lengths of the legs `(N, 6)` with first and second derivatives."""
    jets = [leg.length() for leg in legs(poses)]
    return tuple(np.concatenate([jet[order] for jet in jets], axis=1) for order in range(3))


def bodies(poses: Poses) -> list[MovingBody]:
    """All moving bodies with their axes, from the geometry of their joints."""
    shape = poses.position.shape
    result = []
    for index, (leg, foot, foot_axes) in enumerate(
        zip(legs(poses), FEET, FOOT_AXES, strict=True), 1
    ):
        # Hinge 1 stays with the base; hinge 2 is normal to it and to the leg.
        hinge_1 = Jet.constant(np.broadcast_to(foot_axes[:, 0], shape))
        along = leg.unit()
        hinge_2 = along.cross(hinge_1).unit()
        ground = Jet.constant(np.broadcast_to(foot, shape))
        leg_axes = (hinge_2.cross(along), hinge_2, along)
        ball = ground + leg
        yoke = (hinge_1, hinge_2, hinge_1.cross(hinge_2))
        result += [
            MovingBody(body(f"yoke_{index}"), ground, yoke),
            MovingBody(body(f"cylinder_{index}"), ground, leg_axes),
            MovingBody(body(f"rod_{index}"), ball, leg_axes),
        ]
        if index == 1:
            result += wrist(poses, ball, leg_axes)
    platform = tuple(poses.carried(axis) for axis in np.eye(3))
    middle = Jet(poses.position, poses.velocity, poses.acceleration)
    return [
        *result,
        MovingBody(body("seat"), poses.point(SEAT), platform),
        MovingBody(body("platform"), middle, platform),
    ]


def wrist(poses: Poses, ball: Jet, leg_axes: tuple[Jet, Jet, Jet]) -> list[MovingBody]:
    """The gimbal at ball 1: hinge x stays with the rod, hinge z with the platform, y is normal."""
    omega, alpha = spin(leg_axes)
    columns = np.stack([axis.value for axis in leg_axes], axis=2)
    hinge_x = Jet.carried(columns @ turned_by("ball_1_x")[:, 0], omega, alpha)
    hinge_z = poses.carried(Z)
    hinge_y = hinge_z.cross(hinge_x).unit()
    return [
        MovingBody(body("wrist_a"), ball, (hinge_x, hinge_y, hinge_x.cross(hinge_y))),
        MovingBody(body("wrist_b"), ball, (hinge_y.cross(hinge_z), hinge_y, hinge_z)),
    ]


def drive_forces(poses: Poses) -> np.ndarray:
    """Forces of the drives `(N, 6)` by virtual work: Jᵀ f = Σ (force · δx + moment · δφ)."""
    rates = np.zeros((len(poses.position), 6, 6))
    work = np.zeros((len(poses.position), 6))
    wrenches = [item.inertia_wrench() for item in bodies(poses)]
    for column, twist in enumerate(np.eye(6)):
        virtual = poses.moving(twist)
        rates[:, :, column] = lengths(virtual)[1]
        for (force, moment), item in zip(wrenches, bodies(virtual), strict=True):
            omega, _ = spin(item.axes)
            work[:, column] += np.sum(force * item.centre.first + moment * omega, axis=1)
    return np.linalg.solve(rates.transpose(0, 2, 1), work[:, :, None])[:, :, 0]


def leg_jacobian(poses: Poses) -> np.ndarray:
    """Leg rates per twist of the platform `(N, 6, 6)`: rows (u, (R p) × u)."""
    rows = []
    for leg, ball in zip(legs(poses), BALLS, strict=True):
        unit = leg.unit().value
        rows.append(np.concatenate([unit, np.cross(poses.axes @ ball, unit)], axis=1))
    return np.stack(rows, axis=1)


@pytest.fixture(scope="module")
def poses() -> Poses:
    """The middle position and poses all over the work space, with large rates."""
    random = np.random.default_rng(20)
    scale = np.r_[0.0, np.ones(SAMPLES - 1)][:, None]
    position = HEIGHT + scale * random.uniform(-0.08, 0.08, (SAMPLES, 3))
    angles = scale * random.uniform(-0.2, 0.2, (SAMPLES, 3))
    return Poses(
        np.array([rotation(rpy) for rpy in angles]),
        position,
        random.uniform(-1.5, 1.5, (SAMPLES, 3)),
        random.uniform(-0.8, 0.8, (SAMPLES, 3)),
        random.uniform(-8.0, 8.0, (SAMPLES, 3)),
        random.uniform(-6.0, 6.0, (SAMPLES, 3)),
    )


@pytest.fixture(scope="module")
def mechanism() -> cd.Mechanism:
    return cd.load("stewart_platform")


def still(poses: Poses) -> Poses:
    return poses.moving(np.zeros(6))


def sweep(mechanism: cd.Mechanism, poses: Poses, **options: object) -> cd.Sweep:
    size, first, second = lengths(poses)
    scene = cd.Scene(mechanism, drive=LEGS, **options)
    return scene.sweep(size - MIDDLE_LENGTHS, speed=first, acceleration=second)


@pytest.fixture(scope="module")
def moving(mechanism: cd.Mechanism, poses: Poses) -> cd.Sweep:
    return sweep(mechanism, poses, gravity=GRAVITY)


def test_poses_follow_from_the_legs(moving: cd.Sweep, poses: Poses) -> None:
    """Six leg lengths give back the chosen pose, at every ball."""
    for index, ball in enumerate(BALLS[1:], 2):
        expected = poses.point(ball).value
        assert np.max(np.abs(moving.origin(f"ball_{index}") - expected)) < 1e-12
    assert np.max(np.abs(moving.origin("ball_1_z") - poses.point(SEAT).value)) < 1e-12
    assert np.max(np.abs(moving.rotation("ball_1_z") - poses.axes)) < 1e-12
    assert np.ptp(moving.motion.position("leg_3")) > 0.02


def test_platform_wrench_at_rest(mechanism: cd.Mechanism, poses: Poses) -> None:
    """f = -J⁻ᵀ w for a wrench on the platform, and every leg carries its force and nothing else."""
    force, moment = np.array([150.0, -80.0, -900.0]), np.array([60.0, 110.0, -45.0])
    load = cd.Wrench(force=force, moment=moment, frame="world")
    turn = sweep(mechanism, still(poses), loads={"platform": load})
    transposed = leg_jacobian(poses).transpose(0, 2, 1)
    wrench = np.concatenate([force, moment])
    expected = np.linalg.solve(transposed, np.tile(-wrench, (SAMPLES, 1))[:, :, None])[:, :, 0]
    scale = np.max(np.abs(expected))
    assert turn.drive_effort.shape == (SAMPLES, 6)
    assert np.max(np.abs(turn.drive_effort - expected)) < 1e-12 * scale
    for index, leg in enumerate(legs(poses), 1):
        along = expected[:, [index - 1]] * leg.unit().value
        balls = ["ball_1_x", "ball_1_y", "ball_1_z"] if index == 1 else [f"ball_{index}"]
        for name in (f"base_{index}_x", f"base_{index}_y", f"leg_{index}", *balls):
            wrench = turn.wrench(name, "world")
            assert np.max(np.abs(wrench.force - along)) < 1e-12 * scale, name
            assert np.max(np.abs(wrench.moment)) < 1e-12 * scale, name


def test_weight_at_rest(mechanism: cd.Mechanism, poses: Poses) -> None:
    """Weight of platform and legs by virtual work; in the middle all six legs carry alike."""
    turn = sweep(mechanism, still(poses), gravity=GRAVITY)
    expected = drive_forces(still(poses))
    assert np.max(np.abs(turn.drive_effort - expected)) < 1e-12 * np.max(np.abs(expected))
    # The wrist of leg 1 and the motors beside the legs make a small difference.
    assert np.ptp(turn.drive_effort[0]) < 0.01 * np.mean(turn.drive_effort[0])
    carried = sum(turn.wrench(f"base_{k}_x", "world").force for k in NUMBERS)
    weight = sum(item.body.mass for item in bodies(poses)) * GRAVITY
    assert np.max(np.abs(carried + weight)) < 1e-12 * np.max(np.abs(weight))


def test_forces_at_speed(moving: cd.Sweep, poses: Poses) -> None:
    """All bodies' Newton-Euler terms by virtual work, with six drives moving at once."""
    expected = drive_forces(poses)
    assert np.max(np.abs(moving.drive_effort - expected)) < 1e-12 * np.max(np.abs(expected))
    static = drive_forces(still(poses))
    assert np.max(np.abs(expected - static)) > 0.3 * np.max(np.abs(static))
    assert moving.loop_residual < 1e-13
    assert moving.balance_residual < 1e-12
    assert moving.power_residual < 1e-12


def test_balls_carry_the_platform_at_speed(moving: cd.Sweep, poses: Poses) -> None:
    """Newton and Euler of the platform with its seat: six ball forces, no ball moments."""
    force, moment = np.zeros((SAMPLES, 3)), np.zeros((SAMPLES, 3))
    for item in bodies(poses)[-2:]:
        body_force, body_moment = item.inertia_wrench()
        force += body_force
        moment += body_moment + np.cross(item.centre.value - poses.position, body_force)
    ball_force, ball_moment = np.zeros_like(force), np.zeros_like(moment)
    for index, ball in enumerate(BALLS, 1):
        wrench = moving.wrench("ball_1_z" if index == 1 else f"ball_{index}", "world")
        ball_force += wrench.force
        ball_moment += wrench.moment + np.cross(poses.axes @ ball, wrench.force)
        if index > 1:
            assert np.max(np.abs(wrench.moment)) < 1e-12 * np.max(np.abs(wrench.force))
    scale = np.max(np.abs(moving.drive_effort))
    assert np.max(np.abs(ball_force - force)) < 1e-12 * scale
    assert np.max(np.abs(ball_moment - moment)) < 1e-12 * scale


def test_everything_is_unique(moving: cd.Sweep) -> None:
    assert np.all([moving[name].unique for name in moving.outputs])


def test_a_path_of_six_drives_is_followed_many_samples_at_a_time(
    mechanism: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The loops are closed for whole arrays, however the drives move together."""
    legs = [f"leg_{index}" for index in range(1, 7)]
    phase = np.linspace(0.0, 2.0 * np.pi, 600)[:, None] + np.arange(6)
    path = 0.05 * (np.sin(phase) - np.sin(phase[0]))
    rates = {"speed": 0.1 * np.cos(phase), "acceleration": -0.1 * np.sin(phase)}
    sizes = []
    real = GroupSolver.evaluate

    def counted(self: GroupSolver, x: np.ndarray, *arguments: object) -> object:
        sizes.append(len(x))
        return real(self, x, *arguments)

    monkeypatch.setattr(GroupSolver, "evaluate", counted)
    whole = cd.Scene(mechanism, drive=legs, gravity=GRAVITY).sweep(path, **rates)
    assert len(sizes) < 60
    assert sum(sizes) < 8 * len(path)
    # One sample reached on its own, from the start by smaller steps, is the same.
    for sample in (140, 333, 599):
        rates_there = {name: value[[sample]] for name, value in rates.items()}
        alone = cd.Scene(mechanism, drive=legs, gravity=GRAVITY).sweep(
            path[[sample]], **rates_there
        )
        for name in mechanism.joint_names:
            size = np.max(np.abs(whole[name].force)) + np.max(np.abs(whole[name].moment))
            assert np.max(np.abs(alone[name].force[0] - whole[name].force[sample])) < 1e-12 * size
            assert np.max(np.abs(alone[name].moment[0] - whole[name].moment[sample])) < 1e-12 * size


@pytest.mark.slow
def test_what_six_drives_cannot_reach_is_refused_with_what_they_reached(
    mechanism: cd.Mechanism,
) -> None:
    legs = [f"leg_{index}" for index in range(1, 7)]
    path = np.outer(np.linspace(0.0, 1.0, 40), [0.0, 0.0, 0.0, 0.0, 0.0, 5.0])
    with pytest.raises(cd.AssemblyError, match="cannot be closed at drive positions") as caught:
        cd.Scene(mechanism, drive=legs).sweep(path)
    assert 0.0 < caught.value.nearest[5] < caught.value.position[5]
