"""Wrong arguments get an ArgumentError that says what is expected, and nothing else."""

from __future__ import annotations

import copy
import decimal
import warnings
from collections import OrderedDict
from collections.abc import Callable
from operator import attrgetter
from types import MappingProxyType

import numpy as np
import pytest
from testkit.exploding import Exploding, ExplodingMapping

import cardan_dyn as cd
from cardan_dyn import figures
from cardan_dyn.core.problem import arguments

pytestmark = pytest.mark.usefixtures("loaded_once")


def scene(**options: object) -> cd.Scene:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.4}, **options}
    return cd.Scene(cd.load("universal_joint"), **given)


NO_MAPPINGS = {
    "list": ["x"],
    "pairs": [("joint_angle", 0.4)],
    "empty list": [],
    "number": -100,
    "string": "joint_angle",
    "array": np.zeros(3),
    "array of names": np.array(["joint_angle"]),
    "false": False,
    "exploding": Exploding(),
    "exploding items": ExplodingMapping(joint_angle=0.4),
    "number as key": {1: 0.4},
    "none as key": {None: 0.4},
    "bytes as key": {b"joint_angle": 0.4},
    "tuple as key": {("joint_angle",): 0.4},
}


@pytest.mark.parametrize("role", ["held", "loads", "compliance", "near"])
@pytest.mark.parametrize("value", NO_MAPPINGS.values(), ids=NO_MAPPINGS.keys())
def test_no_mapping(role: str, value: object) -> None:
    expected = f"{role} is .*a mapping of names|a key of {role} is .*expected a string"
    with pytest.raises(cd.ArgumentError, match=expected):
        scene(**{role: value})


@pytest.mark.parametrize("kind", [dict, OrderedDict, lambda value: MappingProxyType(dict(value))])
def test_any_mapping(kind: Callable[[object], object]) -> None:
    held = kind({np.str_("joint_angle"): np.float32(0.5)})
    made = scene(held=held, loads=None, near=None, compliance=None)
    assert made.held == {"joint_angle": 0.5} and type(next(iter(made.held))) is str


NO_NUMBERS = {
    "none": None,
    "bool": True,
    "string": "1",
    "complex": 1j,
    "complex array": np.array([1.0 + 1j]),
    "object array": np.array([1.0, None], object),
    "numbers as objects": np.array([1.0, 2.0], object),
    "bools": np.array([True, False]),
    "not implemented": NotImplemented,
    "ellipsis": Ellipsis,
    "decimal": decimal.Decimal("0.1"),
    "bytes": bytearray(b"a"),
    "set": {1.0},
    "mapping": {"x": 1.0},
    "generator": (value for value in [1.0]),
    "ragged": [[1.0, 2.0], [3.0]],
    "mixed": [1.0, "x"],
    "integer of many digits": 10**400,
    "date": np.datetime64("2001-01-01"),
    "duration": np.timedelta64(3, "s"),
    "record": np.array([(1, 2.0)], dtype="i4,f8"),
    "masked": np.ma.masked_array([1.0, 2.0], [False, True]),
    "exploding": Exploding(),
    "function": len,
    "nan": np.nan,
    "inf": [0.0, np.inf],
    "beyond doubles": np.longdouble("1e4000"),
    "an array beyond doubles": np.array(["1e4000", "1"], np.longdouble),
}


@pytest.mark.parametrize("value", NO_NUMBERS.values(), ids=NO_NUMBERS.keys())
def test_no_numbers(value: object) -> None:
    turning = scene()
    attempts: dict[str, Callable[[], object]] = {
        r"held\['joint_angle'\]": lambda: scene(held={"joint_angle": value}),
        r"near\['pin_in'\]": lambda: scene(near={"pin_in": value}),
        r"loads\['bearing_out'\]": lambda: scene(loads={"bearing_out": value}),
        r"loads\['cross'\]": lambda: scene(loads={"cross": value}),
        r"loads\['cross'\].force": lambda: scene(loads={"cross": cd.Wrench(force=value)}),
        r"loads\['cross'\].moment": lambda: scene(loads={"cross": cd.Wrench(moment=value)}),
        r"compliance\['bearing_out'\]": lambda: scene(compliance={"bearing_out": value}),
        "position": lambda: turning.sweep(value),
        "speed": lambda: turning.sweep([0.0, 1.0], speed=value),
        "acceleration": lambda: turning.sweep([0.0, 1.0], acceleration=value),
        "position ": lambda: turning.assemble(value),
    }
    if value is not None:  # No gravity is zero gravity.
        attempts["gravity"] = lambda: scene(gravity=value)
    for name, attempt in attempts.items():
        with pytest.raises(cd.ArgumentError, match=f"^{name.strip()} is not") as caught:
            attempt()
        assert "array of real numbers" in str(caught.value) or "finite" in str(caught.value)
        assert len(str(caught.value)) < 400


