"""Analyses against closed forms, statics of free shafts, virtual work and rebuilt lines."""

import dataclasses

import numpy as np
import pytest
from testkit.line_data import FAN, NEAR, SPAN, Array, along_points, double_shaft, random_line
from testkit.shaft_line import ShaftLine, dot

from cardan_dyn.analytic import drive_line, shaft_design, support_forces
from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, ShaftJoint, Spline, Tube

TURN = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
SPANS = support_forces.Spans(a=SPAN[0], b=NEAR[0], e=NEAR[1], f=SPAN[1])
BETA = np.radians([12.0, 9.0])


def in_space(line: DriveLine, forces: Array, shafts: list[int]) -> Array:
    """Forces of bearings on their shafts `(P, m, 3)` in world axes."""
    turned = []
    for place, shaft in enumerate(shafts):
        axis = line.geometry.directions[shaft]
        left = np.array([-axis[1], axis[0], 0.0]) / np.hypot(*axis[:2])
        turned.append(forces[:, place] @ np.stack([axis, left, np.cross(axis, left)]))
    return np.stack(turned, axis=1)


def pins(line: DriveLine) -> ShaftLine:
    """The line by the vectors of its pins, which know no frames."""
    axis = line.geometry.directions[0]
    left = np.array([-axis[1], axis[0], 0.0]) / np.hypot(*axis[:2])
    offsets = tuple(line.fork_offsets)
    return ShaftLine.turn(line.geometry.directions, left, TURN, offsets)


def worst(found: Array, exact: Array) -> float:
    """Greatest error relative to the greatest value."""
    return float(np.max(np.abs(found - exact)) / np.max(np.abs(exact)))


