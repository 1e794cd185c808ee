"""Forces as efforts, against virtual work by Pinocchio on the mechanism's own model."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest
from testkit.element_work import generalised
from testkit.linkages import four_bar, loop

import cardan_dyn as cd
from cardan_dyn.core.elements.element_forces import Acted, LinkWrench
from cardan_dyn.core.problem.arguments import split_loads
from cardan_dyn.motion.simulation.forces import Forces, Named, StateNames, state_function
from cardan_dyn.motion.simulation.turning_model import turning_model

MECHANISM = cd.load(four_bar(loop("continuous")))
SIZE = MECHANISM.coordinates.size
X, V = np.zeros((1, SIZE)), np.zeros((1, SIZE))
for _name, _position, _speed in (("a", 0.3, 1.0), ("b", -0.7, 2.0), ("d", 0.9, 3.0)):
    X[0, MECHANISM.coordinates.named[_name].column] = _position
    V[0, MECHANISM.coordinates.named[_name].rate] = _speed
PUSH = np.array([1.0, -2.0, 0.5, 0.1, 0.2, 3.0])


def forces(loads: dict[str, Any], functions: dict[str, Any] | None = None) -> Forces:
    given = functions or {}
    prepared = {name: state_function(name, value) for name, value in given.items()}
    return Forces(MECHANISM, *split_loads(MECHANISM, loads), prepared)


def by_pinocchio(force: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """Efforts of a wrench on the coupler, in world axes."""
    none = np.zeros(1)
    wrench = LinkWrench("coupler", force[None, :], moment[None, :])
    return generalised(MECHANISM, X, Acted(np.zeros((1, SIZE)), [wrench], none, none, none))[0]


def efforts(acting: Forces, time: float = 0.0) -> np.ndarray:
    model = turning_model(MECHANISM)
    return acting.efforts(model, model.createData(), time, X[0], V[0])


def test_wrenches_in_axes_of_the_world_and_of_the_link() -> None:
    world = forces({"coupler": cd.Wrench(PUSH[:3], PUSH[3:], "world")})
    np.testing.assert_allclose(efforts(world), by_pinocchio(PUSH[:3], PUSH[3:]), atol=1e-14)
    turn = 0.3 - 0.7
    c, s = math.cos(turn), math.sin(turn)
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    expected = by_pinocchio(axes @ PUSH[:3], axes @ PUSH[3:])
    for link in (forces({"coupler": PUSH}), forces({}, {"coupler": lambda t: PUSH})):
        np.testing.assert_allclose(efforts(link), expected, atol=1e-14)


def test_functions_take_the_place_of_constants() -> None:
    acting = forces({"d": 5.0, "a": 1.0}, {"d": lambda t, x, v: t * x["a"] - v["b"]})
    rates = [MECHANISM.coordinates.named[name].rate for name in "abd"]
    np.testing.assert_allclose(efforts(acting, 2.0)[rates], [1.0, 0.0, 0.6 - 2.0])
    assert not acting.is_constant
    assert not acting.does_no_work
    joints, links = acting.sampled(np.array([2.0, 3.0]), np.repeat(X, 2, 0), np.repeat(V, 2, 0))
    np.testing.assert_allclose(joints["d"], [-1.4, -1.1])
    assert joints["a"] == 1.0
    assert links == {}


def test_what_is_sampled_is_what_acts() -> None:
    acting = forces({}, {"coupler": lambda t: t * PUSH})
    _, links = acting.sampled(np.array([1.0, 3.0]), np.repeat(X, 2, 0), np.repeat(V, 2, 0))
    np.testing.assert_allclose(links["coupler"].force, [PUSH[:3], 3.0 * PUSH[:3]])
    rows = acting.all_efforts(np.array([1.0, 3.0]), np.repeat(X, 2, 0), V.repeat(2, 0))
    np.testing.assert_allclose(rows[1], 3.0 * rows[0])
    np.testing.assert_allclose(rows[0], efforts(acting, 1.0))


def test_what_they_are_is_known() -> None:
    assert forces({}).does_no_work
    assert forces({}).is_constant
    assert forces({"a": 1.0}).is_constant
    assert not forces({"a": 1.0}).does_no_work
    damped = Forces(MECHANISM, {}, {}, {}, [cd.JointSpring("a", 1.0, damping=0.1)])
    assert not damped.is_constant
    assert damped.with_elements(()).does_no_work
    sprung = Forces(MECHANISM, {}, {}, {}, [cd.JointSpring("a", 1.0)])
    assert sprung.is_constant
    assert sprung.does_no_work


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("a", math.nan, r"loads\['a'\] returned nan at time 2 s"),
        ("a", "x", r"loads\['a'\] returned 'x' at time 2 s, expected a number"),
        ("a", [1.0, 2.0], r"loads\['a'\] returned .* at time 2 s, expected a number"),
        ("coupler", 3.0, r"at time 2 s: loads\['coupler'\]"),
        ("coupler", np.full(6, np.inf), "at time 2 s: .*not finite"),
        ("coupler", np.zeros((2, 6)), "several wrenches"),
    ],
)
def test_functions_return_loads(name: str, value: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        efforts(forces({}, {name: lambda t: value}), 2.0)


def test_failing_functions_are_named_with_the_time() -> None:
    def broken(time: float) -> float:
        raise OSError("disk")

    with pytest.raises(cd.ArgumentError, match="a failed at time 3 s: OSError: disk") as caught:
        efforts(forces({}, {"a": broken}), 3.0)
    assert isinstance(caught.value.__cause__, OSError)


@pytest.mark.parametrize("function", [lambda: 0.0, math.sin, lambda t, scale=2.0: t])
def test_functions_of_time_alone(function: Any) -> None:
    called = state_function("f", function)
    names = Named({}, np.zeros(0))
    if function is not math.sin and function.__code__.co_argcount == 0:
        with pytest.raises(cd.ArgumentError, match="f failed at time 1 s: TypeError"):
            called(1.0, names, names)
    else:
        assert called(1.0, names, names) == function(1.0)


def test_functions_of_all_three() -> None:
    for function in (lambda t, x, v: (t, x["q"], v["q"]), lambda *all: (all[0], 5.0, 6.0)):
        x, v = Named({"q": 0}, np.array([5.0])), Named({"q": 0}, np.array([6.0]))
        assert state_function("f", function)(1.0, x, v) == (1.0, 5.0, 6.0)
    with pytest.raises(cd.ArgumentError, match="f: a function of 2 arguments"):
        state_function("f", lambda t, x: 0.0)


def test_functions_of_modules_can_be_pickled() -> None:
    again = pickle.loads(pickle.dumps(state_function("f", math.sin)))
    names = Named({}, np.zeros(0))
    assert again(1.0, names, names) == math.sin(1.0)


def test_names_of_states() -> None:
    names = StateNames(MECHANISM)
    positions, speeds = names.of(X[0], V[0])
    assert dict(positions)["a"] == 0.3
    assert len(positions) == len(list(positions))
    assert speeds["d"] == 3.0
