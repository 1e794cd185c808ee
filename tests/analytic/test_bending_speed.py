"""Critical bending speeds: makers' examples, and beams on springs by finite elements."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from cardan_dyn.analytic import bending_speed as bs
from cardan_dyn.analytic import shaft_design as sd
from cardan_dyn.analytic.limits import CRITICAL_CONSTANTS, LIMITS

RPM, INCH = np.pi / 30, 0.0254
TUBE = np.array([3.5, 3.26]) * INCH


def test_example_of_pss():
    """3.5 x 0.120 in, 60 in: 6251/min."""
    speed = bs.critical_speed_by_constant(*TUBE, 60 * INCH, CRITICAL_CONSTANTS["ae_7"].value)
    assert round(float(speed / RPM)) == 6251


def test_example_of_calcady():
    """3.5 x 0.083 in, 45 in, E = 30e6 psi, 0.283 lb/in^3: 11390/min, by the beam itself."""
    psi, pound = 4.4482216152605 / INCH**2, 0.45359237
    speed = sd.critical_speed(
        3.5 * INCH, 3.334 * INCH, 45 * INCH, 30e6 * psi, 0.283 * pound / INCH**3
    )
    # It rounds I to 1.302 in^4, the weight to 0.252 lb/in and g to 386.4 in/s^2.
    area, moment = np.pi / 4 * (3.5**2 - 3.334**2), np.pi / 64 * (3.5**4 - 3.334**4)
    rounding = np.sqrt(1.302 / moment * area * 0.283 / 0.252 * 386.4 / 386.0886)
    assert speed * rounding / RPM == pytest.approx(11390, abs=1.0)
    assert rounding == pytest.approx(1.0, abs=1.1e-3)


def test_constants_are_near_the_beam_of_steel():
    beam = sd.critical_speed(0.1, 0.09, 2.0)
    speeds = {
        name: bs.critical_speed_by_constant(0.1, 0.09, 2.0, constant.value) / beam
        for name, constant in CRITICAL_CONSTANTS.items()
    }
    expected = {"steel": 1.0, "elbe": 0.9929, "ae_7": 0.9806, "ims": 1.0004}
    assert speeds == pytest.approx(expected, abs=2e-4)


def test_greatest_length():
    share, constant = LIMITS["bending_speed_share"].value, CRITICAL_CONSTANTS["elbe"].value
    speed = 3000 * RPM
    length = bs.greatest_length(0.09, 0.083, speed, constant, share)
    critical = bs.critical_speed_by_constant(0.09, 0.083, length, constant)
    assert share * critical == pytest.approx(speed, rel=1e-14)
    # In mm and 1/min, as printed.
    printed = np.sqrt(share * 1.21e8 * np.hypot(90, 83) / 3000)
    assert 1e3 * length == pytest.approx(printed, rel=1e-13)


def beam_on_a_spring(softness, elements=12):
    """Greatest-period frequency of a beam with E I = mu = L = 1, by cubic finite elements."""
    h = 1.0 / elements
    corner = 4 * h * h
    bend = [[12, 6 * h, -12, 6 * h], [0, corner, -6 * h, corner / 2], [0, 0, 12, -6 * h]]
    bend = np.array([*bend, [0, 0, 0, corner]]) / h**3
    mass = [[156, 22 * h, 54, -13 * h], [0, corner, 13 * h, -0.75 * corner], [0, 0, 156, -22 * h]]
    mass = np.array([*mass, [0, 0, 0, corner]]) * h / 420
    size = 2 * (elements + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for i in range(elements):
        place = slice(2 * i, 2 * i + 4)
        K[place, place] += np.triu(bend) + np.triu(bend, 1).T
        M[place, place] += np.triu(mass) + np.triu(mass, 1).T
    K[-2, -2] += 1.0 / softness
    return np.sqrt(eigh(K[1:, 1:], M[1:, 1:], eigvals_only=True)[0])


@pytest.mark.parametrize("softness", [1e-4, 0.01, 0.1, 1.0, 30.0, 1e4])
def test_elastic_bearing_is_that_of_finite_elements(softness):
    value = bs.elastic_bearing_factor(softness)
    assert value == pytest.approx(beam_on_a_spring(softness) / np.pi**2, rel=2e-5)


def test_limits_of_the_elastic_bearing():
    assert bs.elastic_bearing_factor(0.0) == pytest.approx(1.0, rel=1e-15)
    # A rigid rod that swings about its other end: omega^2 = 3 k / (mu L).
    assert bs.elastic_bearing_factor(1e8) == pytest.approx(np.sqrt(3e-8) / np.pi**2, rel=1e-7)
    # First order in the softness: sin^2 at the end's share of the force, 1 - pi^2 s.
    assert bs.elastic_bearing_factor(1e-5) == pytest.approx(1 - np.pi**2 * 1e-5, abs=1e-7)
    factors = bs.elastic_bearing_factor(np.geomspace(1e-6, 1e6, 50))
    assert np.all(np.diff(factors) < 0)


def test_tube_on_an_elastic_bearing():
    D, d, L, k, rho = 0.09, 0.083, 1.4, 5e5, 7850.0
    bending = 2.1e11 * np.pi / 64 * (D**4 - d**4)
    line_mass = rho * np.pi / 4 * (D**2 - d**2)
    expected = beam_on_a_spring(bending / (k * L**3)) * np.sqrt(bending / (line_mass * L**4))
    assert bs.on_elastic_bearing(D, d, L, k) == pytest.approx(expected, rel=2e-5)
    assert bs.on_elastic_bearing(D, d, L, 1e15) == pytest.approx(sd.critical_speed(D, d, L))


def test_one_shaft_of_a_line_is_the_single_beam():
    """Rigid supports: pi^2 sqrt(E I / mu) / L^2. One on a spring: the characteristic equation."""
    EI, mu, L = 3.1e5, 9.7, 1.3
    rigid = np.pi**2 * np.sqrt(EI / mu) / L**2
    many = bs.line_bending(L, EI, mu, [0.0, 7.0])
    assert many.speed == pytest.approx(rigid, rel=3e-6)
    assert many.speeds[:4] / rigid == pytest.approx([1, 4, 9, 16], rel=1e-3)
    assert many.strain == pytest.approx(np.ones_like(many.strain))
    for softness in (1e-3, 0.1, 1.0, 100.0):
        k = EI / (softness * L**3)
        found = bs.line_bending(L, EI, mu, 0.0, [np.inf, k])
        assert found.speed == pytest.approx(rigid * bs.elastic_bearing_factor(softness), rel=3e-6)
        bearing = bs.LineBearing(0, L, k)
        same = bs.line_bending(L, EI, mu, 0.0, [np.inf, 0.0], [bearing])
        assert same.speed == pytest.approx(found.speed, rel=1e-9)
    assert found.kinetic[0] == pytest.approx([1.0])


def test_mesh_converges_with_the_fourth_power():
    rigid = np.pi**2 * np.sqrt(2.0)
    errors = [
        bs.line_bending(1.0, 2.0, 1.0, 0.0, elements=n).speed / rigid - 1 for n in (2, 4, 8, 16)
    ]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([4, 4, 4], abs=0.1)
    assert 0 < errors[-1] < 3e-6


def test_overhung_mass_and_hinged_shafts_in_closed_form():
    """A light shaft with a mass on its overhang: omega^2 = 3 E I / (m b^2 (a + b))."""
    a, b, EI, m = 0.8, 0.3, 1e5, 20.0
    light = bs.line_bending(
        a + b, EI, 1e-6, [0.0, m], [np.inf, 0.0], [bs.LineBearing(0, a, np.inf)]
    )
    assert light.speed == pytest.approx(np.sqrt(3 * EI / (m * b**2 * (a + b))), rel=1e-5)
    # On an elastic bearing the joint sinks by k's share of the lever as well.
    k = 4e5
    soft = bs.line_bending(a + b, EI, 1e-6, [0.0, m], [np.inf, 0.0], [bs.LineBearing(0, a, k)])
    give = b**2 * (a + b) / (3 * EI) + ((a + b) / a) ** 2 / k
    assert soft.speed == pytest.approx(1 / np.sqrt(m * give), rel=1e-5)
    assert soft.strain[0] == pytest.approx([b**2 * (a + b) / (3 * EI) / give], rel=1e-5)
    # With a second light shaft that hangs on that joint nothing changes; its mass adds a third.
    heavy, length, stiff = 6.0, 1.2, 1e9
    both = bs.line_bending(
        [a + b, length],
        [EI, stiff],
        [1e-6, heavy / length],
        [0.0, m, 0.0],
        bearings=[bs.LineBearing(0, a, k)],
    )
    assert both.speed == pytest.approx(1 / np.sqrt((m + heavy / 3) * give), rel=1e-4)
    assert both.kinetic[0] == pytest.approx([0.0, heavy / 3 / (m + heavy / 3)], abs=1e-4)


def test_overhanging_beam_by_its_characteristic_equation():
    """Hinged at 0 and at a, free at L: the determinant of both spans' solutions vanishes."""
    a, L = 0.7, 1.0

    def determinant(z):
        # Span 1: A sin zx + B sinh zx, 0 at a. Span 2, from the free end: C (cos + cosh) + D (sin +
        # sinh) of z (L - x), 0 at a; slope and curvature are continuous.
        c, s, ch, sh = (f(z * a) for f in (np.cos, np.sin, np.cosh, np.sinh))
        b = L - a
        C, S, CH, SH = (f(z * b) for f in (np.cos, np.sin, np.cosh, np.sinh))
        rows = [
            [s, sh, 0, 0],
            [0, 0, C + CH, S + SH],
            [c, ch, SH - S, C + CH],
            [-s, sh, C - CH, S - SH],
        ]
        return np.linalg.det(rows)

    grid = np.linspace(0.5, 6.0, 2000)
    values = np.array([determinant(z) for z in grid])
    at = np.flatnonzero(np.diff(np.sign(values)))[0]
    z = brentq(determinant, grid[at], grid[at + 1])
    found = bs.line_bending(L, 1.0, 1.0, 0.0, [np.inf, 0.0], [bs.LineBearing(0, a, np.inf)])
    assert found.speed == pytest.approx(z**2, rel=1e-5)


