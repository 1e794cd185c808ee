"""What a scene's arguments become."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.problem import arguments


@pytest.fixture(scope="module")
def mechanism() -> cd.Mechanism:
    return cd.load("universal_joint")


def test_no_mechanism() -> None:
    with pytest.raises(cd.ArgumentError, match=r"needs a mechanism from load\(\), not str"):
        arguments.checked("universal_joint")  # type: ignore[arg-type]


def test_what_is_taken_where_nothing_is_given(mechanism: cd.Mechanism) -> None:
    problem = arguments.checked(mechanism, drive="bearing_in", held={"joint_angle": 1})
    assert problem.drives == ("bearing_in",)
    assert dict(problem.held) == {"joint_angle": 1.0}
    assert problem.gravity.tolist() == [0.0, 0.0, 0.0]
    assert problem.outputs == tuple(mechanism.joints) and problem.all_outputs
    assert (problem.branch, problem.strict) == ("A", False)


def test_a_joint_is_driven_once_or_held(mechanism: cd.Mechanism) -> None:
    for drive, held in ((["bearing_in"] * 2, {}), (["joint_angle"], {"joint_angle": 0.1})):
        with pytest.raises(cd.ArgumentError, match="driven, free or held, and named once"):
            arguments.checked(mechanism, drive=drive, held=held)
    with pytest.raises(cd.MobilityError, match="at least one coordinate"):
        arguments.checked(mechanism, drive=[])


def test_outputs_are_named_once(mechanism: cd.Mechanism) -> None:
    names = ["pin_out", "bearing_in", "pin_out"]
    assert arguments.wanted_outputs(mechanism, names) == ("pin_out", "bearing_in")
    with pytest.raises(cd.ModelError, match="no joint 'shaft_out'"):
        arguments.wanted_outputs(mechanism, ["shaft_out"])


def test_compliances_are_matrices(mechanism: cd.Mechanism) -> None:
    values = np.arange(6.0)
    found = arguments.compliances(mechanism, {"pin_in": values})
    np.testing.assert_array_equal(found["pin_in"], np.diag(values))
    # Rounding of a symmetric matrix is no asymmetry, and that of a zero eigenvalue not negative.
    matrix = np.ones((6, 6))
    matrix[0, 1] += 1e-15
    np.testing.assert_array_equal(
        arguments.compliances(mechanism, {"pin_in": matrix})["pin_in"], matrix
    )
    matrix[0, 1] += 1e-9
    with pytest.raises(cd.ArgumentError, match="not symmetric"):
        arguments.compliances(mechanism, {"pin_in": matrix})
    values[2] = -1e-9
    with pytest.raises(cd.ArgumentError, match="negative in some direction"):
        arguments.compliances(mechanism, {"pin_in": values})
    huge = arguments.compliances(mechanism, {"pin_in": np.full(6, 1e300)})
    np.testing.assert_array_equal(huge["pin_in"], np.diag(np.full(6, 1e300)))


def test_loads_at_joints_and_on_links_are_told_apart(mechanism: cd.Mechanism) -> None:
    wrench = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    given = {"bearing_out": -2.0, "shaft_out": wrench, "shaft_in": cd.Wrench(moment=[1.0, 0, 0])}
    efforts, wrenches = arguments.split_loads(mechanism, given)
    assert list(efforts) == ["bearing_out"] and float(efforts["bearing_out"]) == -2.0
    assert list(wrenches) == ["shaft_out", "shaft_in"]
    np.testing.assert_array_equal(wrenches["shaft_out"].force, wrench[:3])
    np.testing.assert_array_equal(wrenches["shaft_out"].moment, wrench[3:])
    np.testing.assert_array_equal(wrenches["shaft_in"].force, [0.0, 0.0, 0.0])
    body, placement = mechanism.link("shaft_out")
    assert wrenches["shaft_out"].body == body - 1
    np.testing.assert_array_equal(wrenches["shaft_out"].translation, placement.translation)


def test_loads_on_nothing(mechanism: cd.Mechanism) -> None:
    for name, message in (("nothing", "no joint or link has this name"), ("base", "fixed to the")):
        with pytest.raises(cd.ArgumentError, match=message):
            arguments.split_loads(mechanism, {name: np.ones(6)})


def test_positions_too_far_to_be_followed_to() -> None:
    crank = cd.load("slider_crank")
    length = crank.characteristic_length
    assert arguments.held_positions(crank, {"piston_guide": 5999.0 * length}, "held")
    with pytest.raises(cd.ArgumentError, match="6000 times the length"):
        arguments.held_positions(crank, {"piston_guide": -6001.0 * length}, "held")
