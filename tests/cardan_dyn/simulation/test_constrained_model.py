"""The constrained model against Pinocchio on the mechanism's own model, and virtual work."""

from __future__ import annotations

import copy

import numpy as np
import pinocchio as pin
import pytest
from testkit.constrained import accelerations, closure_error
from testkit.linkages import coupling, four_bar, gears, loop
from testkit.many import in_one
from testkit.scaling import in_lengths
from testkit.scenes import forward_accelerations, universal

import cardan_dyn as cd
from cardan_dyn.core.dynamics.chain_tape import ChainTape
from cardan_dyn.core.tape import machine_is_at_hand
from cardan_dyn.motion.simulation.constrained_model import ConstrainedModel
from cardan_dyn.motion.simulation.turning_model import turning_model

GRAVITY = np.array([0.3, -9.81, 0.2])


def model_of(scene: cd.Scene, turn: cd.Sweep, held: tuple[str, ...] = ()) -> ConstrainedModel:
    mechanism = scene.mechanism
    rates = mechanism.coordinates.rates_of(held)
    return ConstrainedModel(mechanism, rates, scene.gravity, turn.motion.x[0])


def test_accelerations_are_those_of_pinocchio_by_hand(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive=["bearing_in", "joint_angle"], near={"joint_angle": 0.5})
    turn = scene.sweep([[1.0, 0.5], [2.5, 0.7]], [[3.0, 0.4], [-2.0, 0.1]])
    model = model_of(scene, turn)
    for sample in range(2):
        expected, *_ = forward_accelerations(joint, turn, sample, {"bearing_out": -2.0})
        efforts = np.zeros(model.mechanism.model.nv)
        efforts[joint.coordinates.named["bearing_out"].rate] = -2.0
        found = accelerations(model, turn.motion.x[sample], turn.motion.v[sample], efforts)
        # Both by proximal iterations; the oracle's end at residuals of 1e-14.
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("prescribed", [0.0, -3.0])
def test_what_is_prescribed_moves_as_it_is_told(joint: cd.Mechanism, prescribed: float) -> None:
    """Inverse dynamics of what comes out: free drives need no effort."""
    scene = cd.Scene(joint, drive=["bearing_in", "joint_angle"], gravity=GRAVITY)
    position, speed = [1.0, 0.5], [3.0, 0.4]
    turn = scene.sweep([position], [speed])
    model = model_of(scene, turn, ("joint_angle",))
    none = np.zeros(model.mechanism.model.nv)
    told = np.array([prescribed])
    a = accelerations(model, turn.motion.x[0], turn.motion.v[0], none, told)
    names = joint.coordinates.named
    assert a[names["joint_angle"].rate] == pytest.approx(prescribed, abs=1e-13)
    drives = [a[names[name].rate] for name in scene.drives]
    needed = scene.sweep([position], [speed], [drives]).drive_effort[0]
    # The effort of the joint angle carries the weight of the output's housing.
    assert abs(needed[0]) < 1e-13 * abs(needed[1])


def weightless_four_bar() -> cd.Mechanism:
    text = four_bar(loop("continuous"))
    start = text.index('<link name="coupler">')
    end = text.index("</link>", start) + len("</link>")
    return cd.load(text[:start] + '<link name="coupler"/>' + text[end:])


@pytest.mark.parametrize("is_light", [False, True])
def test_redundant_loops_and_weightless_links(is_light: bool) -> None:
    """A planar loop of hinges in space has three redundant rows."""
    mechanism = weightless_four_bar() if is_light else cd.load(four_bar(loop("continuous")))
    scene = cd.Scene(mechanism, drive="a", gravity=GRAVITY)
    turn = scene.sweep([0.7], [2.0])
    model = model_of(scene, turn)
    a = accelerations(model, turn.motion.x[0], turn.motion.v[0], np.zeros(model.mechanism.model.nv))
    drive = a[mechanism.coordinates.named["a"].rate]
    needed = scene.sweep([0.7, 0.7], 2.0, [drive, 0.0]).drive_effort
    assert abs(needed[0]) < 1e-13 * abs(needed[1])


