"""Welds as Pinocchio has them."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.mixed_chain import MIXED

import cardan_dyn as cd


def test_loops_are_pinocchios_constraints() -> None:
    mechanism = cd.load(MIXED)
    models = mechanism.constraint_models
    assert len(models) == 3
    for model, loop in zip(models, mechanism.loops, strict=True):
        assert (model.joint1_id, model.joint2_id) == (loop.predecessor, loop.successor)
        np.testing.assert_array_equal(
            model.joint2_placement.homogeneous, loop.successor_placement.homogeneous
        )
        assert model.type == pinocchio.ContactType.CONTACT_6D


@pytest.mark.parametrize("height", [2.5, -2.5])
def test_welds_count_in_the_length_of_a_mechanism(height: float) -> None:
    """The bolt is welded to the world far from the hinge `turn`."""
    mechanism = cd.load(MIXED.replace("0.7 1.5 2.5", f"0.7 1.5 {height}"))
    ends = np.array([[1.0, 2.0, 3.0], [0.7, 1.5, height]])
    apart = float(np.max(np.linalg.norm(ends - ends.mean(axis=0), axis=1)))
    # From the slide of the platform to its hinge.
    platform = float(np.linalg.norm([0.5, 0.3, -0.6]))
    assert mechanism.characteristic_length == pytest.approx(max(platform, apart), rel=1e-14)
    # It is the same however the balls are written.
    variant = mechanism.variant(["ball"])
    assert variant.characteristic_length == mechanism.characteristic_length


def test_an_unmoved_end_in_the_world_has_no_length_of_its_own() -> None:
    """The longest distance is that between the joints of the coupler, wherever the ring is cut."""
    points = {"a": (0.0, 0.0), "b": (0.0, 2e-7), "c": (3e-7, 6e-7), "d": (3e-7, 0.0)}
    ring = ["ground", "crank", "coupler", "rocker"]
    for cut in points:
        text = '<robot name="small"><link name="ground"/>' + "".join(
            f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1e-16" iyy="1e-16" '
            'izz="1e-16" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            for name in ring[1:]
        )
        at = {"ground": (0.0, 0.0)}
        left = [name for name in points if name != cut]
        while left:
            name = next(
                name
                for name in left
                if (ring["abcd".index(name)] in at) != (ring["abcd".index(name) - 3] in at)
            )
            left.remove(name)
            ends = ring["abcd".index(name)], ring["abcd".index(name) - 3]
            parent, child = ends if ends[0] in at else ends[::-1]
            at[child] = points[name]
            x, y = np.subtract(points[name], at[parent]).tolist()
            text += (
                f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
                f'<child link="{child}"/><origin xyz="{x!r} {y!r} 0"/><axis xyz="0 0 1"/></joint>'
            )
        frames = (
            f'<{end} link="{link}"><origin xyz="{x!r} {y!r} 0"/></{end}>'
            for end, link in zip(
                ("predecessor", "successor"),
                (ring["abcd".index(cut)], ring["abcd".index(cut) - 3]),
                strict=True,
            )
            for x, y in [np.subtract(points[cut], at[link]).tolist()]
        )
        text += f'<loop name="{cut}" type="continuous">{"".join(frames)}<axis xyz="0 0 1"/></loop>'
        mechanism = cd.load(text + "</robot>")
        # From (3e-7, 6e-7) to (3e-7, 0); the coupler is 5e-7 long, the crank 2e-7.
        assert mechanism.characteristic_length == pytest.approx(6e-7, rel=1e-12, abs=0.0), cut
