"""Design variables: gradients, what limits a search, and designs that cannot be built."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import Bounds, least_squares, minimize

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

PHI = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
LENGTHS = {
    "origin:crank_pin.x": ("-10 mm", "10 mm"),
    "origin:rocker_pin.predecessor.x": (-0.02, 0.04),
    "origin:rocker_pin.successor.x": ("-2 cm", "4 cm"),
}
LEVER = """<robot name="lever"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
 <inertia ixx="0" iyy="0" izz="0"/></inertial></link>
<joint name="axle" type="continuous"><parent link="base"/><child link="arm"/>
 <axis xyz="0 -1 0"/></joint></robot>"""


WIDE = dict.fromkeys(LENGTHS, (-0.08, 0.2))


@pytest.fixture
def linkage() -> cd.DesignVariables:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held=dict.fromkeys(LENGTHS, 0.0))
    return cd.DesignVariables(lambda values: scene.sweep(PHI, speed=20.0, held=values), LENGTHS)


def lever(bounds: dict[str, Any]) -> cd.DesignVariables:
    """Return a lever of 2 kg at 0.5 m, at rest in the horizontal, whose load varies."""
    scene = cd.Scene(cd.load(LEVER), drive="axle", gravity=(0.0, 0.0, -10.0))

    def solve(values: Any) -> cd.Sweep:
        held = {name: value for name, value in values.items() if name.startswith("origin:")}
        given = scene.replace(held=held) if held else scene
        return given.sweep(0.0, loads={"axle": values["load:axle"]})

    return cd.DesignVariables(solve, bounds)


def effort(variables: cd.DesignVariables) -> Any:
    return variables.quantity(
        lambda sweep: sweep.drive_effort[0], lambda sweep, by: by.drive_effort[0]
    )


def square(variables: cd.DesignVariables) -> Any:
    return variables.quantity(
        lambda sweep: sweep.drive_effort[0] ** 2,
        lambda sweep, by: 2.0 * sweep.drive_effort[0] * by.drive_effort[0],
    )


def test_values_are_in_si_units_between_the_bounds(linkage: cd.DesignVariables) -> None:
    np.testing.assert_allclose(linkage.low, [-0.01, -0.02, -0.02], rtol=1e-15)
    np.testing.assert_allclose(linkage.high, [0.01, 0.04, 0.04], rtol=1e-15)
    values = linkage.values([0.5, 1.0, 0.0, 17.0])
    assert list(values) == list(LENGTHS)
    np.testing.assert_allclose(list(values.values()), [0.0, 0.04, -0.02], atol=1e-17)
    turned = cd.DesignVariables(lambda values: None, {"joint_angle": ("0 deg", "180 deg")})  # type: ignore[arg-type, return-value]
    np.testing.assert_allclose(turned.high, np.pi, rtol=1e-15)


def test_gradients_are_those_of_the_values(linkage: cd.DesignVariables) -> None:
    number = linkage.quantity(
        lambda sweep: np.mean(sweep.drive_effort**2),
        lambda sweep, by: 2.0 * np.mean(sweep.drive_effort * by.drive_effort),
    )
    array = linkage.quantity(
        lambda sweep: sweep["crank_pin"].force[:, :2],
        lambda sweep, by: by["crank_pin"].force[:, :2],
    )
    x, step = np.array([0.3, 0.4, 0.7]), 1e-3
    assert array(x).shape == (24, 2)
    assert array.jac(x).shape == (24, 2, 3)
    assert number.jac(x).shape == (3,)
    for quantity in (number, array):
        for k, unit in enumerate(np.eye(3)):
            at = [quantity(x + count * step * unit) for count in (-2, -1, 1, 2)]
            differences = (8.0 * (at[2] - at[1]) - (at[3] - at[0])) / (12.0 * step)
            found = quantity.jac(x)[..., k]
            size = np.abs(found).max()
            np.testing.assert_allclose(found, differences, rtol=0.0, atol=1e-8 * size)


def test_quantities_of_a_design_share_its_sweep() -> None:
    asked = []
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held=dict.fromkeys(LENGTHS, 0.0))

    def solve(values: Any) -> cd.Sweep:
        asked.append(values)
        return scene.sweep(PHI, held=values)

    variables = cd.DesignVariables(solve, LENGTHS)
    first, second = effort(variables), square(variables)
    for x in ([0.5, 0.5, 0.5], [0.5, 0.5, 0.6]):
        first(x), first.jac(x), second(x), second.jac([*x, 3.0])
    assert len(asked) == 2


def test_multipliers_of_bounds_and_constraints_are_those_of_the_closed_form() -> None:
    """The effort is 10 N·m less the load: its square wants 10, and is let have less."""
    variables = lever({"load:axle": (-4.0, 6.0)})
    objective, bounds = square(variables), Bounds(*variables.bounds)
    best = minimize(objective, [0.2], jac=objective.jac, bounds=bounds)
    review = variables.review(best)
    np.testing.assert_allclose(review.values["load:axle"], 6.0, rtol=1e-12)
    # d/dx (10 - L)² at L = 6 N·m, in units of the width of 10 N·m.
    np.testing.assert_allclose(review.limits["load:axle greatest"], 80.0, rtol=1e-9)
    assert list(review.limits) == ["load:axle greatest"]
    assert review.optimality < 1e-9
    assert review.idle == ()

    load = effort(variables)
    constraints = [{"type": "ineq", "fun": lambda x: load(x) - 7.0, "jac": lambda x: load.jac(x)}]
    given: dict[str, Any] = {"jac": objective.jac, "bounds": bounds, "constraints": constraints}
    best = minimize(objective, [0.2], method="SLSQP", **given)
    review = variables.review(best, constraints)
    np.testing.assert_allclose(review.values["load:axle"], 3.0, rtol=1e-7)
    np.testing.assert_allclose(review.limits["constraints[0][0]"], 14.0, rtol=1e-6)
    assert review.violation < 1e-9
    # Solvers end a little before the limit that they lean on, or behind it.
    for apart in (1e-3, -1e-3):
        best.x = np.array([0.7 - 0.1 * apart])
        best.jac = objective.jac(best.x)
        review = variables.review(best, constraints)
        np.testing.assert_allclose(
            review.limits["constraints[0][0]"], 14.0 + 2.0 * apart, rtol=1e-9
        )
        np.testing.assert_allclose(review.optimality, 14e-3 * (apart > 0.0), rtol=1e-3, atol=1e-9)
        nearer = variables.review(best, constraints, within=1e-6)
        assert bool(nearer.limits) == (apart < 0.0)
    # Half of the way, nothing has been reached, and all of the gradient is left.
    best.x, best.jac = np.array([0.5]), objective.jac([0.5])
    review = variables.review(best, constraints)
    assert review.limits == {}
    np.testing.assert_allclose(review.optimality, 90.0 * 2.0, rtol=1e-9)


def test_what_cannot_be_met_is_told() -> None:
    variables = lever({"load:axle": (-4.0, 6.0)})
    objective, load = square(variables), effort(variables)
    constraints = [{"type": "eq", "fun": lambda x: load(x) - 1.0, "jac": lambda x: load.jac(x)}]
    given: dict[str, Any] = {"jac": objective.jac, "bounds": Bounds(*variables.bounds)}
    best = minimize(objective, [0.2], method="SLSQP", constraints=constraints, **given)
    assert not best.success
    np.testing.assert_allclose(variables.review(best, constraints).violation, 3.0, rtol=1e-6)


def test_variables_without_influence_are_named() -> None:
    """A lever that stands in the world feels no place across its motion."""
    variables = lever({"load:axle": (-4.0, 6.0), "origin:axle.y": (-0.1, 0.1)})
    objective = square(variables)
    best = minimize(objective, [0.2, 0.3], jac=objective.jac, bounds=Bounds(*variables.bounds))
    assert variables.review(best).idle == ("origin:axle.y",)


def test_least_squares_meet_a_linkage_again() -> None:
    """The motion of the rocker tells all lengths but their common unit, which the coupler gives."""
    names = dict.fromkeys(["origin:crank_pin.x", "origin:rocker_pin.successor.x"], (-0.02, 0.02))
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held=dict.fromkeys(names, 0.0))
    wanted = dict(zip(names, (0.004, 0.011), strict=True))
    angle = scene.sweep(PHI, held=wanted).motion.position("rocker_bearing")
    variables = cd.DesignVariables(lambda values: scene.sweep(PHI, held=values), names)
    miss = variables.quantity(
        lambda sweep: sweep.motion.position("rocker_bearing") - angle,
        lambda sweep, by: by.motion.position("rocker_bearing"),
    )
    bounds = Bounds(*variables.bounds)
    best = least_squares(miss, [0.1, 0.9], jac=miss.jac, bounds=bounds, xtol=1e-15, gtol=1e-15)
    review = variables.review(best)
    np.testing.assert_allclose([*review.values.values()], [*wanted.values()], rtol=0.0, atol=1e-12)
    assert review.limits == {}


WEIGHTED = """<robot name="bar"><link name="base"/>
<link name="crank"><inertial><origin xyz="0.03 0 0"/><mass value="1.5"/>
 <inertia ixx="0.002" iyy="0.002" izz="0.002"/></inertial></link>