@pytest.mark.parametrize("seed", range(20))
def test_line_lies_between_dunkerley_and_rayleigh(seed):
    """Static influence of unit forces on the line gives both bounds of the lowest frequency."""
    rng = np.random.default_rng(seed)
    count = rng.integers(1, 5)
    L, EI = rng.uniform(0.5, 2.0, count), 10.0 ** rng.uniform(4, 6, count)
    mu, m = rng.uniform(3.0, 30.0, count), rng.uniform(0.0, 20.0, count + 1)
    centre = [
        bs.LineBearing(k, float(rng.uniform(0.6, 0.95) * L[k]), float(10 ** rng.uniform(5, 8)))
        for k in range(count - 1)
    ]
    found = bs.line_bending(L, EI, mu, m, bearings=centre)
    flexible, masses = lumped_line(L, EI, mu, m, centre)
    lowest = np.sqrt(np.sum(flexible.diagonal() * masses))
    assert found.speed >= (1 - 2e-3) / lowest  # Dunkerley; the lumps are 1/60 of a shaft.
    shape = flexible @ masses
    upper = np.sqrt((masses @ shape) / (masses @ shape**2))
    assert found.speed <= (1 + 2e-3) * upper  # Rayleigh, with the deflection of the weight.
    assert found.kinetic.min() >= 0 and found.kinetic.sum(axis=1).max() <= 1 + 1e-12


