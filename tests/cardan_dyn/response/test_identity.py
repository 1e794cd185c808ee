"""Hashes of values, and which arguments of a scene the identity of its response depends on."""

from __future__ import annotations

import string
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.scenes import text, universal

import cardan_dyn as cd
from cardan_dyn.core.response.identity import digest, identity

modest = settings(max_examples=150, deadline=None, derandomize=True)

PLAIN = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False),
    st.text(st.sampled_from("ab;0159NonesilamTrue") | st.characters(), max_size=8),
)
VALUES = st.recursive(
    PLAIN,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.tuples(inner, inner)
        | st.dictionaries(st.text(string.printable, max_size=3), inner, max_size=3)
    ),
    max_leaves=12,
)


def canonical(value: object) -> object:
    """What two values have in common if they mean the same, with types that `==` ignores."""
    if isinstance(value, (list, tuple)):
        return ("sequence", *(canonical(item) for item in value))
    if isinstance(value, dict):
        return ("mapping", *sorted((key, canonical(item)) for key, item in value.items()))
    return (type(value).__name__, repr(value + 0.0 if isinstance(value, float) else value))


@pytest.mark.slow
@modest
@given(first=VALUES, second=VALUES)
def test_hashes_are_equal_exactly_where_values_are(first: object, second: object) -> None:
    assert (digest(first) == digest(second)) == (repr(canonical(first)) == repr(canonical(second)))


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (["a", "bc"], ["ab", "c"]),
        # Sizes come before contents, so that no text can pass for two.
        (["a", "sb"], ["as", "b"]),
        (["a", "b"], ["as1;b"]),
        (["a", ["b"]], [["a"], "b"]),
        ([[], []], [[[]]]),
        (1, 1.0),
        (1, "1"),
        (1, True),
        (None, "None"),
        ({"a": 1}, ["a", 1]),
        ([12, 3], [1, 23]),
        (np.zeros((2, 3)), np.zeros((3, 2))),
        (np.zeros(2), np.zeros(2, dtype=bool)),
        (np.array([1.0]), 1.0),
        (np.array([1.0, 2.0]), [1.0, 2.0]),
        (1.0, np.nextafter(1.0, 2.0)),
    ],
    ids=repr,
)
def test_values_that_look_alike_have_different_hashes(first: object, second: object) -> None:
    assert digest(first) != digest(second)


def test_values_that_mean_the_same_have_the_same_hash() -> None:
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest(-0.0) == digest(0.0)
    assert digest(np.array([-0.0, 1.0])) == digest(np.array([0.0, 1.0], dtype="f4"))
    assert digest((1, 2)) == digest([1, 2])
    assert digest(np.True_) == digest(True)
    transposed = np.arange(6.0).reshape(2, 3).T
    assert digest(transposed) == digest(transposed.copy())


def test_a_surrogate_in_a_name_has_a_hash() -> None:
    assert digest("\ud800") != digest("?")


@dataclass(frozen=True)
class Record:
    mass: float
    source: str = ""
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class OtherRecord:
    mass: float


def test_records_are_known_by_their_type_and_their_mechanical_fields() -> None:
    assert digest(Record(1.0)) == digest(Record(1.0, "file.urdf", ("no mass",)))
    assert digest(Record(1.0)) != digest(Record(2.0))
    assert digest(Record(1.0)) != digest(OtherRecord(1.0))


@pytest.mark.parametrize(
    "value", [object(), {1.0, 2.0}, b"x", [range(3)]], ids=["object", "set", "bytes", "range"]
)
def test_other_values_have_no_canonical_form(value: object) -> None:
    with pytest.raises(TypeError, match="no canonical form for"):
        digest(value)


PUSH = cd.Wrench(force=(0.0, 3.0, 10.0))


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        # Responses hold for any effort, and for any gravity that is not zero.
        ({"load": -7.0}, set()),
        ({"gravity": (1.0, 0.0, 0.0)}, set()),
        ({"gravity": None}, {"gravity"}),
        ({"beta": 0.6}, {"held"}),
        ({"near": {"bearing_in": 0.1}}, {"near"}),
        ({"outputs": ["pin_in"]}, {"outputs"}),
        ({"strict": True}, {"strict"}),
        ({"compliance": {"pin_in": np.ones(6)}}, {"compliance"}),
        ({"loads": {"bearing_out": -1.0, "pin_in": 1.0}}, {"joint loads"}),
        ({"loads": {"bearing_out": -1.0, "shaft_out": PUSH}}, {"link loads"}),
    ],
    ids=str,
)
def test_an_argument_changes_its_own_hash_alone(
    joint: cd.Mechanism, changes: dict[str, object], names: set[str]
) -> None:
    def scene(beta: float = 0.5, load: float = -1.0, **options: object) -> cd.Scene:
        arguments = {"gravity": (0.0, 0.0, -9.81), "loads": {"bearing_out": load}, **options}
        return cd.Scene(joint, drive="bearing_in", held={"joint_angle": beta}, **arguments)

    expected = identity(scene().solver.problem)
    changed = identity(scene(**changes).solver.problem)  # type: ignore[arg-type]
    assert {name for name in expected if expected[name] != changed[name]} == names
    assert set(changed) == set(expected)


def test_drives_held_joints_and_branches_are_told_apart(shaft: cd.Mechanism) -> None:
    def of(**options: object) -> dict[str, str]:
        return identity(cd.Scene(shaft, **options).solver.problem)

    held = {"joint_angle_1": 0.1, "joint_angle_2": 0.1}
    expected = of(drive="bearing_in", held=held)
    assert of(drive="bearing_out", held=held)["drives"] != expected["drives"]
    # Held joints are brought to their positions in their order.
    assert of(drive="bearing_in", held=dict(reversed(held.items())))["held"] != expected["held"]
    crank = cd.load("four_bar")
    branches = [
        identity(cd.Scene(crank, drive="crank_bearing", branch=branch).solver.problem)
        for branch in ("A", "B")
    ]
    assert branches[0]["branch"] != branches[1]["branch"]


def test_the_version_and_the_description_belong_to_it(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = identity(universal(joint, 0.5).solver.problem)
    urdf = text("universal_joint")
    commented = cd.load(urdf.replace("</robot>", "<!-- the same --></robot>"))
    assert identity(universal(commented, 0.5).solver.problem) == expected
    changed = cd.load(urdf.replace('<mass value="', '<mass value="1', 1))
    different = identity(universal(changed, 0.5).solver.problem)
    assert {name for name in expected if expected[name] != different[name]} == {"description"}
    monkeypatch.setattr("cardan_dyn.core.response.identity.__version__", "0.0.7")
    later = identity(universal(joint, 0.5).solver.problem)
    assert later == replace_version(expected, later["version of the package"])
    assert later != expected


def replace_version(entries: dict[str, str], version: str) -> dict[str, str]:
    return {**entries, "version of the package": version}