@pytest.mark.parametrize("arrangement", ["Z", "W"])
def test_support_forces_of_the_catalogue(arrangement: str) -> None:
    rear = 1.0 if arrangement == "W" else -1.0
    line = double_shaft((0.0, BETA[0], BETA[0] + rear * BETA[1]))
    planar = support_forces.planar_support_forces(*BETA, 250.0, 0.9, SPANS, arrangement)
    # The shafts lie in the vertical plane, and the input fork's pin at zero across it.
    for position, forces in zip((np.pi / 2, 0.0), planar, strict=True):
        result = line.analyse(speed=0, torque=250, positions=position)
        found = dict(zip(result.bearings, result.static.bearing_radial[0], strict=True))
        for name in "ABEF":
            assert found[name] == pytest.approx(float(getattr(forces, name)), rel=1e-11, abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_support_forces_at_every_position(seed: int) -> None:
    rng = np.random.default_rng(seed)
    side, plan = rng.uniform(-0.4, 0.4, (2, 3))
    line = double_shaft(tuple(side), tuple(plan), fork_offset=rng.uniform(-3, 3))
    result = line.analyse(speed=0, torque=250, positions=TURN)
    found = in_space(line, result.static.bearing_force, [0, 0, 2, 2])
    exact = support_forces.support_forces(
        line.geometry.directions,
        TURN + line.fork_phases[0],
        250.0,
        0.9,
        SPANS,
        fork_offset=np.diff(line.fork_phases)[0] - np.pi / 2 + _to_plane(line),
    )
    for place, name in enumerate(result.bearings):
        axis = line.geometry.directions[0 if name in "AB" else 2]
        across = found[:, place] - dot(found[:, place], axis)[:, None] * axis
        # The catalogue's forces are those of the shafts on the bearings.
        assert worst(-across, getattr(exact, name)) < 1e-11


def _to_plane(line: DriveLine) -> float:
    """The fork offset counts from fork to fork, phases from bending plane to bending plane."""
    return float(line.geometry.plane_offsets[1])


def free_shafts(
    line: DriveLine, moments: list[Array], held: list[tuple[int, float, bool]]
) -> Array:
    """Forces `(P, m, 3)` of bearings on shafts, from the balance of every shaft by itself.

    Args:
        line: massless; behind a spline and before it, a shaft is two pieces along its axis.
        moments: of each cross on the next shaft `(P, 3)`.
        held: shaft, place along it from its front joint (input: from joint 1), and whether it is
            locating, of each bearing.
    """
    axes, centres, n = line.geometry.directions, line.geometry.centres, line.count
    rows, right = [], []
    unknowns = 3 * (n + len(held))  # Forces in joints on the shaft behind, then those of bearings.
    points = [*centres, *(centres[max(s, 1) - 1] + x * axes[s] for s, x, _ in held)]
    for shaft in range(n + 1):
        on = [(j, 1.0 if j == shaft - 1 else -1.0) for j in (shaft - 1, shaft) if 0 <= j < n]
        on += [(n + i, 1.0) for i, bearing in enumerate(held) if bearing[0] == shaft]
        given = sum(
            (
                moments[j] if j == shaft - 1 else -moments[j]
                for j in (shaft - 1, shaft)
                if 0 <= j < n
            ),
            np.zeros((len(TURN), 3)),
        )
        spline = line.shafts[shaft].spline
        across = np.linalg.svd(axes[shaft][None])[2][1:]
        for direction in across:
            row, lever = np.zeros(unknowns), np.zeros(unknowns)
            for item, sign in on:
                row[3 * item : 3 * item + 3] += sign * direction
                arm = points[item] - points[on[0][0]]
                lever[3 * item : 3 * item + 3] += sign * np.cross(direction, arm)
            rows += [row, lever]
            right += [np.zeros(len(TURN)), -given @ direction]
        for piece in (on,) if spline is None else (on[:1], on[1:]):
            row = np.zeros(unknowns)
            for item, sign in piece:
                row[3 * item : 3 * item + 3] += sign * axes[shaft]
            rows.append(row)
            right.append(np.zeros(len(TURN)))
    for i, (shaft, _, locating) in enumerate(held):
        if not locating:
            row = np.zeros(unknowns)
            row[3 * (n + i) : 3 * (n + i) + 3] = axes[shaft]
            rows.append(row)
            right.append(np.zeros(len(TURN)))
    forces = np.linalg.solve(np.array(rows), np.array(right)).T
    return forces[:, 3 * n :].reshape(len(TURN), len(held), 3)


@pytest.mark.parametrize("count", [2, 3, 4, 6])
def test_bearings_and_centre_bearings_by_free_shafts(count: int) -> None:
    line = random_line(count, seed=count)
    result = line.analyse(speed=0, torque=-300, torque_at="output", positions=TURN)
    held = [(0, -NEAR[0], True), (0, -NEAR[0] - SPAN[0], False)]
    held += [(k, line.shafts[k].bearings[0].distance, False) for k in range(1, count - 1)]
    held += [(count, NEAR[1], True), (count, NEAR[1] + SPAN[1], False)]
    exact = free_shafts(line, pins(line).moments(-300.0), held)
    found = in_space(line, result.static.bearing_force, [shaft for shaft, *_ in held])
    assert worst(found, exact) < 1e-11


def test_a_centre_bearing_by_its_formula() -> None:
    line = random_line(3, seed=7)
    result = line.analyse(speed=0, torque=-300, torque_at="output", positions=TURN)
    m1, m2, m3 = pins(line).moments(-300.0)
    e2, e3 = line.geometry.directions[1:3]
    l1, l2 = line.geometry.lengths[1:3]
    c = line.shafts[1].bearings[0].distance
    force = np.cross(m2 - m3, e3) / l2
    across = force - dot(force, e2)[:, None] * e2
    exact = (l1 * across - np.cross(m1 - m2, e2)) / c
    found = in_space(line, result.static.bearing_force, [0, 0, 1, 3, 3])[:, 2]
    assert min(worst(found, exact), worst(found, -exact)) < 1e-11


@pytest.mark.parametrize("count", [1, 2, 3])
def test_end_shafts_without_bearings_are_held_at_their_joints(count: int) -> None:
    line = random_line(count, seed=count)
    ends = [line.shafts[i] for i in (0, -1)]
    bare = [dataclasses.replace(end, bearings=()) for end in ends]
    line = line.replace(shafts=[bare[0], *line.shafts[1:-1], bare[1]])
    forces = line.analyse(speed=0, torque=-300, torque_at="output", positions=TURN).static
    shafts = [*range(count - 1), count] if count > 1 else [0, 1]
    found = in_space(line, forces.bearing_force, shafts)
    # The bearings hold a massless line together, so their forces on it are in balance.
    assert np.max(np.abs(found.sum(axis=1))) < 1e-9
    if count == 1:
        assert np.max(np.abs(found)) < 1e-9  # A single joint passes on no force.
        return
    assert np.max(np.abs(found[:, -1])) > 50.0
    # About the last joint, the forces balance the couples of the input and the output shaft.
    places = [np.zeros(3)]
    for k in shafts[1:-1]:
        axis = line.geometry.directions[k]
        places.append(line.geometry.centres[k - 1] + line.shafts[k].bearings[0].distance * axis)
    arms = np.array([*places, line.geometry.centres[-1]]) - line.geometry.centres[-1]
    moments = pins(line).moments(-300.0)
    turning = np.cross(arms, found).sum(axis=1)
    assert worst(turning, moments[-1] - moments[0]) < 1e-11


@pytest.mark.parametrize("count", [1, 3, 5])
def test_torsion_and_bending_by_pins(count: int) -> None:
    line = random_line(count, seed=count)
    forces = line.analyse(speed=0, torque=-300, torque_at="output", positions=TURN).static
    for k, moment in enumerate(pins(line).moments(-300.0)):
        for side, shaft in (("in", k), ("out", k + 1)):
            axis = line.geometry.directions[shaft]
            torsion = dot(moment, axis)
            bending = np.linalg.norm(moment - torsion[:, None] * axis, axis=1)
            assert worst(getattr(forces, f"torsion_{side}")[:, k], torsion) < 1e-12
            assert worst(getattr(forces, f"bending_{side}")[:, k], bending) < 1e-12


def test_the_input_torque_is_what_was_asked_for() -> None:
    line = random_line(4, seed=1, mass=True)
    torque = 100.0 + 20.0 * np.sin(TURN)
    forces = line.analyse(speed=200, torque=torque, positions=TURN).static
    assert forces.drive_torque == pytest.approx(torque, rel=1e-13)
    assert forces.torsion_in[:, 0] == pytest.approx(torque, rel=1e-12)


@pytest.mark.parametrize("count", [1, 2, 5, 12])
def test_motion_of_every_shaft(count: int) -> None:
    line = random_line(count, seed=count, bend=0.25)
    result = line.analyse(speed=150, torque=0, positions=TURN)
    for k in range(1, count + 1):
        joints = line.joint_angles[:k], line.fork_phases[:k]
        exact = drive_line.output_angle(*joints, TURN)
        rotation = result.rotation[:, k] - exact
        assert np.ptp(rotation) < 1e-12
        assert worst(result.ratio[:, k], drive_line.speed_ratio(*joints, TURN)) < 1e-12
        epsilon = 150.0**2 * drive_line.acceleration_ratio(*joints, TURN)
        assert worst(result.acceleration[:, k], epsilon) < 1e-11


@pytest.mark.parametrize("phases", [(0, 1, 0, 1, 0), (0, 0, 1, 1, 1), (0, 0, 0, 0, 0)])
def test_the_residual_angle_is_the_product_of_cosines(phases: tuple[int, ...]) -> None:
    angles = np.array([0.2, 0.15, 0.3, 0.1, 0.25])
    # All shafts lie in one plane, and a shaft's forks in line make phases differ by 90°.
    forks = np.pi / 2 * (np.diff(phases) - 1)
    line = random_line(5, seed=0)
    line = along_points(line, angles, np.array([0.3, 0, 0, 0, 0]), fork_offset=forks)
    cosine = np.prod(np.cos(angles) ** (1 - 2 * np.array(phases)))
    fine = np.concatenate([TURN, np.arange(4) * np.pi / 2]) - line.fork_phases[0]
    ratio = line.analyse(speed=0, torque=0, positions=fine).ratio[:, -1]
    assert sorted([ratio.min(), ratio.max()]) == pytest.approx(
        sorted([cosine, 1 / cosine]), rel=1e-13
    )


def test_inertia_of_a_middle_shaft_goes_into_its_torque() -> None:
    middle = Shaft(length=0.8, slope_side=0.3, mass=10, inertia=0.5, centre=0.4, spline=Spline())
    line = DriveLine(shafts=[Shaft(), middle, Shaft(slope_side=-0.1)])
    result = line.analyse(speed=120, torque=200, positions=TURN)
    total = result.total
    gained = total.torsion_out[:, 0] - total.torsion_in[:, 1]
    assert worst(gained, 0.5 * result.acceleration[:, 1]) < 1e-11
    assert result.static.torsion_out[:, 0] == pytest.approx(result.static.torsion_in[:, 1])


def test_acceleration_of_the_input_shaft() -> None:
    middle = Shaft(length=0.8, slope_side=0.3, mass=10, inertia=0.5, centre=0.4, spline=Spline())
    line = DriveLine(shafts=[Shaft(mass=5, inertia=0.2), middle, Shaft(slope_side=-0.1)])
    result = line.analyse(speed=30, acceleration=400.0, torque=0, positions=TURN)
    joints = line.joint_angles[:1], line.fork_phases[:1]
    ratio = drive_line.speed_ratio(*joints, TURN)
    behind = 400.0 * ratio + 30.0**2 * drive_line.acceleration_ratio(*joints, TURN)
    assert result.acceleration[:, 0] == pytest.approx(400.0, rel=1e-13)
    assert worst(result.acceleration[:, 1], behind) < 1e-12
    # What the drive does beside: it accelerates both shafts.
    assert worst(result.total.drive_torque, 0.2 * 400.0 + 0.5 * behind * ratio) < 1e-11


def test_weight_of_both_pieces_of_a_shaft_with_a_spline() -> None:
    tube = Tube(outer_diameter=0.1, wall=0.004)
    # On a straight level line, the shaft is a beam on two ends, which carry half of it each.
    middle = Shaft(length=0.8, tube=tube, spline=Spline(distance=0.2))
    line = DriveLine(shafts=[Shaft(), middle, Shaft()])
    forces = line.analyse(speed=0, torque=0, positions=TURN, gravity=(0, 0, -9.81)).total
    half = 0.8 * tube.area * tube.density * 9.81 / 2.0
    assert forces.bearing_force[..., 2] == pytest.approx(np.full((36, 2), half), rel=1e-10)
    # The moment at the spline, from what is before it: half of all at 0.2 m, a quarter at 0.1 m.
    exact = half * 0.2 - half * 0.5 * 0.1
    assert forces.spline_bending[:, 0] == pytest.approx(exact, rel=1e-10)


def test_a_cross_turns_about_the_normal_of_its_pins() -> None:
    # At the turning points of a steep joint its spin about the normal n has the rate 0 or sin β,
    # so that the power of the drive is the change of the kinetic energy of the cross alone.
    line = DriveLine(
        shafts=[Shaft(), Shaft(slope_plan=0.7)], joints=[ShaftJoint(cross_mass=6.0, cross_span=0.2)]
    )
    fine = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
    torque = line.analyse(speed=20.0, torque=0, positions=fine).total.drive_torque
    one = ShaftLine.turn(line.geometry.directions, np.array([0.0, 1.0, 0.0]), fine)
    axes = np.stack([one.driving[0], one.driven[0], one.normals[0]], axis=1)
    orders = 1j * np.fft.fftfreq(256, 1 / 256)[:, None, None]
    rates = np.fft.ifft(orders * np.fft.fft(axes, axis=0), axis=0).real * 20.0
    spin = 0.5 * np.cross(axes, rates).sum(axis=1)
    about = np.einsum("nij,nj->ni", axes, spin)
    energy = 0.5 * (about**2 @ (6.0 * 0.2**2 / np.array([24.0, 24.0, 12.0])))
    change = np.fft.ifft(orders[:, 0, 0] * np.fft.fft(energy)).real
    assert worst(torque, change) < 1e-10


def test_a_flywheel_behind_one_joint() -> None:
    # Thoma 1920: M_t = Θ ω² d²φ₂/dφ₁².
    line = DriveLine(shafts=[Shaft(), Shaft(slope_plan=0.5, mass=900, inertia=40.0)])
    result = line.analyse(speed=50, torque=0, positions=TURN)
    exact = 40.0 * 50.0**2 * drive_line.acceleration_ratio([0.5], line.fork_phases, TURN)
    assert worst(result.inertial.torsion_out[:, 0], exact) < 1e-12
    assert np.array_equal(result.total.torsion_out, result.inertial.torsion_out)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_holding_moments_by_virtual_work(count: int) -> None:
    line = random_line(count, seed=count)
    result = line.analyse(speed=0, torque=300, torque_at="output", positions=TURN)
    step = 1e-5
    for k in range(count):
        # Joint angles may grow beyond zero alone, so both steps are inside.
        moved = []
        for sign in (-1, 1):
            angles = line.joint_angles.copy()
            angles[k] += sign * step
            moved.append(drive_line.output_angle(angles, line.fork_phases, TURN))
        change = (moved[1] - moved[0]) / (2 * step)
        # The drive stands still: what holds the angle works against the load of -300 N·m.
        assert worst(result.static.holding_moment[:, k], 300.0 * change) < 2e-9


@pytest.mark.parametrize("distance", [0.2, 0.7])
def test_friction_of_a_spline(distance: float) -> None:
    line = double_shaft((0.0, BETA[0], 0.0), friction=0.1, radius=0.03, distance=distance)
    free = line.analyse(speed=0, torque=250, positions=TURN).static
    drawn = line.analyse(speed=0, torque=250, positions=TURN, slipping="out").static
    pushed = line.analyse(speed=0, torque=250, positions=TURN, slipping="in").static
    friction = 0.1 / 0.03 * free.spline_torque
    assert drawn.spline_friction == pytest.approx(-friction, rel=1e-12)
    assert pushed.spline_friction == pytest.approx(friction, rel=1e-12)
    # Drawn out, the splines pull both end shafts towards the middle.
    change = drawn.bearing_axial - free.bearing_axial
    cosine = np.cos(BETA[0])
    assert change[:, 0] == pytest.approx(-friction[:, 0] * cosine, rel=1e-10)
    assert change[:, 2] == pytest.approx(friction[:, 0] * cosine, rel=1e-10)
    least = shaft_design.slip_force(250.0, BETA[0], 0.03, 0.1)
    fork_in_plane = line.analyse(speed=0, torque=250, positions=np.pi / 2, slipping="out")
    assert -fork_in_plane.static.spline_friction[0, 0] == pytest.approx(float(least), rel=1e-12)


def test_the_moment_in_a_spline() -> None:
    line = double_shaft((0.0, 0.2, 0.3), distance=0.6)
    forces = line.analyse(speed=0, torque=250, positions=TURN).static
    # Between the joints the bending moment of the massless shaft changes linearly.
    front, rear = forces.bending_out[:, 0], forces.bending_in[:, 1]
    shear = np.hypot(*np.moveaxis(forces.spline_force[:, 0, 1:], -1, 0))
    for x, end in ((0.6, front), (0.3, rear)):
        assert np.all(forces.spline_bending[:, 0] <= end + x * shear + 1e-9)
    assert forces.spline_torque[:, 0] == pytest.approx(forces.torsion_out[:, 0], rel=1e-12)


def test_a_spline_before_its_bearings_says_the_same() -> None:
    shafts = list(random_line(3, seed=3).shafts)
    fields = {"length": 0.8, "slope_side": 0.1, "slope_plan": -0.1}
    results = []
    for middle in (
        # By a bearing on the piece before the spline, and by one behind it.
        Shaft(**fields, bearings=[Bearing(distance=0.5)], spline=Spline(distance=0.6)),
        Shaft(**fields, bearings=[Bearing(distance=0.5)], spline=Spline(distance=0.4)),
    ):
        rear = Shaft(length=0.7, slope_side=-0.2)
        line = DriveLine(shafts=[shafts[0], middle, rear, shafts[3]])
        results.append(line.analyse(speed=0, torque=250, positions=TURN).static)
    before, behind = results
    assert behind.moment_out == pytest.approx(before.moment_out, abs=1e-10)
    # What a massless beam has at 0.6 m follows from what it has at 0.4 m, unless a bearing is
    # between them; both have one force and moment at the front joint.
    lever = np.cross([0.4, 0.0, 0.0], behind.spline_force[:, 0])
    at_front = behind.spline_moment[:, 0] + lever
    assert at_front == pytest.approx(before.moment_out[:, 0], abs=1e-9)


def test_weight_is_carried_by_the_bearings() -> None:
    line = random_line(4, seed=9, mass=True)
    result = line.analyse(speed=0, torque=0, positions=TURN, gravity=(0, 0, -9.81))
    mass = sum(link.mass for link in line.mechanism.description.links)
    shafts = [0, 0, 1, 2, 4, 4]
    carried = in_space(line, result.total.bearing_force, shafts).sum(axis=1)
    assert carried == pytest.approx(np.tile([0, 0, 9.81 * mass], (36, 1)), abs=1e-9)


@pytest.mark.slow
def test_variants_are_lines_of_their_own() -> None:
    line = random_line(3, seed=4, mass=False)
    rng = np.random.default_rng(1)
    designs = {
        "angles": rng.uniform(0.05, 0.4, (5, 3)),
        "planes": rng.uniform(-0.5, 0.5, (5, 3)),
        "fork_offsets": rng.uniform(-3, 3, (5, 2)),
        "lengths": line.geometry.lengths[1:3] + rng.uniform(-0.02, 0.1, (5, 2)),
    }
    result = line.analyse(speed=90, torque=250, positions=TURN, variants=line.variants(**designs))
    assert result.shape == (5, 36)
    for d in range(5):
        other = along_points(
            line,
            designs["angles"][d],
            designs["planes"][d],
            fork_offset=designs["fork_offsets"][d],
            length=designs["lengths"][d],
        )
        exact = other.analyse(speed=90, torque=250, positions=TURN)
        assert worst(result.ratio[d], exact.ratio) < 1e-11
        assert worst(result.acceleration[d], exact.acceleration) < 1e-10
        for name in ("bearing_force", "moment_in", "moment_out", "holding_moment"):
            found = getattr(result.static, name)[d]
            assert worst(found, getattr(exact.static, name)) < 1e-10, name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spline", "bearing", "longer"),
    [(0.3, 0.5, 0.1), (0.6, 0.5, -0.05), (0.6, 0.5, 0.1)],
    ids=["bearing behind the spline", "pushed in", "drawn out"],
)
def test_longer_shafts_with_a_spline(spline: float, bearing: float, longer: float) -> None:
    def line(length: float, moved: float) -> DriveLine:
        ends = random_line(3, seed=3).shafts
        support = Bearing(distance=bearing + moved, locating=True if spline < bearing else None)
        middle = Shaft(
            length=length, slope_side=0.1, bearings=[support], spline=Spline(distance=spline)
        )
        rear = Shaft(length=0.7, slope_side=-0.2, spline=Spline() if support.locating else None)
        return DriveLine(shafts=[ends[0], middle, rear, ends[3]])

    nominal = line(0.8, 0.0)
    designs = nominal.variants(lengths=[0.8 + longer, 0.7])
    result = nominal.analyse(speed=90, torque=250, positions=TURN, variants=designs)
    # A bearing behind the spline keeps its distance from the rear joint.
    other = line(0.8 + longer, longer if spline < bearing else 0.0)
    exact = other.analyse(speed=90, torque=250, positions=TURN)
    assert result.slip[0, :, 0] == pytest.approx(longer, abs=1e-12)
    assert worst(result.ratio[0], exact.ratio) < 1e-12
    for name in ("bearing_force", "spline_force", "spline_moment"):
        assert worst(getattr(result.static, name)[0], getattr(exact.static, name)) < 1e-10, name


