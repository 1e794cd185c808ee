"""Self-stresses of planar linkages and gear trains by hand, and false flags of uniqueness."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.kinematics import frames_of
from testkit.linkages import coupling, gears, tilted_slider_crank
from testkit.planar_linkages import BASE, CRANK, ROCKER, described, four_bar, joint, link, loop

import cardan_dyn as cd
from cardan_dyn.core.proof import self_stress
from cardan_dyn.core.proof.screws import Screws
from cardan_dyn.core.proof.self_stress import SelfStressProof, prove_flags

LENGTH = 0.4
OUT_OF_PLANE = [False, False, True, True, True, False]
"""Force z, moments x and y: what a planar loop leaves open."""


def proof(
    mechanism: cd.Mechanism,
    *drives: str,
    couplings: np.ndarray | None = None,
    length: float = LENGTH,
) -> SelfStressProof:
    velocities, nv = mechanism.coordinates.velocity_columns, mechanism.model.nv
    prescribed = [velocities[name].start for name in drives]
    passives = [rate for rate in range(nv) if rate not in prescribed]
    loops = list(range(len(frames_of(mechanism).ends)))
    factors = np.zeros((0, nv)) if couplings is None else couplings
    every = len(factors), lambda x: np.broadcast_to(factors, (len(x), *factors.shape))
    return SelfStressProof(Screws(frames_of(mechanism)), loops, *every, passives, length)


def positions(mechanism: cd.Mechanism, *rows: dict[str, float]) -> np.ndarray:
    x = np.zeros((len(rows), mechanism.coordinates.size))
    for index, row in enumerate(rows):
        for name, value in row.items():
            x[index, mechanism.coordinates.columns[name]] = value
    return x


def judged(stress: SelfStressProof, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the influence `(N, J, 6)` at all positions and where it is clear."""
    influence, clear = zip(*stress.influence(x), strict=True)
    return np.concatenate(influence), np.concatenate(clear)


def bent(off: float) -> dict[str, float]:
    """Return crank and coupler of the four-bar in line up to an angle, driven by the rocker."""
    return {"B": np.arctan2(BASE, ROCKER - CRANK) + off}


def test_a_planar_four_bar_is_open_out_of_its_plane() -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "A")
    assert stress.unknowns == 6
    influence, clear = judged(stress, positions(mechanism, {}))
    assert clear.tolist() == [True]
    # Unit self-stresses: a force 1 / length along z, and moments 1 about x and y, all about the
    # middle between the ground pivots; the force has a lever arm at each joint.
    corner = np.array([0.5 * BASE, 0.0])
    points = {"A": (0.0, 0.0), "B": (0.0, CRANK), "D": (BASE, 0.0), "C": (BASE, ROCKER)}
    for name, point in points.items():
        x, y = np.subtract(point, corner) / LENGTH
        expected = [0.0, 0.0, 1.0, np.hypot(1.0, y), np.hypot(1.0, x), 0.0]
        actual = influence[0, stress.joints.index(name)]
        np.testing.assert_allclose(actual, expected, atol=1e-13)


@pytest.mark.parametrize("drives", ["A", "AM"])
def test_what_carries_a_loop_is_not_loaded_by_it(drives: str) -> None:
    carried = described(
        *(link(name) for name in "mabc"),
        joint("M", "ground", "m", (0.3, -0.2)),
        joint("A", "m", "a"),
        joint("B", "a", "b", (0.0, CRANK)),
        joint("D", "m", "c", (BASE, 0.0)),
        loop("b", "c", (BASE, ROCKER - CRANK), (0.0, ROCKER)),
    )
    stress = proof(carried, *drives)
    (influence,), _ = judged(stress, positions(carried, {"M": 0.0}))
    assert not influence[stress.joints.index("M")].any()
    for name in "ABCD":
        assert (influence[stress.joints.index(name)] > 0.1).tolist() == OUT_OF_PLANE


def test_a_ball_leaves_only_what_passes_through_it() -> None:
    """Closed by a ball, the four-bar has no moment at the ball; the force z stays open."""
    source = four_bar().description.source.text
    ball = source.replace('<loop name="C" type="continuous">', '<loop name="C" type="spherical">')
    mechanism = cd.load(ball)
    influence, clear = judged(proof(mechanism, "A"), mechanism.coordinates.neutral()[None])
    assert clear.all()
    ball_index = frames_of(mechanism).joints.index("C")
    open_components = influence[0, ball_index] > 1e-9
    assert open_components.tolist() == [False, False, True, False, False, False]


def test_special_positions_have_more_self_stresses() -> None:
    """With crank and coupler in line, a force along them moves nothing while D is driven."""
    mechanism = four_bar()
    stress = proof(mechanism, "D")
    x = positions(mechanism, bent(0.3), bent(0.0), bent(1e-9))
    influence, clear = judged(stress, x)
    # Next to that position no answer is certain.
    assert clear.tolist() == [True, True, False]
    crank = stress.joints.index("A")
    assert influence[0, crank, 1] < 1e-12
    assert influence[1, crank, 1] > 0.1