def lumped_line(L, EI, mu, m, centre, lumps=60):
    """Flexibility between lumps of all shafts and joints, by the force method, and their masses.

    Each shaft is a beam on its two ends, whose deflection between them is that of Macaulay; joints
    and bearings move as springs and the bending of shafts over their bearings let them.
    """
    joints = len(L) + 1
    places = [(np.arange(lumps) + 0.5) * length / lumps for length in L]
    columns = [(k, x) for k, of_shaft in enumerate(places) for x in of_shaft]
    columns += [(k, 0.0) for k in range(1, joints - 1)]
    masses = np.array([mu[k] * L[k] / lumps for k, of in enumerate(places) for _ in of])
    masses = np.append(masses, m[1:-1])

    def beam(k, x, y):
        low, high = min(x, y), max(x, y)
        return low * (L[k] - high) * (L[k] ** 2 - low**2 - (L[k] - high) ** 2) / (6 * EI[k] * L[k])

    # Unknown bearing forces R and joint deflections u: each inner joint is in balance.
    size = len(centre) + joints - 2
    A, rights, outs = np.zeros((size, size)), [], []
    for i, one in enumerate(centre):
        for j, other in enumerate(centre):
            if one.shaft == other.shaft:
                A[i, j] += beam(one.shaft, one.distance, other.distance)
        A[i, i] += 1.0 / one.stiffness
        t = one.distance / L[one.shaft]
        for joint, share in ((one.shaft, 1 - t), (one.shaft + 1, t)):
            if 0 < joint < joints - 1:
                A[i, len(centre) + joint - 1] -= share
                A[len(centre) + joint - 1, i] -= share
    for k, x in columns:
        known, out, t = np.zeros(size), np.zeros(size), x / L[k]
        for i, one in enumerate(centre):
            if one.shaft == k:
                known[i] = out[i] = -beam(k, x, one.distance)
        for joint, share in ((k, 1 - t), (k + 1, t)):
            if 0 < joint < joints - 1:
                out[len(centre) + joint - 1] = share
                known[len(centre) + joint - 1] = share
        rights.append(known)
        outs.append(out)
    rights, outs = np.array(rights).T, np.array(outs)
    # Rows of bearings: own bending by R + R / k - deflection of the chord = deflection by the load.
    rights[: len(centre)] *= -1.0
    rights[len(centre) :] *= -1.0
    solved = np.linalg.solve(A, rights) if size else np.zeros((0, len(columns)))
    own = np.array([[beam(k, x, y) if k == j else 0.0 for j, y in columns] for k, x in columns])
    return own + outs @ solved, masses


