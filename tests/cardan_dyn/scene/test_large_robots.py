"""Descriptions of robots with very many joints: what they take must not grow out of hand."""

from __future__ import annotations

import pinocchio
import pytest

import cardan_dyn as cd

JOINTS, ARM, APART, PAIRS = 97, 32, 26, 6


def robot() -> str:
    """Return arms of many revolute joints, in which distant ones are coupled."""
    parts = ['<robot name="robot"><link name="link_0"/>']
    for joint in range(1, JOINTS + 1):
        on_arm = (joint - 1) % ARM
        coupled = f'<mimic joint="joint_{joint - APART}" multiplier="1.5"/>'
        parts.append(
            f'<link name="link_{joint}"/><joint name="joint_{joint}" type="revolute">'
            f'<parent link="link_{joint - 1 if on_arm else 0}"/><child link="link_{joint}"/>'
            f'<origin xyz="0.1 0.2 {0.01 * joint}"/><axis xyz="{joint % 2} 0 {1 - joint % 2}"/>'
            f'<limit lower="-3" upper="3" effort="1" velocity="1"/>'
            f"{coupled if APART <= on_arm < APART + PAIRS else ''}</joint>"
        )
    return "\n".join([*parts, "</robot>"])


def test_describing_a_large_robot_makes_no_large_data(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pinocchio's data of the free-flyers of one coupling here would take 0.2 s and 200 MB."""
    mechanism, sizes = cd.load(robot()), []
    create = pinocchio.Model.createData

    def counted(model: pinocchio.Model) -> pinocchio.Data:
        sizes.append(model.nv)
        return create(model)

    monkeypatch.setattr(pinocchio.Model, "createData", counted)
    report = cd.describe(mechanism)
    assert report.mobility == JOINTS - 3 * PAIRS
    assert sum(component.rank for component in report.components) == 3 * PAIRS
    assert sum(size**3 for size in sizes) < (6 * 27) ** 3 / 4