def test_numbers_of_every_kind() -> None:
    for value in (1, np.int8(1), np.uint64(1), np.float16(1), np.longdouble(1), np.array(1.0)):
        assert scene(held={"joint_angle": value}).held == {"joint_angle": 1.0}
    given = np.array([1.0, 2.0])
    kept = arguments.numbers("x", given)
    given[0] = 3.0
    assert kept[0] == 1.0


@pytest.mark.parametrize("role", ["drive", "outputs"])
@pytest.mark.parametrize(
    "value",
    [3, [None], {"bearing_in"}, b"bearing_in", np.array([1.0]), Exploding(), {"bearing_in": 1}],
    ids=str,
)
def test_a_scene_takes_names(role: str, value: object) -> None:
    with pytest.raises(
        cd.ArgumentError, match=rf"^{role}(\[\d+\])? is .*expected a|{role} is not a"
    ):
        scene(**{role: value})


@pytest.mark.parametrize(
    "value",
    [
        "bearing_in",
        ["bearing_in"],
        ("bearing_in",),
        np.array("bearing_in"),
        np.array(["bearing_in"]),
        np.array(["bearing_in"], object),
        np.str_("bearing_in"),
        {"bearing_in": 1.0}.keys(),
    ],
    ids=str,
)
def test_any_names(value: object) -> None:
    assert arguments.names("drive", value) == ("bearing_in",)
    assert scene(drive=value).drives == ("bearing_in",)
    assert scene(outputs=value).outputs == ("bearing_in",)


def test_names_from_a_generator() -> None:
    found = scene(outputs=(name for name in ("bearing_out", "bearing_in", "bearing_out")))
    assert found.outputs == ("bearing_out", "bearing_in")
    assert scene(outputs=[]).outputs == ()


def test_unknown_names() -> None:
    for options in (
        {"drive": "x"},
        {"outputs": ["x"]},
        {"held": {"x": 1.0}},
        {"near": {"x": 1.0}},
        {"compliance": {"x": [1.0] * 6}},
        {"drive": "\ud800"},
    ):
        with pytest.raises(cd.ModelError, match=r"no joint '(x|\\ud800)'; joints: .*bearing_in"):
            scene(**options)
    with pytest.raises(cd.ArgumentError, match=r"loads\['x'\]: no joint or link has this name"):
        scene(loads={"x": 1.0})


@pytest.mark.parametrize("value", [None, 0, 1, "yes", [], np.array([True]), Exploding()], ids=repr)
def test_strict_is_true_or_false(value: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"^strict is .*, expected True or False"):
        scene(strict=value)
    assert arguments.flag("strict", np.bool_(True)) is True


@pytest.mark.parametrize("value", [None, 0, b"A", ["A"], np.array(["A"]), Exploding()], ids=repr)
def test_branch_is_a_string(value: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"^branch is .*, expected a string"):
        scene(branch=value)


@pytest.mark.parametrize(
    "frame", [None, 3, "Link", np.array(["link", "world"]), Exploding()], ids=str
)
def test_frames_of_wrenches(frame: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"loads\['cross'\]: frame .* is unknown; frames: l"):
        scene(loads={"cross": cd.Wrench((1.0, 0.0, 0.0), frame=frame)})


@pytest.mark.parametrize("shape", [(), (2,), (0, 3), (3, 0)])
def test_shapes_of_wrenches(shape: tuple[int, ...]) -> None:
    with pytest.raises(
        cd.ArgumentError, match=r"force has shape .*, expected \(3,\) or \(\.\.\., 3\)"
    ):
        scene(loads={"cross": cd.Wrench(np.zeros(shape))})