def test_couplings_are_obeyed_by_rates_of_all_orders() -> None:
    mechanism = cd.load(gears(coupling("m", "a", "b", -0.5), coupling("n", "b", "c", 3.0), third=1))
    model = ConstrainedModel(mechanism, [], np.zeros(3), mechanism.coordinates.neutral())
    efforts = np.array([0.7, 0.0, 0.0])
    a = accelerations(model, np.zeros(3), np.zeros(3), efforts)
    # Inertias 0.025 about the axes, masses at the centres: ratios 1, -0.5, -1.5.
    ratios = np.array([1.0, -0.5, -1.5])
    np.testing.assert_allclose(a, 0.7 / (0.025 * ratios @ ratios) * ratios, rtol=1e-13)
    drifted = ratios * 40.0 + np.array([0.0, 1e-3, -2e-3])
    closed, rates = model.closed(drifted, ratios + np.array([0.1, 0.0, 0.0]))
    np.testing.assert_allclose(closed, closed[0] * ratios, rtol=1e-15)
    assert np.max(np.abs(closed - drifted)) < 2e-3
    np.testing.assert_allclose(rates, rates[0] * ratios, rtol=1e-14)


@pytest.mark.parametrize("name", ["double_shaft_z", "stewart_platform", "needle_drive"])
def test_loops_that_drifted_are_closed_near_by(name: str) -> None:
    mechanism = cd.load(name)
    closed = mechanism.coordinates.neutral()
    model = ConstrainedModel(mechanism, [], np.zeros(3), closed)
    random = np.random.default_rng(3)
    plain = turning_model(mechanism)
    drifted = pin.integrate(plain, closed, 1e-4 * random.normal(size=mechanism.model.nv))
    assert closure_error(model.mechanism, drifted) > 1e-5
    back, rates = model.closed(drifted, random.normal(size=mechanism.model.nv))
    # A few roundings of placements whose size is the characteristic length.
    assert closure_error(model.mechanism, back) < 2e-15
    assert np.max(np.abs(back - drifted)) < 0.1
    # The gap opens by the square of a small step alone.
    moved = [
        closure_error(model.mechanism, pin.integrate(plain, back, step * rates))
        for step in (1e-4, 1e-5)
    ]
    assert moved[1] < 0.02 * moved[0]


def test_what_is_held_is_not_moved(joint: cd.Mechanism) -> None:
    turn = universal(joint, 0.6).sweep([0.4], [2.0])
    scene = universal(joint, 0.6)
    model = model_of(scene, turn, ("joint_angle",))
    column = joint.coordinates.named["joint_angle"].column
    drifted = turn.motion.x[0] + 1e-4
    rest = np.zeros(joint.model.nv)
    closed, _ = model.closed(drifted, rest)
    assert closed[column] == pytest.approx(drifted[column], abs=1e-16)
    again = copy.deepcopy(model)
    np.testing.assert_array_equal(again.closed(drifted, rest)[0], closed)


def test_open_chains_have_nothing_to_close() -> None:
    text = '<robot name="r"><link name="g"/>' + four_bar("").split('<link name="ground"/>')[1]
    mechanism = cd.load(text.replace('"ground"', '"g"'))
    model = ConstrainedModel(mechanism, [], GRAVITY, mechanism.coordinates.neutral())
    x = np.array([0.3, 0.4, 0.5])
    assert all(np.array_equal(item, x) for item in model.closed(x, x))
    assert closure_error(model.mechanism, x) == 0.0


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e3, 1e6])
def test_the_size_of_a_mechanism_makes_no_difference(size: float) -> None:
    """Lengths and weights of a model ship: the same angles, at speeds by the root of the size."""
    plain = cd.load("slider_crank")
    scaled = cd.load(in_lengths(plain, size))
    ratios = []
    for mechanism, factor in ((plain, 1.0), (scaled, size)):
        gravity = factor * np.array([0.0, -9.81, 0.0])
        scene = cd.Scene(mechanism, drive="crank_bearing", gravity=gravity)
        turn = scene.sweep([0.7], [2.0])
        model = model_of(scene, turn)
        rest = np.zeros(mechanism.model.nv)
        a = accelerations(model, turn.motion.x[0], turn.motion.v[0], rest)
        ratios.append(a[mechanism.coordinates.named["crank_bearing"].rate])
    assert ratios[1] == pytest.approx(ratios[0], rel=1e-12)