@pytest.mark.slow
@pytest.mark.parametrize(
    "design",
    [
        ([0.3, 0.2, 0.3, 0.2, 0.4], [1.0, 0.5, -0.5, 1.0, -1.0]),
        ([0.27, 0.38, 0.6, 0.57, 0.29], [-3.8, 1.4, 3.4, 2.6, 3.1]),
    ],
)
def test_shafts_are_where_they_are_designed_to_be(design: tuple[list[float], ...]) -> None:
    # Between the data and the second design, the bearings leave the shafts free to tilt: a second
    # place of the shafts can be reached on the way there.
    slopes = [(-0.13, 0.03), (0.2, 0.1), (0.05, -0.1), (-0.2, 0.1), (0.0, 0.2), (-0.3, 0.0)]
    places = {1: (0.374, 0.367), 2: (0.785, 0.127), 3: (0.501, 0.339), 4: (0.71, None)}
    shafts = [
        Shaft(
            slope_side=side,
            slope_plan=plan,
            length=places.get(k, (None, None))[0],
            spline=Spline() if k == 1 else None,
            bearings=[Bearing(distance=places[k][1])] if k in (1, 2, 3) else [],
        )
        for k, (side, plan) in enumerate(slopes)
    ]
    line = DriveLine(shafts=shafts)
    angles, planes = design
    result = line.analyse(
        speed=0,
        torque=1,
        positions=TURN,
        variants=line.variants(angles=angles, planes=planes),
    )
    phases = np.concatenate([[-planes[0]], np.pi / 2 - np.array(planes[1:])]).cumsum()
    exact = drive_line.speed_ratio(angles, phases, TURN)
    assert result.ratio[0, :, -1] == pytest.approx(exact, rel=1e-11)
    assert result.slip == pytest.approx(0.0, abs=1e-13)


