"""A mechanism as a container of joints, its loops, couplings and characteristic length."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from testkit.mixed_chain import MIXED, joint, link

import cardan_dyn as cd

WHEELS = (
    '<robot name="wheels &lt;1&gt;"><link name="base"/>'
    + link("first", 1.0)
    + joint("a", "continuous", "base", "first", "100 0 0", "0 0 1")
    + link("second", 1.0)
    + joint("b", "continuous", "base", "second", "103 4 0", "0 0 1")
    + '<coupling name="mesh"><predecessor link="first"/><successor link="second"/>'
    '<ratio value="-2.5"/></coupling></robot>'
)


@pytest.fixture(scope="module")
def mixed() -> cd.Mechanism:
    return cd.load(MIXED)


def test_a_mechanism_is_a_collection_of_joints(mixed: cd.Mechanism) -> None:
    names = ["turn", "slide", "swing", "hinge", "ball", "cross", "bolt"]
    assert list(mixed) == mixed.joint_names == names
    assert len(mixed) == 7 and bool(mixed)
    assert "ball" in mixed and "left" not in mixed and None not in mixed and 1 not in mixed
    assert mixed["ball"] is mixed.joint("ball") is mixed.joints["ball"]
    with pytest.raises(cd.ModelError, match="no joint 'left'; joints: ball, bolt"):
        mixed["left"]


def test_links_are_placed_in_their_bodies(mixed: cd.Mechanism) -> None:
    assert mixed.link_names == ["base", "platform", "right", "slider", "left"]
    body, placement = mixed.link("right")
    assert body == mixed["hinge"].id
    np.testing.assert_array_equal(placement.homogeneous, np.eye(4))
    assert mixed.link("base")[0] == 0
    with pytest.raises(cd.ModelError, match="no link 'ball'; links: base, left"):
        mixed.link("ball")


def test_loops_are_welds(mixed: cd.Mechanism) -> None:
    ball, cross, bolt = mixed.loops
    # A loop's joint ends in a body of its own, which is welded to the successor.
    assert ball.predecessor == mixed["ball"].id
    np.testing.assert_array_equal(ball.predecessor_placement.homogeneous, np.eye(4))
    assert ball.successor == mixed["hinge"].id
    np.testing.assert_allclose(ball.successor_placement.translation, [-0.1, 0.2, 0.1])
    assert cross.successor == mixed["slide"].id
    assert mixed.model.parents[mixed["cross"].parts[0].id] == mixed["hinge"].id
    assert bolt.predecessor == mixed["swing"].id and bolt.successor == 0
    np.testing.assert_allclose(bolt.predecessor_placement.translation, [0.3, 0.0, 0.0])
    np.testing.assert_allclose(bolt.successor_placement.translation, [0.7, 1.5, 2.5])
    assert [loop.joint for loop in mixed.loops if loop.is_fixed] == ["bolt"]
    # A `fixed` loop to the world needs no body.
    assert mixed.auxiliary_bodies == ()
    assert len(mixed.constraint_models) == 3


def test_couplings_count_the_joints_on_both_sides() -> None:
    wheels = cd.load(WHEELS)
    (mesh,) = wheels.couplings
    assert mesh.ratio == -2.5
    first, second = (wheels.coordinates.velocity_columns[name].start for name in "ab")
    assert mesh.predecessor_columns == (first,) and mesh.successor_columns == (second,)


def test_characteristic_length_is_independent_of_the_place_in_the_world() -> None:
    """Two wheels 5 m apart, 2.5 m from their middle; nothing within a body is longer."""
    assert cd.load(WHEELS).characteristic_length == pytest.approx(2.5, rel=1e-13)


def test_representations(mixed: cd.Mechanism) -> None:
    assert repr(mixed) == "<Mechanism 'mixed': 7 joints, loops: ball, cross, bolt>"
    assert repr(mixed["ball"]) == "<Joint 'ball': spherical>"
    table = mixed._repr_html_()
    for text in (
        "mixed",
        "ball: spherical",
        "ball, cross, bolt",
        f"{mixed.characteristic_length:.4g} m",
    ):
        assert text in table


def test_tables_escape_names_and_list_couplings() -> None:
    table = cd.load(WHEELS)._repr_html_()
    assert "wheels &lt;1&gt;" in table and "wheels <1>" not in table
    assert "mesh: ratio -2.5" in table


def test_a_variant_has_turns_instead_of_balls(mixed: cd.Mechanism) -> None:
    variant = mixed.variant(["ball", "turn"])
    assert variant is mixed.variant(["ball"]) is variant.variant(["ball"])
    assert variant.base is mixed.base is mixed
    assert mixed.variant(["turn"]) is mixed is variant.variant([])
    assert (mixed["ball"].has_ball, variant["ball"].has_ball) == (True, False)
    assert variant["ball"].type == "spherical"
    np.testing.assert_array_equal(variant["ball"].axis, mixed["ball"].axis)
    assert variant.model.nv == mixed.model.nv and variant.model.nq == mixed.model.nq - 1
    assert list(variant.drivable.items()) == list(mixed.drivable.items())
    assert variant.to_urdf() == mixed.to_urdf()
    with pytest.raises(cd.ModelError, match="no joint 'nothing'"):
        variant.variant(["nothing"])


def test_variants_are_copied_with_their_base(mixed: cd.Mechanism) -> None:
    again = pickle.loads(pickle.dumps(mixed.variant(["ball"])))
    assert again.coordinates.cardan == {"ball"} and not again.base.coordinates.cardan
    assert again.base.variant(["ball"]) is again
    both = pickle.loads(pickle.dumps((mixed, mixed.variant(["ball"]))))
    assert both[1].base is both[0]


def test_coordinates_are_no_joints(mixed: cd.Mechanism) -> None:
    assert "ball.x" in mixed.drivable and "ball.x" not in mixed
    with pytest.raises(cd.ModelError, match=r"'ball.x' is a coordinate; name its joint, 'ball'"):
        mixed.joint("ball.x")


@pytest.mark.parametrize(
    "given", [{"outputs": ["fork_phase"]}, {"compliance": {"fork_phase": [1.0] * 6}}]
)
def test_adjustable_joints_are_rigid_unless_they_are_held(given: dict[str, object]) -> None:
    shaft = cd.load("double_shaft_z")
    angles = {"joint_angle_1": 0.2, "joint_angle_2": 0.2}
    message = r"'fork_phase' is adjustable, and rigid unless.*hold it: held=\{'fork_phase': 0.0\}"
    with pytest.raises(cd.CardanError, match=message):
        cd.Scene(shaft, drive="bearing_in", held=angles, **given)  # type: ignore[arg-type]
    held = {**angles, "fork_phase": 0.0}
    cd.Scene(shaft, drive="bearing_in", held=held, **given)  # type: ignore[arg-type]


def test_joints_at_the_ground_are_those_of_the_tree_and_of_loops() -> None:
    bar = cd.load("four_bar")
    assert bar.grounded == {"crank_bearing", "rocker_bearing"}
    # A loop that ends in the world, whichever of its sides that is, and whether it moves or not.
    for kind in ("continuous", "fixed"):
        for first, second in (("base", "b"), ("b", "base")):
            text = (
                '<robot name="r"><link name="base"/><link name="a"/><link name="b"/>'
                '<joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint>'
                '<joint name="k" type="continuous"><parent link="a"/><child link="b"/></joint>'
                f'<loop name="l" type="{kind}"><predecessor link="{first}"/>'
                f'<successor link="{second}"/></loop></robot>'
            )
            assert cd.load(text).grounded == {"j", "l"}