@pytest.mark.parametrize("role", ["held", "near"])
@pytest.mark.parametrize("angle", [1e9, -1e12, 1e300, 6284.0])
def test_angles_of_very_many_turns(role: str, angle: float) -> None:
    """They would be followed through all of them."""
    name = "joint_angle" if role == "held" else "pin_in"
    with pytest.raises(
        cd.ArgumentError, match=rf"{role}\['{name}'\] .* turns; positions count whole"
    ):
        scene(**{role: {name: angle}})


def test_angles_of_some_turns() -> None:
    near, far = (
        cd.Scene(cd.load("four_bar"), drive="crank_bearing", near={"crank_bearing": angle})
        for angle in (0.4, 0.4 + 6.0 * np.pi)
    )
    ratios = [made.sweep([0.5]).motion.ratio("rocker_bearing") for made in (near, far)]
    np.testing.assert_allclose(ratios[1], ratios[0], rtol=1e-12)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.eye(6) * 1e200 + np.diag([1e200] * 5, 1), "not symmetric"),
        ([1e308] * 5 + [-1e308], "negative in some direction"),
        (-np.eye(6), "negative in some direction"),
        (np.zeros((5, 5)), "expected 6 values or a symmetric"),
        (1.0, "expected 6 values"),
        ([], "expected 6 values"),
    ],
)
def test_compliances(value: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        scene(compliance={"bearing_out": value})


def test_drives_of_ratios() -> None:
    motion = scene().sweep([0.0, 1.0]).motion
    for drive in (1, -1, 10**30, None, True, "pin_in", "no joint", 0.0, [0], Exploding()):
        with pytest.raises(cd.ArgumentError, match=r"no drive .*; drives: 0 \(bearing_in\)"):
            motion.ratio("bearing_out", drive)
    for drive in (0, np.int64(0)):
        np.testing.assert_array_equal(
            motion.ratio("bearing_out", drive), motion.ratio("bearing_out", "bearing_in")
        )


@pytest.mark.parametrize("name", ["x", "turns", "v", "a", "velocity_ratios.values"])
def test_motions_cannot_be_written_to(name: str) -> None:
    motion = scene().sweep([0.0, 1.0]).motion
    for same in (motion, copy.copy(motion)):
        with pytest.raises(ValueError, match="read-only"):
            attrgetter(name)(same)[...] = 0.0


@pytest.mark.parametrize("wrong", [np.array(["time", "position"]), np.array([1.0, 2.0]), [[1.0]]])
def test_arrays_in_place_of_words_are_refused(wrong: object) -> None:
    turn = cd.Scene(cd.load("slider_crank"), drive="crank_bearing").sweep([0.1, 0.2])
    with pytest.raises(cd.ArgumentError, match=r"Actuator: of is .* it is position, time"):
        cd.Actuator("crank_bearing", 1.0, of=wrong)  # type: ignore[arg-type]
    for draw in (figures.over_angle, figures.moment_polar):
        with pytest.raises(cd.CardanError):
            draw(turn, 3)  # type: ignore[arg-type]
        with pytest.raises(cd.CardanError):
            draw(turn, "crank_pin", [wrong])  # type: ignore[list-item]
    scene = cd.Scene(cd.load("slider_crank"), free="crank_bearing")
    with pytest.raises(cd.CardanError):
        scene.simulate(0.01, position=0.1, speed=0.1, events=np.array(None))


@pytest.mark.parametrize("great", [1e300, -1e160, 1e155, 1e20])
def test_speeds_at_which_numbers_overflow_or_lose_their_digits_are_refused(great: float) -> None:
    scene = cd.Scene(cd.load("slider_crank"), free="crank_bearing", gravity=(0.0, -9.81, 0.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(cd.ArgumentError, match="simulate a shorter time or a lower speed"):
            scene.simulate(1.0, position=0.1, speed=great)
        with pytest.raises(cd.CardanError):
            scene.replace(loads={"crank_bearing": 1e160}).equilibrium(0.1)
