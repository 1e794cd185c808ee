"""The class `Response`: inertia and ratios, checks of its arguments, and what cannot be changed."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio as pin
import pytest
from testkit.linkages import coupling, gears
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.response import response as response_module

POSITIONS = np.linspace(-3.0, 9.0, 40)
NOT_NUMBERS = ("a", 1j, [None], ["a"], [1j], {}, {"a": 1.0}, object(), np.array("a"), True, b"x")


@pytest.fixture(scope="module")
def response(joint: cd.Mechanism) -> cd.Response:
    return universal(joint, 0.5).response()


@pytest.fixture(scope="module")
def on_range(joint: cd.Mechanism) -> cd.Response:
    return universal(joint, 0.5).response(1e-9, interval=(-0.5, 1.5))


def drive_line(outputs: list[str]) -> cd.Scene:
    mechanism = cd.load("drive_line")
    held = {name: 0.2 for name in mechanism.joints if name.startswith("joint_angle")}
    return cd.Scene(mechanism, drive="bearing_in", held=held, outputs=outputs)


def test_attributes_and_text(response: cd.Response, on_range: cd.Response) -> None:
    assert response.columns == ("speed²", "acceleration", "bearing_out")
    assert response.sample_count == 128
    assert response.error == response.proof.error
    assert response.interval == (-np.inf, np.inf)
    assert on_range.interval == pytest.approx((-0.5, 1.5), abs=1e-15)
    assert repr(response) == (
        "<Response of 'universal_joint': 128 samples, columns speed², acceleration, bearing_out, "
        f"error {response.error:.1e}>"
    )


def test_the_inertia_of_two_wheels_is_constant() -> None:
    """Wheels of 0.025 kg·m², the second at -2.5 times the speed of the first."""
    scene = cd.Scene(cd.load(gears(coupling("mesh", "a", "b", -2.5))), drive="a", loads={"b": 7.0})
    response = scene.response()
    expected = np.full((2, 3), 0.025 * (1.0 + 2.5**2))
    np.testing.assert_allclose(response.inertia(np.arange(6.0).reshape(2, 3)), expected, rtol=1e-14)
    np.testing.assert_allclose(response.inertia_derivative([0.0, 1.0]), 0.0, atol=1e-15)
    np.testing.assert_allclose(response.ratio("b", [0.0, 1.0]), [-2.5, -2.5], rtol=1e-14)


def test_a_mechanism_without_masses_has_no_inertia() -> None:
    urdf = """<robot name="massless"><link name="ground"/><link name="wheel"/>
      <joint name="a" type="continuous"><parent link="ground"/><child link="wheel"/>
      <axis xyz="0 0 1"/></joint></robot>"""
    response = cd.Scene(cd.load(urdf), drive="a").response()
    assert response.columns == ()
    np.testing.assert_array_equal(response.inertia([0.0, 1.0]), [0.0, 0.0])
    np.testing.assert_array_equal(response.inertia_derivative(0.5), 0.0)


@pytest.mark.parametrize("output", ["bearing_out", "pin_2_in"])
def test_an_inertia_that_the_outputs_leave_out_is_refused(output: str) -> None:
    response = drive_line([output]).response()
    with pytest.raises(cd.ModelError, match="was not asked for"):
        _ = response.sweep(0.3).drive_effort
    message = f"add the driven joint to the outputs, which are: {output}"
    for call in (response.inertia, response.inertia_derivative):
        with pytest.raises(cd.ModelError, match=message):
            call(0.3)


def test_positions_beyond_a_range_are_refused(on_range: cd.Response) -> None:
    message = "the response holds for positions from -0.5 to 1.5"
    for call in (on_range.sweep, on_range.inertia, on_range.inertia_derivative):
        for position in (1.5001, -0.5001, [0.0, 9.0]):
            with pytest.raises(cd.ArgumentError, match=message):
                call(position)
        # Ends that carry the rounding of a user's own computation are within it.
        call([-0.5 - 1e-13, 1.5 + 1e-13])
    with pytest.raises(cd.ArgumentError, match="the drive does not turn through"):
        on_range.uniform(10)


def test_equal_steps_broadcast_with_speeds_and_loads(response: cd.Response) -> None:
    speeds, loads = np.array([[0.0], [40.0], [-9.0]]), np.array([[-1.0], [0.0], [5.0]])
    grid = response.uniform(12, speeds, loads={"bearing_out": loads})
    positions = 2.0 * np.pi * np.arange(12) / 12
    assert grid.shape == (3, 12)
    np.testing.assert_allclose(grid.position, np.tile(positions, (3, 1)), rtol=1e-15)
    rows = response.sweep(positions, speeds, loads={"bearing_out": loads})
    np.testing.assert_allclose(grid["pin_out"].moment, rows["pin_out"].moment, atol=1e-12)
    assert grid.motion.v.shape == rows.motion.v.shape
    np.testing.assert_allclose(grid.motion.v, rows.motion.v, rtol=1e-13, atol=1e-13)


def test_shapes_that_do_not_broadcast_are_named(response: cd.Response) -> None:
    message = r"shapes do not broadcast: position \(2,\), speed \(3,\); for a grid"
    with pytest.raises(cd.ArgumentError, match=message):
        response.sweep([0.0, 1.0], np.zeros(3))


def test_the_greatest_number_of_operating_points(
    response: cd.Response, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(response_module, "_GREATEST_COUNT", 100)
    assert response.uniform(100).shape == (100,)
    message = (
        "101 operating points take 8.08e-7 GB of memory per component of a wrench; at most 100 are "
        "evaluated at once"
    )
    with pytest.raises(cd.ArgumentError, match=message):
        response.uniform(101)


def test_the_residuals_of_a_sweep_allow_for_cancelled_inertial_terms(
    response: cd.Response,
) -> None:
    still, moving = response.sweep(0.3), response.sweep(0.3, 5.0)
    assert still.balance_residual == response.proof.balance_residual
    assert still.condition[0] == response.proof.condition
    assert moving.condition[0] == response.proof.condition * response.proof.cancellation
    # A tenth of eps for each time that inertial terms exceed what is left of them.
    hidden = 0.1 * np.finfo(float).eps * (response.proof.cancellation - 1.0)
    assert moving.balance_residual - still.balance_residual == pytest.approx(hidden, rel=1e-6)


def test_inertia_and_its_slope(joint: cd.Mechanism) -> None:
    """Kinetic energy of the joint at unit speed is half the inertia."""
    scene = universal(joint, 0.8, load=0.0)
    response = scene.response()
    positions = np.linspace(0.0, 3.0, 7)
    turn = scene.sweep(positions, speed=1.0)
    data = joint.model.createData()
    energy = [
        pin.computeKineticEnergy(joint.model, data, q, v)
        for q, v in zip(turn.motion.q, turn.motion.v, strict=True)
    ]
    np.testing.assert_allclose(response.inertia(positions), 2.0 * np.array(energy), rtol=1e-12)
    step = 1e-3
    slope = (response.inertia(positions + step) - response.inertia(positions - step)) / (2 * step)
    np.testing.assert_allclose(response.inertia_derivative(positions), slope, atol=1e-6)
    np.testing.assert_allclose(
        turn.drive_effort, 0.5 * response.inertia_derivative(positions), atol=1e-13
    )
    np.testing.assert_allclose(
        response.ratio("bearing_out", positions), turn.motion.ratio("bearing_out"), rtol=1e-13
    )


def test_ratios_are_known_where_the_scene_has_a_load_per_sample(joint: cd.Mechanism) -> None:
    loads = {"bearing_out": np.linspace(-1.0, -2.0, 40)}
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5}, loads=loads)
    expected = scene.sweep(POSITIONS).motion.ratio("bearing_out")
    response = scene.response()
    np.testing.assert_allclose(response.ratio("bearing_out", POSITIONS), expected, rtol=1e-13)
    np.testing.assert_allclose(response.ratio("bearing_out", 0.0), [1.0 / np.cos(0.5)], rtol=1e-13)
    for wrong in ("x", [], np.zeros((2, 2)), [None], 1j):
        with pytest.raises(cd.ArgumentError):
            response.ratio("bearing_out", wrong)  # type: ignore[arg-type]
    with pytest.raises(cd.ModelError, match="no joint"):
        response.ratio("nothing", 0.0)


@pytest.mark.parametrize("mechanism", ["drive line", "wheels"])
def test_joints_that_no_output_needs_have_no_ratio_and_no_motion(mechanism: str) -> None:
    train = gears(coupling("ab", "a", "b", -2.0), coupling("ac", "a", "c", -3.0), third=True)
    wheels = cd.Scene(cd.load(train), drive="a", outputs=["b"])
    scene = wheels if mechanism == "wheels" else drive_line(["bearing_in"])
    unsolved = scene.sweep(POSITIONS).motion
    response = scene.response()
    evaluated = response.sweep(POSITIONS).motion
    for name in scene.mechanism.coordinates.columns:
        ratio = response.ratio(name, POSITIONS)
        np.testing.assert_allclose(ratio, unsolved.ratio(name), atol=1e-12)
        np.testing.assert_allclose(evaluated.velocity(name), unsolved.velocity(name), atol=1e-12)
    # Of the wheels one is not solved; of the drive line everything is.
    assert np.isnan(evaluated.q).any() == (mechanism == "wheels")


@pytest.mark.parametrize("wrong", NOT_NUMBERS, ids=lambda item: type(item).__name__)
def test_what_is_no_number_is_an_argument_error(
    joint: cd.Mechanism, response: cd.Response, wrong: object
) -> None:
    scene = universal(joint, 0.5)
    for call in (
        lambda: scene.response(wrong),  # type: ignore[arg-type]
        lambda: scene.response(interval=(wrong, 1.0)),  # type: ignore[arg-type]
        lambda: scene.response(interval=(0.0, wrong)),  # type: ignore[arg-type]
        lambda: response.sweep(wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, 0.0, wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, gravity=wrong),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, loads={"bearing_out": wrong}),  # type: ignore[dict-item]
        lambda: response.uniform(wrong),  # type: ignore[arg-type]
        lambda: response.inertia(wrong),  # type: ignore[arg-type]
        lambda: response.inertia_derivative(wrong),  # type: ignore[arg-type]
    ):
        with pytest.raises(cd.ArgumentError):
            call()


def test_numbers_of_a_wrong_shape_or_size_are_argument_errors(
    joint: cd.Mechanism, response: cd.Response
) -> None:
    scene = universal(joint, 0.5)
    for call in (
        lambda: scene.response([1e-9]),  # type: ignore[arg-type]
        lambda: scene.response(np.nan),
        lambda: scene.response(interval=([0.0], [1.0])),  # type: ignore[arg-type]
        lambda: scene.response(interval=(1.0, 1.0 + 1e-15)),
        lambda: scene.response(interval=(0.0, np.inf)),
        lambda: response.sweep([]),
        lambda: response.sweep(0.0, []),
        lambda: response.sweep([0.0, np.nan]),
        lambda: response.sweep(0.0, loads=[1.0]),  # type: ignore[arg-type]
        lambda: response.sweep(0.0, loads={3: 1.0}),  # type: ignore[dict-item]
        lambda: response.sweep(0.0, loads={"bearing_out": []}),
        lambda: response.sweep(0.0, gravity=[1.0, 2.0]),
        lambda: response.sweep(0.0, gravity=9.81),
        lambda: response.sweep(0.0, 1e200),
        lambda: response.uniform(2.5),  # type: ignore[arg-type]
        lambda: response.uniform(0),
        lambda: response.uniform(-3),
    ):
        with pytest.raises(cd.ArgumentError):
            call()


def test_more_operating_points_than_memory_holds_are_refused(response: cd.Response) -> None:
    for count in (10**12, 2**63, 10**400):
        with pytest.raises(cd.ArgumentError, match="GB of memory per component"):
            response.uniform(count)
    many = np.linspace(0.0, 1.0, 10**5)
    with pytest.raises(cd.ArgumentError, match="80 GB of memory per component"):
        response.sweep(many[:, None], many)


def test_a_response_can_be_pickled_and_copied_and_not_be_changed(joint: cd.Mechanism) -> None:
    push = cd.Wrench(force=(0.0, 3.0, 10.0), moment=(1.0, 0.0, 0.0))
    scene = cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.4},
        loads={"bearing_out": -2.0, "shaft_out": push},
        gravity=(0.0, 0.0, -9.81),
    )
    response = scene.response()
    first = response.sweep(POSITIONS, 3.0, loads={"bearing_out": 4.0})
    for again in (copy.deepcopy(response), pickle.loads(pickle.dumps(response))):
        second = again.sweep(POSITIONS, 3.0, loads={"bearing_out": 4.0})
        np.testing.assert_array_equal(first["pin_out"].moment, second["pin_out"].moment)
        np.testing.assert_array_equal(first.drive_effort, second.drive_effort)
        assert again.proof == response.proof
        for array in (
            again._data[0].series.values,
            again._data[0].zero,
            again._data[0].constant,
            again._data[0].unique,
        ):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
    with pytest.raises(AttributeError):
        response.proof = None  # type: ignore[misc, assignment]


def test_wrenches_of_a_response_cannot_be_written_to(joint: cd.Mechanism) -> None:
    response = universal(joint, 0.5).response()
    for sweep in (response.sweep(POSITIONS, 3.0), response.uniform(12)):
        wrench = sweep["bearing_in"]
        for array in (
            wrench.moment,
            wrench.force,
            wrench.torsion,
            sweep.drive_effort,
            sweep.holding_effort["joint_angle"],
            sweep.condition,
            sweep.unique,
        ):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 7.0
    for array in (response.inertia(POSITIONS), response.inertia_derivative(POSITIONS)):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 7.0


@pytest.mark.parametrize("drive", ["bearing_in", ["bearing_in"]], ids=["name", "list"])
def test_samples_have_the_shape_that_they_have_in_a_sweep(
    joint: cd.Mechanism, drive: str | list[str]
) -> None:
    """The last axis of what drives have counts the drives where a list names them."""
    scene = cd.Scene(joint, drive=drive, held={"joint_angle": 0.5}, loads={"bearing_out": -1.0})
    column = np.linspace(0.0, 1.0, 4)[:, None]
    for speed in (0.0, np.ones((4, 1))):
        for found in (scene, scene.response()):
            sweep = found.sweep(column, speed)
            assert sweep.shape == sweep.drive_effort.shape
            assert sweep.shape == ((4,) if isinstance(drive, list) else (4, 1))
    family = scene.responses({"joint_angle": [[0.4], [0.5]]})
    assert family.sweep(column[:2]).shape == ((2, 2) if isinstance(drive, list) else (2, 1))
