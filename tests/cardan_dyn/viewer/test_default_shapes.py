"""Default shapes: closed surfaces, at their joints, alike in all sizes."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from testkit.scaling import in_lengths

import cardan_dyn as cd
from cardan_dyn.practice.viewer import shapes as forms
from cardan_dyn.practice.viewer.bodies import Bodies
from cardan_dyn.practice.viewer.commands import Drawing
from cardan_dyn.practice.viewer.default_shapes import (
    Attachment,
    Body,
    Travel,
    attachments_of,
    bearing,
    downwards,
    is_cross,
    rod_radius,
    telescope,
    travel_of,
)
from cardan_dyn.practice.viewer.still import Still

X, Y, Z = np.eye(3)
ROD = 0.01


def volume(surface: tuple[np.ndarray, np.ndarray]) -> float:
    """Volume within a surface [m³]; that of open ones depends on the origin."""
    first, second, third = np.moveaxis(surface[0][surface[1]], 1, 0)
    return float(np.sum(first * np.cross(second, third)) / 6.0)


def is_closed(surface: tuple[np.ndarray, np.ndarray]) -> bool:
    """Whether each edge of a triangle is that of another one, the other way round."""
    _, same = np.unique(surface[0].round(9), axis=0, return_inverse=True)
    faces = same.reshape(-1)[surface[1]]
    proper = (
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    faces = faces[proper]
    edges = [tuple(face[[k, k - 2]]) for face in faces for k in range(3)]
    return sorted(edges) == sorted((b, a) for a, b in edges)


SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@pytest.mark.parametrize(
    ("surface", "expected"),
    [
        (forms.prism(SQUARE, -1.0, 2.0), 12.0),
        (forms.moved(forms.prism(SQUARE, -1.0, 2.0), forms.upright(X + Y, Z), 5.0 * Z), 12.0),
        # Twenty sides and six steps of a quarter circle are a little less than round.
        (forms.capsule(1.0, 3.0), 0.97 * np.pi * (3.0 + 4.0 / 3.0)),
        (forms.cup(1.0, 2.0), 0.97 * np.pi * 2.0 / 3.0 * 7.0 * (1.0 - np.cos(0.55 * np.pi))),
    ],
)
def test_surfaces_are_closed_and_turned_outwards(
    surface: tuple[np.ndarray, np.ndarray], expected: float
) -> None:
    assert is_closed(surface) or surface[0].max() == pytest.approx(2.0)  # A cup has an open rim.
    assert volume(surface) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("axis", [X, -Y, Z, -Z, X + Y + Z])
def test_upright_turns_z_to_an_axis(axis: np.ndarray) -> None:
    turn = forms.upright(axis)
    np.testing.assert_allclose(turn @ Z, axis / np.linalg.norm(axis), atol=1e-15)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    with_x = forms.upright(axis, np.array([0.3, 0.4, 0.5]))
    assert with_x[:, 0] @ [0.3, 0.4, 0.5] >= 0.0 and abs(with_x[:, 1] @ [0.3, 0.4, 0.5]) < 1e-12


def attachment(
    kind: str, point: object, axis: np.ndarray = Z, child: bool = True, name: str = ""
) -> Attachment:
    return Attachment(name or f"{kind} {point}", kind, np.array(point, float), axis, child, 9)


def extent(
    items: list[Attachment],
    centre: np.ndarray | None = None,
    crosses: frozenset[int] = frozenset(),
    travel: dict[str, Travel] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a box around what is drawn of a body; all of its surfaces are checked."""
    parts = Body(items, centre, crosses, travel or {}, ROD).parts()
    surfaces = (*parts.link, *parts.pins)
    assert all(volume(item) > 0.0 for item in surfaces if is_closed(item))
    points = np.concatenate([vertices for vertices, _ in surfaces])
    return np.min(points, axis=0), np.max(points, axis=0)


def test_a_rod_between_two_pins() -> None:
    low, high = extent([attachment("turn", (0, 0, 0)), attachment("turn", (1, 0, 0), child=False)])
    # The eye at one end and the fork at the other one are wider than the rod.
    np.testing.assert_allclose(low, (-1.9 * ROD, -1.9 * ROD, -2.2 * ROD), rtol=0.02)
    np.testing.assert_allclose(high, (1.0 + 1.6 * ROD, 1.9 * ROD, 2.2 * ROD), rtol=0.02)


