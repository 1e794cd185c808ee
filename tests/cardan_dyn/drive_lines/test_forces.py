import numpy as np
import pytest

from cardan_dyn.drive_lines import LineForces


def forces(seed: int = 0, shape: tuple[int, ...] = (4, 5)) -> LineForces:
    rng = np.random.default_rng(seed)
    sizes = [(2, 3), (2, 3), (3, 3), (1, 3), (1, 3), (2, 3), (2,), (), ()]
    return LineForces(*(rng.uniform(-1, 1, (*shape, *size)) for size in sizes))


def test_components() -> None:
    found = forces()
    for side in ("in", "out"):
        moment = getattr(found, f"moment_{side}")
        torsion, bending = getattr(found, f"torsion_{side}"), getattr(found, f"bending_{side}")
        assert torsion**2 + bending**2 == pytest.approx(np.sum(moment**2, axis=-1))
    squares = found.bearing_axial**2 + found.bearing_radial**2
    assert squares == pytest.approx(np.sum(found.bearing_force**2, axis=-1))
    assert found.spline_friction.shape == found.spline_torque.shape == (4, 5, 1)
    squares = found.spline_torque**2 + found.spline_bending**2
    assert squares == pytest.approx(np.sum(found.spline_moment**2, axis=-1))
    assert found.centring**2 == pytest.approx(np.sum(found.centring_force**2, axis=-1))


def test_forces_are_linear() -> None:
    one, two = forces(0), forces(1)
    factor = np.random.default_rng(2).uniform(-1, 1, (4, 5))
    both = one.times(factor).plus(two)
    for name in LineForces._fields:
        first, second, found = (getattr(item, name) for item in (one, two, both))
        for index in np.ndindex(4, 5):
            assert found[index] == pytest.approx(factor[index] * first[index] + second[index])
