"""Lines of joints against pins turned from joint to joint in space, at 50 digits and more."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.cross_geometry import ULP, cross, dot, norm, relative_errors, turned

from cardan_dyn.analytic import _cross, drive_line, single_joint

modest = settings(max_examples=60, deadline=None, derandomize=True)
QUARTER = np.pi / 2


class Chain:
    """A drive line in one plane whose joints all bend to the same side.

    Its forks are offset so that the phases come out as given. All numbers are mpf.
    """

    def __init__(self, betas, phases):
        self.betas, self.phases = betas, phases
        heading, self.axes = mp.mpf(0), []
        for beta in [0, *betas]:
            heading += beta
            self.axes.append((mp.cos(heading), mp.sin(heading), mp.mpf(0)))
        self.up = (mp.mpf(0), mp.mpf(0), mp.mpf(1))

    def output(self, phi):
        # Planes offset by pi from joint to joint: W arrangement.
        in_plane = cross(self.up, self.axes[0])
        pin = turned(in_plane, self.axes[0], phi + self.phases[0])
        for k, axis in enumerate(self.axes[1:]):
            driven = cross(axis, pin)
            driven = tuple(d / norm(driven) for d in driven)
            if k + 1 < len(self.phases):
                step = self.phases[k + 1] - self.phases[k] - mp.pi / 2
                pin = turned(driven, axis, step)
        # At phi = 0 and phase 0 the driven pin of a joint is normal to the plane.
        start, quarter = self.up, cross(self.axes[-1], self.up)
        angle = mp.atan2(dot(driven, quarter), dot(driven, start)) - self.phases[-1]
        # Each joint leads by less than 90 degrees; the test cases stay below 90 in total.
        return angle + mp.pi * mp.nint((phi - angle) / mp.pi)


def exact(values, multiples=None):
    """The floats as mpf; phases that are multiples of 90 degrees exactly so."""
    if multiples is None:
        return [mp.mpf(float(v)) for v in values]
    return [m * mp.pi / 2 for m in multiples]


LINES = [
    # degrees, phases in quarter turns or None, phases in rad
    ((30.0,), (0,), None),
    ((60.0, 60.0), (0, 0), None),
    ((60.0, 50.0), (0, 1), None),
    ((89.99,), (1,), None),
    ((80.0, 85.0), (1, 0), None),
    ((80.0, 89.0), (0, 1), None),
    ((10.0, 10.0001), (0, 1), None),
    ((20.0, 20.0 + 1e-9), (1, 0), None),
    ((1e-4, 2e-4), (1, 2), None),
    ((35.0, 25.0, 40.0), (0, 1, 1), None),
    ((12.0, 20.0), None, (0.3, -1.1)),
    ((25.0, 8.0, 30.0, 14.0), None, (0.0, 1.0, 2.5, -0.4)),
]
ROTATIONS = [0.0, 1e-9, -0.3, 1.0, QUARTER, 3 * QUARTER, 4.0, -2 * np.pi, 1e6, 2e6 * np.pi]


def line(case):
    degrees, multiples, radians = case
    betas = np.radians(degrees)
    phases = np.array(radians if multiples is None else np.array(multiples) * QUARTER)
    chain = Chain(exact(betas), exact(phases, multiples))
    return betas, phases, chain


@pytest.mark.parametrize("case", LINES)
def test_motion_is_exact(case):
    betas, phases, chain = line(case)
    rotations = [mp.mpf(phi) for phi in ROTATIONS]
    references = [chain.output(phi) for phi in rotations]
    values = drive_line.output_angle(betas, phases, ROTATIONS)
    ratios = drive_line.speed_ratio(betas, phases, ROTATIONS)
    steps = drive_line.acceleration_ratio(betas, phases, ROTATIONS)
    first = [mp.diff(chain.output, phi) for phi in rotations]
    second = [mp.diff(chain.output, phi, 2) for phi in rotations]
    assert np.max(relative_errors(ratios, first)) <= 8 * ULP
    if case[1] is not None:
        assert np.max(relative_errors(values, references)) <= 8 * ULP
        assert np.max(relative_errors(steps, second)) <= 8 * ULP
    else:
        # Zeros of output and acceleration lie at rotations of no special value.
        error = max(
            abs(mp.mpf(float(v)) - r) / (1 + abs(r))
            for v, r in zip(values, references, strict=True)
        )
        assert error <= 4 * ULP
        greatest = max(abs(r) for r in second)
        error = max(
            abs(mp.mpf(float(v)) - r) / greatest for v, r in zip(steps, second, strict=True)
        )
        assert error <= 8 * ULP


@pytest.mark.parametrize("case", LINES)
def test_residual_angle_is_exact(case):
    betas, phases, chain = line(case)
    # The ratio of greatest to smallest speed ratio of a single joint is 1 / cos^2 beta.
    place = drive_line.equivalent_joint(betas, phases).phase
    extremes = []
    for guess in (-place, -place + QUARTER):
        root = mp.findroot(
            lambda phi: mp.diff(chain.output, phi, 2),
            (mp.mpf(guess) - 1e-6, mp.mpf(guess) + 2e-6),
        )
        extremes.append(mp.diff(chain.output, root))
    cosine = mp.sqrt(min(extremes) / max(extremes))
    reference = 2 * mp.asin(mp.sqrt((1 - cosine) / 2))
    value = drive_line.residual_angle(betas, phases)
    assert relative_errors(value, [reference])[0] <= 8 * ULP


@pytest.mark.parametrize("degrees", [1e-9, 1.0, 30.0, 60.0, 89.999])
@pytest.mark.parametrize("start", [0.0, QUARTER, 0.3, -2.0, 5 * QUARTER])
@pytest.mark.parametrize("turn", [QUARTER, -QUARTER, 3 * QUARTER])
def test_equal_angles_leave_exactly_nothing(degrees, start, turn):
    betas, phases = np.radians([degrees, degrees]), np.array([start, start + turn])
    assert drive_line.residual_angle(betas, phases) == 0.0
    assert drive_line.residual_angle_approximate(betas, phases) == 0.0
    assert drive_line.equivalent_joint(betas, phases) == (0.0, 0.0, 0.0)
    phi = np.array([-4.0, 0.0, 1e-9, 1.0, 1e6])
    np.testing.assert_allclose(drive_line.output_angle(betas, phases, phi), phi, rtol=2 * ULP)
    np.testing.assert_allclose(drive_line.speed_ratio(betas, phases, phi), 1.0, rtol=1.01 * ULP)
    assert not np.any(drive_line.acceleration_ratio(betas, phases, phi))


def test_two_compensated_shafts_in_series_leave_exactly_nothing():
    betas = np.radians([5.0, 8.0, 8.0, 5.0])
    for phases in ([0, 1, 0, 1], [0, 0, 1, 1], [0, 1, 2, 3]):
        assert drive_line.residual_angle(betas, np.array(phases) * QUARTER) == 0.0


@pytest.mark.parametrize("degrees", [0.5, 12.0, 60.0, 89.0])
def test_nearly_equal_angles_lose_no_digits(degrees):
    first = np.radians(degrees)
    for difference in (1e-3, 1e-9, 1e-14):
        second = first * (1 + difference)
        a, b = mp.mpf(float(first)), mp.mpf(float(second))
        # Exactly, cos beta_E = cos b / cos a.
        reference = mp.acos(mp.cos(b) / mp.cos(a))
        value = drive_line.residual_angle([first, second], [0.0, QUARTER])
        assert relative_errors(value, [reference])[0] <= 8 * ULP
        reference = mp.sqrt(b * b - a * a)
        value = drive_line.residual_angle_approximate([first, second], [0.0, QUARTER])
        assert relative_errors(value, [reference])[0] <= 8 * ULP


def test_near_90_degrees():
    betas, phases = np.radians([89.999, 89.99]), [0.0, QUARTER]
    a, b = (mp.mpf(float(beta)) for beta in betas)
    reference = mp.acos(mp.cos(a) / mp.cos(b))
    value = drive_line.residual_angle(betas, phases)
    assert relative_errors(value, [reference])[0] <= 8 * ULP
    reference = mp.acos(mp.cos(a) * mp.cos(b))
    value = drive_line.residual_angle(betas, [0.0, 0.0])
    assert relative_errors(value, [reference])[0] <= 8 * ULP


JOINTS = st.lists(
    st.tuples(st.floats(0.0, np.radians(45.0)), st.floats(-4.0, 4.0)), min_size=1, max_size=5
)


def composed(joints, phi):
    """Rotation and ratio, joint by joint with the functions of the single joint."""
    turned_by, ratio = phi, 1.0
    for beta, gamma in joints:
        ratio = ratio * single_joint.speed_ratio(beta, turned_by + gamma)
        turned_by = single_joint.output_angle(beta, turned_by + gamma) - gamma
    return turned_by, ratio


@modest
@given(JOINTS, st.floats(-50, 50))
def test_composition_of_single_joints(joints, phi):
    betas, phases = zip(*joints, strict=True)
    angle, ratio = composed(joints, phi)
    assert drive_line.output_angle(betas, phases, phi) == pytest.approx(angle, abs=1e-11)
    assert drive_line.speed_ratio(betas, phases, phi) == pytest.approx(ratio, rel=1e-11)


@modest
@given(JOINTS, st.floats(-50, 50))
def test_equivalent_joint_moves_like_the_line(joints, phi):
    betas, phases = zip(*joints, strict=True)
    single = drive_line.equivalent_joint(betas, phases)
    lead = single_joint.lead(single.beta, phi + single.phase)
    angle = drive_line.output_angle(betas, phases, phi)
    assert angle == pytest.approx(phi + single.shift + lead, abs=1e-12)
    assert -QUARTER <= single.phase <= QUARTER


@modest
@given(JOINTS, st.floats(-50, 50))
def test_derivatives_equal_complex_steps(joints, phi):
    """The complex step goes through the joints one by one, not through the equivalent joint."""
    betas, phases = zip(*joints, strict=True)
    step = 1e-30
    turned_by, ratio = phi + 1j * step, 1.0 + 0j
    for beta, gamma in joints:
        sine, cosine = _cross.sine_cosine(turned_by + gamma, "in_plane")
        ratio = ratio * _cross.speed_ratio(np.cos(beta), sine, cosine)
        versine = _cross.versine(beta)
        turned_by = turned_by + _cross.lead(np.cos(beta), versine, sine, cosine)
    assert drive_line.speed_ratio(betas, phases, phi) == pytest.approx(
        turned_by.imag / step, rel=1e-11
    )
    assert drive_line.acceleration_ratio(betas, phases, phi) == pytest.approx(
        ratio.imag / step, rel=1e-10, abs=1e-10 / np.prod(np.cos(betas)) ** 2
    )


@modest
@given(JOINTS)
def test_first_order_is_the_limit_of_small_angles(joints):
    betas, phases = (np.array(x) for x in zip(*joints, strict=True))
    errors = []
    for scale in (0.1, 0.05):
        small = betas * scale
        exact_, first = (
            function(small, phases) ** 2
            for function in (drive_line.residual_angle, drive_line.residual_angle_approximate)
        )
        errors.append(abs(exact_ - first))
    # The error of the square is of fourth order.
    bound = np.sum(betas**2) ** 2
    assert errors[0] <= bound * 0.1**4 + 1e-16
    assert errors[1] <= bound * 0.05**4 + 1e-16


def test_product_formula_of_both_fork_positions():
    betas = np.radians([12.0, 30.0, 25.0, 8.0, 20.0])
    signs = np.array([1, -1, 1, 1, -1])
    phases = np.where(signs > 0, 0.0, QUARTER)
    cosine = np.prod(np.cos(betas) ** signs)
    reference = np.arccos(min(cosine, 1 / cosine))
    assert drive_line.residual_angle(betas, phases) == pytest.approx(reference, rel=1e-13)
    total = np.sqrt(abs(np.sum(signs * betas**2)))
    assert drive_line.residual_angle_approximate(betas, phases) == pytest.approx(total, rel=1e-14)


def test_wrong_fork_position_doubles_the_non_uniformity():
    beta = np.radians(20.0)
    phi = np.linspace(0, np.pi, 181)
    wrong = drive_line.speed_ratio([beta, beta], [0.0, 0.0], phi)
    assert np.min(wrong) == pytest.approx(np.cos(beta) ** 2, rel=8 * ULP)
    assert np.max(wrong) == pytest.approx(1 / np.cos(beta) ** 2, rel=8 * ULP)


def test_fork_phases():
    Z, W, offset = 0.0, np.pi, 1.1
    for planes, forks in ((Z, 0.0), (W, 0.0), (offset, offset), (offset, offset + np.pi)):
        phases = drive_line.fork_phases([planes], [forks])
        assert drive_line.residual_angle([0.4, 0.4], phases) == 0.0
    np.testing.assert_allclose(
        drive_line.fork_phases([0.2, 0.5], [0.3, 0.1], first=0.7),
        [0.7, 0.7 + QUARTER + 0.1, 0.7 + 2 * QUARTER - 0.3],
    )
    assert drive_line.fork_phases(np.zeros((4, 2)), np.zeros(2)).shape == (4, 3)


@pytest.mark.parametrize("quarters", [(10, 11), (-400, -399), (20, 23), (3, 100_000)])
def test_whole_turns_leave_no_rounding(quarters):
    phases = np.array(quarters) * QUARTER
    even = (quarters[1] - quarters[0]) % 2 == 0
    for beta in (0.01, 0.2, 1.0):
        equal = drive_line.residual_angle([beta, beta], phases)
        doubled = np.arccos(np.cos(beta) ** 2)
        assert equal == (pytest.approx(doubled, rel=1e-12) if even else 0.0)
        assert (drive_line.residual_angle_approximate([beta, beta], phases) == 0.0) != even


@pytest.mark.parametrize(("turns", "offset"), [(0, 0.3), (7, 0.3), (-100, 1.234)])
def test_whole_turns_of_oblique_phases(turns, offset):
    """Both phases carry the rounding of the turns, so their difference is 90 degrees."""
    phases = np.array([offset, offset + QUARTER]) + 2 * np.pi * turns
    assert drive_line.residual_angle([0.2, 0.2], phases) == 0.0


def test_what_is_more_than_rounding_counts():
    """Exactly to first order, a phase error e of equal joints leaves beta sqrt(2 sin e)."""
    beta, error = 1e-3, 1e-12
    value = drive_line.residual_angle([beta, beta], [0.0, QUARTER + error])
    assert value == pytest.approx(beta * np.sqrt(2 * error), rel=1e-3)


@pytest.mark.parametrize("plane", [0.0, np.pi, -np.pi, 6 * np.pi])
@pytest.mark.parametrize(("quarters", "rest"), [(0, 0.0), (10, 0.0), (0, 0.3)])
def test_fork_phases_gather_no_rounding_along_the_line(plane, quarters, rest):
    joints, first = 400, quarters * QUARTER + rest
    phases = drive_line.fork_phases(np.full(joints - 1, plane), np.zeros(joints - 1), first)
    count = quarters + np.arange(joints) * (1 - round(plane / QUARTER))
    np.testing.assert_allclose(phases, count * QUARTER + rest, rtol=ULP)
    assert drive_line.residual_angle(np.full(joints, 0.2), phases) == 0.0


def test_offsets_that_cancel_along_the_line():
    """0.1 + 0.2 - 0.3 is not zero in floats, and its root would be 1e-8 of the joint angle."""
    phases = drive_line.fork_phases([0.0] * 3, [0.1, 0.2, -0.3])
    assert phases[3] == 3 * QUARTER
    np.testing.assert_allclose(phases[1:3], [QUARTER + 0.1, 2 * QUARTER + 0.3], rtol=2 * ULP)


def test_first_phases_broadcast():
    first = np.array([[0.0], [0.5], [np.nan]])
    phases = drive_line.fork_phases(np.zeros((4, 2)), 0.1, first)
    assert phases.shape == (3, 4, 3)
    np.testing.assert_allclose(phases[1, 2], [0.5, 0.6 + QUARTER, 0.7 + 2 * QUARTER])
    assert np.isnan(phases[2]).all()
    assert not np.isnan(phases[:2]).any()


def test_shapes_and_nan():
    betas = np.radians([[10.0, 10.0], [20.0, np.nan], [30.0, 5.0]])
    phi = np.zeros((4, 3))
    phi[1, 0] = np.nan
    for name in ("output_angle", "speed_ratio", "acceleration_ratio"):
        values = getattr(drive_line, name)(betas, [0.0, QUARTER], phi)
        expected = np.zeros((4, 3), dtype=bool)
        expected[:, 1] = expected[1, 0] = True
        assert np.array_equal(np.isnan(values), expected)
        assert isinstance(getattr(drive_line, name)([0.1, 0.2], [0.0, 1.0], 0.3), float)
    residual = drive_line.residual_angle(betas, [0.0, QUARTER])
    assert np.isnan(residual).tolist() == [False, True, False]
    assert isinstance(drive_line.residual_angle([0.1, 0.2], [0.0, 1.0]), float)
    assert drive_line.residual_angle(0.3, 0.0) == pytest.approx(0.3, rel=4 * ULP)


def test_bad_arguments():
    with pytest.raises(ValueError, match=r"betas\[1\] = 1.6 "):
        drive_line.residual_angle([0.1, 1.6], [0.0, 1.0])
    with pytest.raises(ValueError, match=r"betas \(2,\), phases \(3,\)"):
        drive_line.speed_ratio([0.1, 0.2], [0.0, 1.0, 2.0], 0.0)
    with pytest.raises(ValueError, match=r"betas .* no joint"):
        drive_line.residual_angle([], [])
    with pytest.raises(ValueError, match=r"phi_1 of shape \(4,\) .* \(3,\)"):
        drive_line.output_angle(np.full((3, 2), 0.1), [0.0, 1.0], np.zeros(4))
    for first in ("x", 1j, None):
        with pytest.raises(ValueError, match=r"first = .* must be real numbers"):
            drive_line.fork_phases([0.0], [0.0], first)
    with pytest.raises(ValueError, match=r"first = inf .*\(-inf, inf\)"):
        drive_line.fork_phases([0.0], [0.0], np.inf)
    with pytest.raises(ValueError, match=r"first \(3,\), offsets \(2,\)"):
        drive_line.fork_phases(np.zeros((2, 1)), 0.0, np.zeros(3))
    with pytest.raises(ValueError, match="plane_offsets"):
        drive_line.fork_phases([0.0, 0.0, 0.0], [0.0, 0.0])