def test_a_triangle_is_a_plate_and_a_line_is_a_rod() -> None:
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    plate = Body([attachment("turn", p) for p in corners], None, frozenset(), {}, ROD).parts()
    area = 0.5 + 1.5 * ROD * (2.0 + 2.0**0.5) + np.pi * (1.5 * ROD) ** 2
    assert volume(plate.link[0]) == pytest.approx(1.2 * ROD * area, rel=1e-3)
    row = Body(
        [attachment("turn", p) for p in ((0, 0, 0), (2, 0, 0), (1, 0, 0))],
        *(None, frozenset(), {}, ROD),
    ).parts()
    assert volume(row.link[0]) == pytest.approx(np.pi * ROD**2 * 2.0, rel=0.03)


def test_points_in_space_are_joined_by_a_star() -> None:
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    star = Body([attachment("ball", p) for p in corners], None, frozenset(), {}, ROD).parts()
    assert len(star.link) == 5 and len(star.pins) == 4  # Four rods and a hub; four balls.


def test_crosses_are_told_from_shafts_by_their_mass() -> None:
    axes = [attachment("turn", (0, 0, 0), axis, name=f"{k}") for k, axis in enumerate((X, Y))]
    assert is_cross(axes, None, ROD) and is_cross(axes, 0.5 * ROD * X, ROD)
    assert not is_cross(axes, 0.3 * X, ROD)
    assert not is_cross(axes[:1], None, ROD)
    assert not is_cross([*axes, attachment("ball", (0, 0, 0))], None, ROD)
    low, high = extent(axes)
    np.testing.assert_allclose(high, (3.2 * ROD, 3.2 * ROD, 1.25 * ROD), rtol=0.02)
    # A shaft goes to its mass and on behind it, where its bearing is; its fork holds the cross.
    low, high = extent([axes[0], axes[1]._replace(other=7)], -0.3 * X, frozenset({7}))
    assert low[0] == pytest.approx(-0.3 - 5.5 * ROD)
    assert high[0] == pytest.approx(1.6 * ROD)  # The fork's cheeks, round about the pins.


def test_a_pendulum_ends_in_its_weight() -> None:
    low, high = extent([attachment("turn", (0, 0, 0), Y)], np.array([0.0, 0.0, -0.5]))
    assert low[2] == pytest.approx(-0.5 - 1.8 * ROD)
    low, high = extent([attachment("turn", (0, 0, 0), Y)])
    np.testing.assert_allclose(high[1], 2.0 * ROD)  # A hub alone.


def test_tubes_of_slides_hold_their_rods_over_all_samples() -> None:
    mechanism = cd.load("stewart_platform")
    found = attachments_of(mechanism)
    rod = rod_radius(found.values(), 1.0)
    span = (-0.2, 0.15)
    for number in range(1, 7):
        (body,) = (
            k
            for k, items in found.items()
            for i in items
            if i.joint == f"leg_{number}" and not i.is_child
        )
        (own,) = (item for item in found[body] if item.joint == f"leg_{number}")
        (end,) = (item for item in found[own.other] if item.joint == own.joint)
        travel = {own.joint: travel_of(own, found[body], found[own.other], span, rod)}
        tube, piston = telescope(own, travel, rod), telescope(end, travel, rod)
        assert tube is not None and piston is not None
        # The tube starts at the joint on the base.
        base = next(item for item in found[body] if item.joint == f"base_{number}_y")
        np.testing.assert_allclose(tube[0], base.point, atol=1e-12)
        for coordinate in np.linspace(*span, 9):
            inner = own.point + (coordinate + (piston[1] - end.point) @ own.axis) * own.axis
            assert 0.0 < (inner - tube[0]) @ own.axis < (tube[1] - tube[0]) @ own.axis


