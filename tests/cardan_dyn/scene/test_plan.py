"""Plans: what a sweep of a scene does, and what it leaves out and why."""

from __future__ import annotations

from testkit.drive_lines import SHAFT, drive_line, two_lines
from testkit.linkages import coupling, gears
from testkit.scenes import text, universal

import cardan_dyn as cd
from cardan_dyn.scene.plan import Plan


def massless(name: str) -> cd.Mechanism:
    described = text(name)
    while "<inertial>" in described:
        start = described.index("<inertial>")
        end = described.index("</inertial>") + len("</inertial>")
        described = described[:start] + described[end:]
    return cd.load(described)


def test_groups_of_a_drive_line() -> None:
    mechanism = cd.load(drive_line(5))
    scene = cd.Scene(mechanism, drive="bearing_0", loads={"bearing_5": -1.0})
    steps = scene.plan().steps
    assert steps[:5] == [
        f"close pin_{k}_out: decides pin_{k}_in, pin_{k}_out, bearing_{k}" for k in range(1, 6)
    ]
    assert "closure forces of 5 group(s), against the order of motion" in steps
    shown = str(scene.plan())
    assert shown.startswith("1. close pin_1_out")
    assert "- weight: the scene has no gravity" in shown


def test_steps_of_a_single_loop(joint: cd.Mechanism) -> None:
    plan = universal(joint, 0.5, gravity=(0.0, 0.0, -9.81)).plan()
    assert plan.steps == [
        "close pin_out: decides pin_in, pin_out, bearing_out",
        "inverse dynamics: weight, and inertia where the drives have speed or acceleration",
        "closure forces of 1 group(s), at once",
        "wrenches of: bearing_in, pin_in, joint_angle, bearing_out, pin_out",
        "residuals: loops, rates, balance of bodies, power",
    ]
    assert plan.skipped == []
    assert "skipped" not in str(plan)
    assert "skipped" not in plan._repr_html_()


def test_without_gravity_there_is_no_weight(joint: cd.Mechanism) -> None:
    plan = universal(joint, 0.5).plan()
    assert "inverse dynamics: inertia where the drives have speed or acceleration" in plan.steps
    assert plan.skipped == ["weight: the scene has no gravity"]


def test_without_mass_there_are_no_inverse_dynamics() -> None:
    plan = universal(massless("universal_joint"), 0.5, gravity=(0.0, 0.0, -9.81)).plan()
    assert plan.skipped == ["inverse dynamics: no body has mass"]
    assert not [step for step in plan.steps if "inverse dynamics" in step]


def test_efforts_alone_need_no_closure_forces(joint: cd.Mechanism) -> None:
    plan = universal(joint, 0.5, outputs=[]).plan()
    assert plan.steps[-2:] == [
        "drive efforts by virtual work",
        "residuals: loops, rates, power",
    ]
    closed = "close pin_out: decides pin_in, pin_out, bearing_out"
    assert f"closure forces of: {closed}: no output needs them" in plan.skipped
    assert not [step for step in plan.steps if step.startswith("wrenches")]


def test_groups_that_no_output_needs_are_skipped() -> None:
    lines = cd.load(two_lines(2))
    plan = cd.Scene(lines, drive="bearing_0", outputs=["left_2"]).plan()
    closed = [step for step in plan.steps if step.startswith("close ")]
    assert [step.split(":")[0] for step in closed] == [
        "close left_pin_1_out",
        "close left_pin_2_out",
    ]
    for index in (1, 2):
        (reason,) = (item for item in plan.skipped if f"close right_pin_{index}_out" in item)
        assert reason.endswith(": no output needs it")
    # The first joint moves the second, but its forces say nothing of what leaves it.
    (reason,) = (item for item in plan.skipped if "close left_pin_1_out" in item)
    assert reason.startswith("closure forces of: ")
    assert "wrenches of: left_2" in plan.steps


def test_couplings_are_closed_as_loops_are() -> None:
    mechanism = cd.load(gears(coupling("mesh", "a", "b", 2.0)))
    assert cd.Scene(mechanism, drive="a").plan().steps[0] == "close mesh: decides b"


def test_bodies_on_no_loop_are_named() -> None:
    fan = SHAFT.format(name="fan") + (
        '<joint name="fan_bearing" type="continuous"><parent link="base"/><child link="fan"/>'
        '<axis xyz="1 0 0"/></joint></robot>'
    )
    mechanism = cd.load(two_lines(2).replace("</robot>", fan))
    scene = cd.Scene(mechanism, drive=["bearing_0", "fan_bearing"], outputs=["left_2"])
    assert "bodies on no loop: fan_bearing: no output needs it" in scene.plan().skipped
    skipped = scene.replace(outputs=None).plan().skipped
    assert not [reason for reason in skipped if "fan_bearing" in reason]


PLAN = Plan(["close <pin> & bolt", "residuals"], ["weight: <none>"], "<none>")


def test_texts_of_a_plan() -> None:
    expected = (
        "1. close <pin> & bolt\n2. residuals\nskipped:\n- weight: <none>\nsimulated by: <none>"
    )
    assert str(PLAN) == repr(PLAN) == expected
    assert str(Plan(["residuals"], [], "DOP853")) == "1. residuals\nsimulated by: DOP853"


def test_notebooks_show_escaped_texts() -> None:
    assert PLAN._repr_html_() == (
        "<div><ol><li>close &lt;pin&gt; &amp; bolt</li><li>residuals</li></ol>"
        "<p>skipped:</p><ul><li>weight: &lt;none&gt;</li></ul>"
        "<p>simulated by: &lt;none&gt;</p></div>"
    )
    shown = Plan(["residuals"], [], "DOP853")._repr_html_()
    assert shown == "<div><ol><li>residuals</li></ol><p>simulated by: DOP853</p></div>"


def test_plans_say_how_a_scene_is_simulated(joint: cd.Mechanism) -> None:
    """The first method that is named is the one that is taken."""
    free = universal(joint, 0.5, 0.0).replace(free="bearing_in")
    loaded = free.replace(loads={"bearing_out": [1.0, 2.0]})
    damped = cd.Scene(
        cd.load("four_bar"),
        free="crank_bearing",
        elements=[cd.JointSpring("rocker_bearing", 3.0, damping=1.0)],
    )
    two = cd.Scene(joint, free=["bearing_in", "joint_angle"], near={"joint_angle": 0.3})
    for scene, speed in ((free, 1.0), (damped, 1.0), (two, [1.0, 0.0])):
        said = scene.plan().simulation
        assert said.startswith(scene.simulate(1e-3, speed=speed).method)
    assert "damping" in damped.plan().simulation
    assert two.plan().simulation.endswith("it takes one free coordinate and no drive)")
    assert free.replace(drive="bearing_in").plan().simulation == "nothing, no coordinate is free"
    assert two.replace(drive="joint_angle").plan().simulation == two.plan().simulation
    assert "has shape (2,)" in loaded.plan().simulation
    assert universal(massless("universal_joint"), 0.5).plan().simulation == (
        "nothing, no body has mass"
    )
    assert f"simulated by: {free.plan().simulation}" in str(free.plan())
    assert "simulated by: " in free.plan()._repr_html_()