def test_copies_side_by_side_move_like_one_alone() -> None:
    one = four_bar(loop("continuous"))
    alone, many = cd.load(one), cd.load(in_one(one, 9))
    scene = cd.Scene(alone, drive="a")
    turn = scene.sweep(np.linspace(0.2, 1.5, 9), np.linspace(-2.0, 3.0, 9))
    order = sorted("abcd", key=lambda name: alone.coordinates.named[name].rate)
    own = np.array([many.coordinates.rates_of([f"{name}_{k}" for name in order]) for k in range(9)])

    def together(rows: np.ndarray) -> np.ndarray:
        result = np.empty(36)
        result[own] = rows  # Without balls, columns and velocity coordinates are the same.
        return result

    x, v, efforts = turn.motion.x, turn.motion.v, np.linspace(-1.0, 1.0, 36).reshape(9, 4)
    model = ConstrainedModel(many, [], GRAVITY, together(x))
    assert len(model.chains) == 3
    a = accelerations(model, together(x), together(v), together(efforts))[own]
    for k in range(9):
        single = ConstrainedModel(alone, [], GRAVITY, x[k])
        expected = accelerations(single, x[k], v[k], efforts[k])
        np.testing.assert_allclose(a[k], expected, rtol=1e-11, atol=1e-11)
    # Told accelerations reach the right coordinates, whichever chain they are in.
    drives = sorted(many.coordinates.rates_of(["a_7", "a_1"]))
    model = ConstrainedModel(many, drives[::-1], GRAVITY, together(x))
    assert model.prescribed.tolist() == drives
    a = accelerations(model, together(x), together(v), None, np.array([5.0, -3.0]))
    assert a[drives] == pytest.approx([5.0, -3.0], abs=1e-12)
    drifted = together(x) + 1e-5 * np.sin(np.arange(36))
    back, rates = model.closed(drifted, together(v))
    assert closure_error(model.mechanism, drifted) > 1e-6
    assert closure_error(model.mechanism, back) < 2e-15
    assert back[drives].tolist() == drifted[drives].tolist()
    assert rates[drives].tolist() == together(v)[drives].tolist()


@pytest.mark.parametrize(("rtol", "closing"), [(1e-6, 3), (1e-10, 2)])
def test_programs_of_a_simulation(
    joint: cd.Mechanism, rtol: float, closing: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For what closes loops and speeds after a step two or three, one for the rates there.

    Those between are run by compiled steps.
    """
    made = []

    def counted(name: str) -> None:
        ask = getattr(ChainTape, name)

        def noted(*given: object, **options: object) -> object:
            made.append(name)
            return ask(*given, **options)

        monkeypatch.setattr(ChainTape, name, noted)

    counted("rates")
    counted("closer")
    scene = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.5}, outputs=[])
    spin = scene.simulate(2.0, speed=10.0, method="DOP853", rtol=rtol)
    steps = len(spin.time) - 1
    # Beside these the start is closed.
    within = 0 if machine_is_at_hand() else spin.evaluations
    assert steps < made.count("rates") <= within + steps + 10
    assert steps < made.count("closer") <= closing * steps + 5
    assert spin.evaluations > 10 * steps
    assert len(set(made)) == 2


def test_what_closures_are_like_elsewhere_is_looked_at_once(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    decomposed = []
    svd = np.linalg.svd

    def counted(*arguments: object, **options: object) -> object:
        decomposed.append(arguments)
        return svd(*arguments, **options)

    joint.kept.forget("closures elsewhere")
    counts, found = [], []
    for _ in range(2):
        scene = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.5}, outputs=[])
        with monkeypatch.context() as patched:
            patched.setattr(np.linalg, "svd", counted)
            decomposed.clear()
            spin = scene.simulate(0.1, speed=10.0, method="DOP853")
            counts.append(len(decomposed))
        found.append(spin.position)
    assert counts[0] > 0
    assert counts[1] == 0
    np.testing.assert_array_equal(*found)