def test_lines_that_are_not_held_are_refused():
    for call, message in (
        (lambda: bs.line_bending([1.0, 1.0], 1.0, [1.0] * 3, 0.0), "do not match"),
        (
            lambda: bs.line_bending(1.0, 1.0, 1.0, 0.0, bearings=[bs.LineBearing(1, 0.5, 1.0)]),
            "one of 1 shafts",
        ),
        (lambda: bs.line_bending([1.0, 1.0], [1.0, 1.0], [1.0, 1.0], 0.0), "do not hold it"),
        (lambda: bs.line_bending(1.0, 1.0, 1.0, 0.0, [np.inf, 0.0]), "do not hold it"),
        (lambda: bs.line_bending(1.0, 1.0, 1.0, 0.0, [np.inf, -1.0]), "ends"),
        (lambda: bs.line_bending(1.0, 1.0, 1.0, -1.0), "joint_masses"),
        (
            lambda: bs.line_bending(1.0, 1.0, 1.0, 0.0, np.inf, [bs.LineBearing(0, 2.0, 1.0)]),
            "bearing = ",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            call()


def test_shapes_nan_and_bad_arguments():
    assert bs.on_elastic_bearing(np.full((3, 1), 0.1), 0.0, 1.0, [1e5, 1e6]).shape == (3, 2)
    assert np.isnan(bs.elastic_bearing_factor([0.1, np.nan])).tolist() == [False, True]
    assert isinstance(bs.elastic_bearing_factor(0.1), float)
    for call, message in (
        (lambda: bs.elastic_bearing_factor(-1.0), r"softness = -1\.0"),
        (lambda: bs.on_elastic_bearing(0.1, 0.0, 1.0, 0.0), r"stiffness = 0\.0"),
        (lambda: bs.greatest_length(0.1, 0.2, 1.0, 1e4), "inner_diameter"),
        (lambda: bs.critical_speed_by_constant(0.1, 0.0, 1.0, -1.0), "constant"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