def test_driving_a_redundant_joint_opens_another_direction() -> None:
    """Two drives of a linkage with one degree of freedom work against each other."""
    mechanism = four_bar()
    x = positions(mechanism, {})
    driven_twice, _ = judged(proof(mechanism, "A", "D"), x)
    driven, _ = judged(proof(mechanism, "A"), x)
    first = frames_of(mechanism).joints.index("A")
    assert driven[0, first, 5] < 1e-12
    assert driven_twice[0, first, 5] > 0.1


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_unit_of_length_decides_nothing(unit: float) -> None:
    """Efforts of slides are forces, which are compared with moments by the length."""
    plain, scaled = (cd.load(tilted_slider_crank(scale, planar=False)) for scale in (1.0, unit))
    x = np.zeros((1, plain.coordinates.size))
    expected, clear = judged(proof(plain, "crank_bearing"), x)
    assert clear.all()
    influence, clear = judged(proof(scaled, "crank_bearing", length=LENGTH * unit), x)
    assert clear.all()
    np.testing.assert_allclose(influence, expected, atol=1e-9)


def test_redundant_couplings_load_no_joint() -> None:
    mechanism = cd.load(gears(coupling("g", "a", "b", 2.0), coupling("h", "a", "b", 2.0)))
    factors = np.array([[-2.0, 1.0], [-2.0, 1.0]])
    stress = proof(mechanism, "a", couplings=factors)
    assert stress.unknowns == 2
    influence, clear = judged(stress, np.zeros((1, 2)))
    assert clear.all()
    np.testing.assert_array_equal(influence, np.zeros((1, 2, 6)))


def test_many_positions_are_judged_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "D")
    x = positions(mechanism, *(bent(0.1 * k) for k in range(5)))
    at_once = judged(stress, x)
    monkeypatch.setattr(self_stress, "_POSITIONS_AT_ONCE", 2)
    assert len(list(stress.influence(x))) == 3
    in_blocks = judged(stress, x)
    np.testing.assert_array_equal(in_blocks[0], at_once[0])
    np.testing.assert_array_equal(in_blocks[1], at_once[1])


def flags(stress: SelfStressProof) -> np.ndarray:
    return np.array([~np.array(OUT_OF_PLANE)] * len(stress.joints))


def test_right_flags_are_accepted() -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "A")
    every = list(range(4))
    prove_flags(stress, positions(mechanism, {}), flags(stress), every, 1.0)


@pytest.mark.parametrize(("component", "name"), [(2, "force z"), (3, "moment x")])
def test_a_component_flagged_unique_that_changes_is_refused(component: int, name: str) -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "A")
    false = flags(stress)
    false[1, component] = True
    joints = [2, 1, 0, 3]
    expected = f"{name} of the wrench at 'B' is flagged unique, but changes under self-stress"
    with pytest.raises(cd.AccuracyError, match=expected) as caught:
        prove_flags(stress, positions(mechanism, {}), false, joints, 1.0)
    assert caught.value.position is None
    assert np.isnan(caught.value.residual)
    # However badly conditioned, what changes is not unique.
    with pytest.raises(cd.AccuracyError):
        prove_flags(stress, positions(mechanism, {}), false, joints, 1e9)


def test_a_component_flagged_open_that_does_not_change_is_refused() -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "A")
    false = flags(stress)
    false[0, 5] = False
    joints = [3, 2, 1, 0]
    name = stress.joints[3]
    expected = f"moment z of the wrench at '{name}' is flagged open, but does not change"
    with pytest.raises(cd.AccuracyError, match=expected):
        prove_flags(stress, positions(mechanism, {}), false, joints, 1.0)
    # The solver may flag a component by the rounding of badly conditioned equations.
    prove_flags(stress, positions(mechanism, {}), false, joints, 1e5)


def test_components_that_are_open_at_special_positions_only() -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "D")
    crank = stress.joints.index("A")
    open_there = flags(stress)[[crank]]
    open_there[0, [0, 1]] = [True, False]
    regular = positions(mechanism, *(bent(0.3 + 0.1 * k) for k in range(5)))
    with pytest.raises(cd.AccuracyError, match="force y of the wrench at 'A' is flagged open"):
        prove_flags(stress, regular, open_there, [crank], 1.0)
    special = regular.copy()
    special[1] = positions(mechanism, bent(0.0))[0]
    prove_flags(stress, special, open_there, [crank], 1.0)


def test_positions_next_to_singular_ones_prove_nothing() -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "D")
    near = positions(mechanism, bent(1e-9))
    prove_flags(stress, near, np.zeros((4, 6), dtype=bool), list(range(4)), 1.0)
    prove_flags(stress, near, np.ones((4, 6), dtype=bool), list(range(4)), 1.0)


def test_too_many_unknowns_are_not_decomposed(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = four_bar()
    stress = proof(mechanism, "A")
    false, every = np.ones((4, 6), dtype=bool), list(range(4))
    x = positions(mechanism, {})
    with pytest.raises(cd.AccuracyError):
        prove_flags(stress, x, false, every, 1.0)
    monkeypatch.setattr(self_stress, "MOST_UNKNOWNS", 5)
    prove_flags(stress, x, false, every, 1.0)


def test_without_loops_nothing_is_open() -> None:
    mechanism = cd.load(gears())
    stress = proof(mechanism, "a", "b")
    assert stress.unknowns == 0
    prove_flags(stress, np.zeros((1, 2)), np.ones((2, 6), dtype=bool), [0, 1], 1.0)