<link name="coupler"><inertial><origin xyz="0.2 0.01 0"/><mass value="1.6"/>
 <inertia ixx="0.029" iyy="0.029" izz="0.029"/></inertial></link>
<link name="rocker"><inertial><origin xyz="0.09 0 0"/><mass value="2.3"/>
 <inertia ixx="0.006" iyy="0.006" izz="0.006"/></inertial></link>
<link name="first"><inertial><mass value="2"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>
<link name="second"><inertial><mass value="3"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>
<joint name="A" type="continuous"><parent link="base"/><child link="crank"/><axis xyz="0 0 1"/>
</joint>
<joint name="B" type="continuous"><parent link="crank"/><child link="coupler"/>
 <origin xyz="0.08 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="E" type="continuous"><parent link="base"/><child link="rocker"/>
 <origin xyz="0.47 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="first" type="fixed"><parent link="crank"/><child link="first"/></joint>
<joint name="second" type="fixed"><parent link="rocker"/><child link="second"/></joint>
<loop name="C" type="continuous"><axis xyz="0 0 1"/>
 <predecessor link="coupler"><origin xyz="0.4 0 0"/></predecessor>
 <successor link="rocker"><origin xyz="0.25 0 0"/></successor></loop></robot>"""


@pytest.mark.parametrize(
    ("names", "places", "left"),
    [
        (("first", "second"), (-0.109 + 0.0032j, -0.407 - 0.01j), 0.0),
        (("first",), (-0.174105930339937 + 0.00102736483543j,), 29.88166898036828),
    ],
)
def test_counterweights_of_a_four_bar_from_random_starts(
    names: tuple[str, ...], places: tuple[complex, ...], left: float
) -> None:
    """Static moments in the axes of crank and rocker, and the shaking force that is left [N].

    Both weights balance it (Berkof and Lowen, 1969); that of the crank alone is -⟨F e^(-iφ)⟩/ω².
    """
    axes = [f"origin:{name}.{axis}" for name in names for axis in "xy"]
    given: dict[str, Any] = {"drive": "A", "near": {"E": 1.9}}
    scene = cd.Scene(cd.load(WEIGHTED), held=dict.fromkeys(axes, 0.0), **given)
    turn = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)

    def shaking(sweep: cd.Sweep, of: Any = None) -> Any:
        found = of or sweep
        turned = (sweep.rotation(name)[:, :2, :2] @ found[name].force[:, :2, None] for name in "AE")
        return np.ravel(sum(turned))

    variables = cd.DesignVariables(
        lambda values: scene.sweep(turn, speed=20.0, held=values), dict.fromkeys(axes, (-0.3, 0.3))
    )
    force, bounds = variables.quantity(shaking, shaking), Bounds(*variables.bounds)
    masses = {"first": 2.0, "second": 3.0}
    (start,) = variables.starts(1, seed=len(names))
    best = least_squares(force, start, jac=force.jac, bounds=bounds, xtol=1e-15)
    found = variables.values(best.x)
    for name, place in zip(names, places, strict=True):
        moment = masses[name] * (found[f"origin:{name}.x"] + 1j * found[f"origin:{name}.y"])
        assert moment == pytest.approx(place, abs=1e-9)
    assert np.sqrt(2.0 * np.mean(best.fun**2)) == pytest.approx(left, abs=1e-9)
    assert variables.review(best).limits == {}


def test_phases_of_three_joints_are_angles_of_a_hyperbolic_triangle() -> None:
    """Joints of 10, 12 and 8° run evenly at phases of 78.9629961402° and 71.9820749640°."""
    bends, shafts, joints, place, slope = (10.0, 12.0, 8.0, 0.0), "", "", 0.0 + 0.0j, 0.0
    for k, bend in enumerate(bends):
        shafts += f"""<link name="shaft_{k}"/><joint name="bearing_{k}" type="continuous">
 <parent link="base"/><child link="shaft_{k}"/><axis xyz="1 0 0"/>
 <origin xyz="{place.real} {place.imag} 0" rpy="0 0 {slope}"/></joint>"""
        place, slope = place + np.exp(1j * slope), slope + np.radians(bend)
    for k in (1, 2, 3):
        joints += f"""<loop name="joint_{k}" type="universal">
 <axis xyz="0 1 0"/><axis2 xyz="0 0 1"/>
 <predecessor link="shaft_{k - 1}"><origin xyz="1 0 0"/></predecessor>
 <successor link="shaft_{k}"/></loop>"""
    line = cd.load(f'<robot name="line"><link name="base"/>{shafts}{joints}</robot>')
    phases = ["origin:joint_2.predecessor.roll", "origin:joint_3.predecessor.roll"]
    scene = cd.Scene(line, drive="bearing_0", held=dict.fromkeys(phases, 0.0), outputs=[])
    turn = np.linspace(0.0, np.pi, 36, endpoint=False)
    variables = cd.DesignVariables(
        lambda values: scene.sweep(turn, held=values), dict.fromkeys(phases, ("0 deg", "90 deg"))
    )
    uneven = variables.quantity(
        lambda sweep: sweep.motion.ratio("bearing_3") - 1.0,
        lambda sweep, by: by.motion.ratio("bearing_3"),
    )
    given: dict[str, Any] = {"jac": uneven.jac, "bounds": Bounds(*variables.bounds)}
    (start,) = variables.starts(1, seed=3)
    best = least_squares(uneven, start, xtol=1e-15, ftol=1e-15, gtol=1e-15, **given)
    found = np.degrees([*variables.values(best.x).values()])
    np.testing.assert_allclose(found, [78.9629961402, 71.9820749640], rtol=0.0, atol=1e-9)
    assert np.abs(best.fun).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("method", ["SLSQP", "trust-constr"])
def test_designs_that_cannot_be_driven_are_too_long_a_step(method: str) -> None:
    """Its first steps lead to couplers too short for the crank to turn through."""
    name = "origin:rocker_pin.predecessor.x"
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held={name: 0.0})
    variables = cd.DesignVariables(
        lambda values: scene.sweep(PHI, held=values), {name: (-0.3, 0.02)}
    )
    missed = []
    swing = variables.quantity(
        lambda sweep: 1e3 * (np.ptp(sweep.motion.position("rocker_bearing")) - 0.7) ** 2,
        lambda sweep, by: (
            2e3 * (np.ptp(sweep.motion.position("rocker_bearing")) - 0.7) * _of_ends(sweep, by)
        ),
    )

    def counted(x: Any) -> float:
        missed.append(np.isinf(swing(x)))
        return float(swing(x))

    bounds = Bounds(*variables.bounds)
    best = minimize(counted, [0.95], jac=swing.jac, bounds=bounds, method=method)
    assert any(missed)
    assert best.fun < 1e-6


def _of_ends(sweep: cd.Sweep, by: cd.Derivative) -> float:
    """Return how the range of the rocker changes."""
    angle, change = (item.motion.position("rocker_bearing") for item in (sweep, by))
    return float(change[np.argmax(angle)] - change[np.argmin(angle)])


@pytest.mark.slow
def test_a_search_that_begins_where_nothing_closes_says_why() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held=dict.fromkeys(LENGTHS, 0.0))
    wide = cd.DesignVariables(lambda values: scene.sweep(PHI, held=values), WIDE)
    closed, open_by = np.full(3, 80.0 / 280.0), np.array([0.9, 0.1, 0.1])
    array = wide.quantity(lambda sweep: sweep.drive_effort, lambda sweep, by: by.drive_effort)
    with pytest.raises(cd.AssemblyError):
        array(open_by)
    assert array(closed).shape == PHI.shape
    assert np.all(np.isinf(array(open_by)))
    assert array(open_by).shape == PHI.shape
    np.testing.assert_array_equal(array.jac(open_by), np.zeros((24, 3)))
    found = list(wide.starts(8, seed=3))
    assert 2 <= len(found) < 8
    assert all(np.all(np.isfinite(array(x))) for x in found)
    assert not np.array_equal(found[0], found[1])


def test_starts_end_where_nothing_closes() -> None:
    tried = []

    def never(values: Any) -> cd.Sweep:
        tried.append(values)
        raise cd.AssemblyError("the loops cannot be closed", residual=1.0)

    with pytest.raises(cd.AssemblyError, match="cannot be closed"):
        next(cd.DesignVariables(never, WIDE).starts(5))
    assert len(tried) == 5
    assert len({tuple(values.values()) for values in tried}) == 5


def test_what_is_not_finite_is_refused(linkage: cd.DesignVariables) -> None:
    across = linkage.quantity(
        lambda sweep: sweep["crank_pin"].force[:, 2], lambda sweep, by: by["crank_pin"].force[:, 2]
    )
    x = [0.5, 0.5, 0.5]
    assert np.all(np.isfinite(across(x)))
    with pytest.raises(cd.ArgumentError, match="not unique are none"):
        across.jac(x)
    nan = linkage.quantity(lambda sweep: np.nan, lambda sweep, by: 0.0)
    with pytest.raises(cd.ArgumentError, match=r"not finite at .*crank_pin"):
        nan(x)


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({}, "bounds name no variable"),
        ({"a": 1.0}, r"bounds\['a'\] is 1.0, expected \(least, greatest\)"),
        ({"a": (1.0, 1.0)}, "1 is not less than 1"),
        ({"a": ("5 mm", "1 mm")}, "0.005 is not less than 0.001"),
        ({"a": (0.0, np.nan)}, "is not finite"),
        ({"a": ("1 furlong", "2 furlong")}, "no number with a unit"),
        ([("a", (0.0, 1.0))], "bounds"),
        ({"mass:*": (0.0, 1.0)}, "name each by itself"),
    ],
)
def test_false_bounds_are_refused(bounds: Any, message: str) -> None:
    with pytest.raises(cd.CardanError, match=message):
        cd.DesignVariables(lambda values: None, bounds)  # type: ignore[arg-type, return-value]


def test_unknown_names_are_refused_by_who_knows_them() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    wrong = cd.DesignVariables(lambda values: scene.sweep(PHI), {"mass:couplr": (1.0, 2.0)})
    with pytest.raises(cd.ModelError, match="did you mean 'coupler'"):
        effort(wrong).jac([0.5])


def test_false_designs_are_refused(linkage: cd.DesignVariables) -> None:
    mean = linkage.quantity(lambda sweep: sweep.drive_effort.mean(), lambda sweep, by: 0.0)
    for x in ([0.5, 0.5], [], 0.5):
        with pytest.raises(cd.ArgumentError, match="fewer than the 3 names"):
            mean(x)
    every = linkage.quantity(
        lambda sweep: sweep.drive_effort, lambda sweep, by: by.drive_effort.sum()
    )
    with pytest.raises(cd.ArgumentError, match=r"has the shape \(\), whereas .* is \(24,\)"):
        every.jac([0.5] * 3)
    nothing = cd.DesignVariables(lambda values: None, {"a": (0.0, 1.0)})  # type: ignore[arg-type, return-value]
    with pytest.raises(cd.ArgumentError, match="expected a sweep"):
        effort(nothing)([0.5])


def test_gradients_of_tasks() -> None:
    """The drive follows the row, whatever the design is."""
    name = "origin:crank_pin.x"
    scene = cd.Scene(
        cd.load("four_bar"), task="crank_bearing", actuated="rocker_bearing", held={name: 0.0}
    )
    variables = cd.DesignVariables(lambda values: scene.sweep(1.0, held=values), {name: (0, 0.01)})
    place = variables.quantity(
        lambda sweep: sweep.position, lambda sweep, by: by.motion.position("rocker_bearing")
    )
    slope = float(np.ravel((place([0.501]) - place([0.499])) / 0.002)[0])
    assert np.ravel(place.jac([0.5])) == pytest.approx([slope], rel=1e-5)
    assert abs(slope) > 1e-3


def test_points_change_as_drives_and_lengths_move_them() -> None:
    legs = [f"leg_{k}" for k in range(1, 7)]
    robot = cd.Scene(cd.load("stewart_platform"), drive=legs)
    sweep = robot.sweep([[0.01, 0.02, -0.01, 0.0, 0.03, 0.01]])
    place = (0.1, -0.05, 0.2)
    point = sweep.point("platform", place)
    for leg, by in sweep.derivative(*legs).items():
        np.testing.assert_allclose(by.point("platform", place), point.ratio(leg), atol=1e-13)
    # A point of the coupler, by the two circles of its linkage and complex steps.
    name = "origin:rocker_pin.successor.x"
    bar = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held={name: 0.0})
    turn = bar.sweep(PHI)
    found = turn.derivative(name).point("coupler", (0.2, 0.1, 0.0))
    at, far = (turn.point("coupler", xyz).position for xyz in ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0)))
    # The far end moves about the crank's pin, and along the rocker as that gets longer.
    rocker = far[:, :2] - [0.47, 0.0]
    lengthwise = rocker / np.linalg.norm(rocker, axis=1, keepdims=True)
    arm = far[:, :2] - at[:, :2]
    turned = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    own = np.stack([-rocker[:, 1], rocker[:, 0]], axis=1)
    spin = [
        np.linalg.solve(np.stack([one, -other], axis=1), along)[0]
        for one, other, along in zip(turned, own, lengthwise, strict=True)
    ]
    reach = turn.point("coupler", (0.2, 0.1, 0.0)).position[:, :2] - at[:, :2]
    expected = np.array(spin)[:, None] * np.stack([-reach[:, 1], reach[:, 0]], axis=1)
    np.testing.assert_allclose(found[:, :2], expected, rtol=0.0, atol=1e-12)
    with pytest.raises(cd.ModelError, match="points that it moves are known where it is held"):
        cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep(PHI).derivative(name).point(
            "coupler"
        )
    with pytest.raises(cd.ModelError, match="couplr"):
        turn.derivative(name).point("couplr")