def test_a_slide_near_its_origin_is_a_block_on_a_rail() -> None:
    item = attachment("slide", (0, 0, 0), X, child=False, name="s")
    near = {"s": travel_of(item, [item], [item], (-0.05, 0.3), ROD)}
    assert telescope(item, near, ROD) is None
    assert telescope(item, {"s": Travel(0.3, 0.5, is_free=False)}, ROD) is None
    low, high = extent([item, attachment("turn", (0, 0.2, 0))], travel=near)
    assert (low[0], high[0]) == pytest.approx((-0.05 - 5.2 * ROD, 0.3 + 5.2 * ROD))
    backwards = {"s": travel_of(item, [item], [item], (-0.5, -0.3), ROD)}
    tube = telescope(item, backwards, ROD)
    assert tube is not None and tube[1][0] == pytest.approx(-0.75 * 0.3)
    # The rod would leave the tube on so long a way.
    far = {"s": travel_of(item, [item], [item], (0.3, 0.6), ROD)}
    assert telescope(item, far, ROD) is None
    low, high = extent([item, attachment("turn", (0, 0.2, 0))], travel=far)
    assert low[0] < 0.0 and high[0] == pytest.approx(0.6 + 5.2 * ROD)


@pytest.mark.parametrize("kind", ["turn", "slide", "ball", "cross"])
@pytest.mark.parametrize("axis", [X, Y, Z, -Z])
@pytest.mark.parametrize("child", [True, False])
@pytest.mark.parametrize("way", [X, Y, Z])
def test_bearings_stand_below_their_joints(
    kind: str, axis: np.ndarray, child: bool, way: np.ndarray
) -> None:
    item = attachment(kind, (1, 2, 3), axis, child)
    parts = bearing(item, -Z, way, 0.0, frozenset(), Travel(-0.1, 0.1), ROD)
    points = np.concatenate([vertices for vertices, _ in (*parts.link, *parts.pins)]) - [1, 2, 3]
    # Most of it is on the side of the foot, which is below, or behind an upright axis.
    if kind == "ball" or abs(axis[2]) < 0.5:
        assert -np.min(points[:, 2]) > 5.0 * ROD > np.max(points[:, 2])
    elif kind != "slide":
        along = points @ axis
        assert max(-np.min(along), np.max(along)) > 5.0 * ROD
    assert np.max(np.abs(points)) < 0.1 + 12.0 * ROD


def test_feet_are_in_the_plane_of_a_mechanism_that_lies() -> None:
    np.testing.assert_array_equal(downwards([attachment("turn", (0, 0, 0), Z)]), -Y)
    np.testing.assert_array_equal(downwards([attachment("turn", (0, 0, 0), X)]), -Z)
    np.testing.assert_array_equal(downwards([]), -Z)


@pytest.mark.parametrize("name", ["four_bar", "universal_joint", "stewart_platform"])
@pytest.mark.parametrize("factor", [1e-3, 37.0])
def test_mechanisms_of_all_sizes_look_alike(name: str, factor: float) -> None:
    clouds = []
    for text in (in_lengths(cd.load(name), 1.0), in_lengths(cd.load(name), factor)):
        configuration = cd.assemble(cd.load(text))
        drawing = Drawing(1.0)
        Bodies(Still(configuration), np.arange(1), visuals=True).draw(drawing)
        clouds.append({item.path: item.surface[0] for item in drawing.objects})
    assert clouds[0].keys() == clouds[1].keys() and len(clouds[0]) > 4
    for path, vertices in clouds[0].items():
        scale = factor * np.max(np.abs(vertices))
        np.testing.assert_allclose(clouds[1][path], factor * vertices, atol=1e-6 * scale)


def test_joints_of_a_loop_have_the_places_of_the_description() -> None:
    """Where the frames of both sides coincide, in a configuration that is closed."""
    configuration = cd.assemble(cd.load("four_bar"), near={"crank_bearing": 0.7})
    mechanism = configuration.mechanism
    placements = {0: (np.eye(3), np.zeros(3))}
    for name, joint in mechanism.joints.items():
        if name not in {loop.joint for loop in mechanism.loops}:
            placements[joint.id] = (configuration.rotation(name), configuration.origin(name))
    for body, items in attachments_of(mechanism).items():
        for item in items:
            turn, place = placements[body]
            np.testing.assert_allclose(
                turn @ item.point + place, configuration.origin(item.joint), atol=1e-12
            )
            axis = configuration.rotation(item.joint) @ mechanism.joints[item.joint].axis
            np.testing.assert_allclose(turn @ item.axis, axis, atol=1e-12)