@pytest.mark.slow
def test_blocks_make_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    line = double_shaft((0.0, 0.2, 0.1))
    designs = line.variants(fork_offsets=np.linspace(0, 1, 7)[:, None])
    whole = line.analyse(speed=50, torque=100, variants=designs)
    torque = np.linspace(100, 200, 36)
    single = line.analyse(speed=50, torque=torque, positions=TURN)
    monkeypatch.setattr("cardan_dyn.practice.drive_lines.verdict.solving._BLOCK", 301)
    parts = line.analyse(speed=50, torque=100, variants=designs)
    assert parts.static.bearing_force == pytest.approx(whole.static.bearing_force, abs=1e-9)
    assert parts.shape == whole.shape == (7, 72)
    monkeypatch.setattr("cardan_dyn.practice.drive_lines.verdict.solving._BLOCK", 20)
    pieces = line.analyse(speed=50, torque=torque, positions=TURN)
    assert pieces.static.bearing_force == pytest.approx(single.static.bearing_force, abs=1e-9)
    assert pieces.rotation == pytest.approx(single.rotation, abs=1e-12)


def test_misaligned_bearings_move_the_joint_angles() -> None:
    line = double_shaft((0.0, 0.2, 0.0))
    moved = line.analyse(
        speed=0,
        torque=100,
        positions=TURN,
        variants=line.variants(misalignments={"offset_z_1": [0.0, 0.01]}),
    )
    # The output's housing rises by 10 mm: both angles of the Z arrangement grow alike.
    assert np.ptp(moved.ratio[1, :, 2]) < 1e-12
    up = np.array([0.0 - 0.01 * np.sin(0.2), 0.01 * np.cos(0.2)])
    rise = 0.9 * np.array([np.cos(0.2), np.sin(0.2)]) + up
    beta = np.arctan2(rise[1], rise[0])
    assert moved.ratio[1, :, 1].max() == pytest.approx(1 / np.cos(beta), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "side"), [("E", "y"), ("E", "z"), ("F", "y"), ("F", "z"), ("A", "y"), ("B", "z")]
)
def test_tilted_end_shafts_are_in_balance(name: str, side: str) -> None:
    line = double_shaft((0.1, 0.25, -0.1), (0.2, -0.1, 0.05), fork_offset=0.3)
    designs = line.variants(misalignments={f"support_{name}_{side}": [0.02]})
    result = line.analyse(speed=0, torque=100, positions=TURN, torque_at="output", variants=designs)
    forces = in_space(line, result.static.bearing_force[0], [0, 0, 2, 2])
    found = dict(zip(result.bearings, np.moveaxis(forces, 1, 0), strict=True))
    is_output = name in "EF"
    near, far = "EF" if is_output else "BA"
    index, sign = (1, 1.0) if is_output else (0, -1.0)
    axis = line.geometry.directions[2 * index]
    left = np.array([-axis[1], axis[0], 0.0]) / np.hypot(*axis[:2])
    moved = 0.02 * (left if side == "y" else np.cross(axis, left))
    # From the near to the far bearing, which slides along the nominal axis.
    span = (-moved if name == near else moved) + sign * axis * np.sqrt(SPAN[index] ** 2 - 4e-4)
    tilted = sign * span / SPAN[index]
    moment = result.static.moment_out[0, :, 1] if is_output else -result.static.moment_in[0, :, 0]
    # About the joint centre, bearings balance the bending moment that the joint exerts.
    bending = np.linalg.norm(moment[:, 1:], axis=1)
    arms = [sign * NEAR[index] * tilted, sign * (NEAR[index] + SPAN[index]) * tilted]
    couple = np.cross(arms[0], found[near]) + np.cross(arms[1], found[far])
    assert np.linalg.norm(couple, axis=1) == pytest.approx(bending, rel=1e-10)
    assert np.abs(couple @ tilted).max() < 1e-9
    assert np.abs(found[far] @ axis).max() < 1e-9


def test_a_single_joint_passes_on_no_force() -> None:
    line = random_line(1, seed=2)
    result = line.analyse(speed=0, torque=-300, torque_at="output", positions=TURN)
    assert len(result.indeterminate) == 2
    (moment,) = pins(line).moments(-300.0)
    axis = line.geometry.directions[0]
    couple = np.linalg.norm(np.cross(moment, axis), axis=1) / SPAN[0]
    assert result.static.bearing_radial[:, 0] == pytest.approx(couple, rel=1e-10)
    assert result.static.bearing_radial[:, 1] == pytest.approx(couple, rel=1e-10)


@pytest.mark.parametrize(("slipping", "sense"), [("out", -1.0), ("in", 1.0)])
def test_friction_of_a_spline_follows_its_whole_torque(slipping: str, sense: float) -> None:
    """Running up and braking: μ / r of static and inertial torque together, wherever they point."""
    line = DriveLine.from_toml(FAN.replace("slope_side_deg = 3", "slope_side_deg = 14"))
    free = {"torque": 200.0, "gravity": (0.0, 0.0, -9.81), "positions": TURN}
    for rate in (10.0, -10.0):
        found = line.analyse(acceleration=rate, slipping=slipping, **free)
        whole = found.static.spline_torque + found.inertial.spline_torque
        assert (np.sign(whole) == np.sign(200.0 + 25.0 * rate)).all()
        np.testing.assert_allclose(
            found.total.spline_friction, sense * 4.0 * np.abs(whole), rtol=1e-9
        )
        # What statics alone says is that of the torque alone.
        alone = sense * 4.0 * np.abs(found.static.spline_torque)
        np.testing.assert_allclose(found.static.spline_friction, alone, rtol=1e-9)
        without = line.analyse(acceleration=rate, **free)
        np.testing.assert_allclose(whole, without.total.spline_torque, rtol=1e-9)
