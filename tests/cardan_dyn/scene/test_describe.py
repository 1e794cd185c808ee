"""Reports on mechanisms: mobility, ranks, what redundant rows leave open, as text and HTML."""

from __future__ import annotations

import pytest
from testkit.drive_lines import drive_line
from testkit.linkages import coupling, four_bar, gears, loop
from testkit.planar_linkages import described, link, three_cranks
from testkit.planar_linkages import joint as hinge
from testkit.planar_linkages import loop as closing_pin

import cardan_dyn as cd
from cardan_dyn.scene import describe as module


def test_description_of_the_universal_joint(joint: cd.Mechanism, shaft: cd.Mechanism) -> None:
    report = cd.describe(joint)
    assert (report.coordinates, report.rank, report.mobility) == (5, 3, 2)
    assert not report.is_counted
    (pin,) = report.loops
    assert (pin.name, pin.rank, pin.redundant) == ("pin_out", 3, 3)
    assert pin.indeterminate == dict.fromkeys(
        ("bearing_in", "pin_in", "joint_angle", "bearing_out", "pin_out"), "force xyz"
    )
    shown = str(report)
    assert "universal_joint: mobility 2" in shown
    assert "loop pin_out (continuous): rank 3 of 6, 3 redundant" in shown
    assert (
        "leaves open at bearing_in, bearing_out, joint_angle, pin_in, pin_out: force xyz" in shown
    )
    report = cd.describe(shaft)
    assert (report.coordinates, report.rank, report.mobility) == (9, 6, 3)
    assert report.loops[0].indeterminate == {}


def test_description_of_a_planar_four_bar() -> None:
    report = cd.describe(cd.load(four_bar(loop("continuous"))))
    assert report.mobility == 1
    assert report.loops[0].indeterminate == dict.fromkeys("abdc", "force z, moment xy")
    ball = cd.describe(cd.load(four_bar(loop("spherical"))))
    assert (ball.rank, ball.mobility) == (5, 1)
    opened = four_bar("")
    assert cd.describe(cd.load(opened)).mobility == 3


def test_couplings_are_closure_equations() -> None:
    train = coupling("ab", "a", "b", -2.0), coupling("bc", "b", "c", -3.0)
    report = cd.describe(cd.load(gears(*train, third=True)))
    assert (report.coordinates, report.rank, report.mobility) == (3, 2, 1)
    assert report.loops == []
    closed = gears(*train, coupling("ca", "c", "a", 1.0 / 6.0), third=True)
    assert cd.describe(cd.load(closed)).rank == 2


def test_open_chains_have_no_closure_equations() -> None:
    report = cd.describe(cd.load(gears()))
    assert (report.coordinates, report.rank, report.mobility) == (2, 0, 2)
    assert "table" not in report._repr_html_()


@pytest.mark.parametrize("count", [1, 2, 4])
def test_counted_ranks_are_the_measured_ones(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A line of `count` universal joints has 3 joints more per loop, and one drive."""
    mechanism = cd.load(drive_line(count))
    measured = cd.describe(mechanism)
    monkeypatch.setattr(module, "MOST_COORDINATES", 0)
    counted = cd.describe(mechanism)
    assert counted.is_counted
    assert not measured.is_counted
    for report in (measured, counted):
        assert (report.coordinates, report.rank, report.mobility) == (3 * count + 1, 3 * count, 1)
    for loop_counted, loop_measured in zip(counted.loops, measured.loops, strict=True):
        assert loop_counted.rank == loop_measured.rank == 3
        assert loop_counted.indeterminate is None
        assert loop_measured.indeterminate is not None
    assert str(counted).startswith("line: mobility 1 (counted)")
    assert "leaves open" not in str(counted)
    assert counted._repr_html_().count("<td>not examined</td>") == count


@pytest.mark.slow
def test_long_lines_are_measured_as_well() -> None:
    report = cd.describe(cd.load(drive_line(30)))
    assert not report.is_counted
    assert (report.coordinates, report.rank, report.mobility) == (91, 90, 1)
    (component,) = report.components
    assert component.self_stresses == 90


def test_a_singular_zero_does_not_decide_the_rank() -> None:
    """A parallelogram drawn flat: there, and nowhere else, one of its three equations is lost."""
    mechanism = described(
        *(link(name) for name in "abc"),
        hinge("A", "ground", "a"),
        hinge("B", "a", "b", (1.0, 0.0)),
        hinge("D", "ground", "c", (2.0, 0.0)),
        closing_pin("b", "c", (2.0, 0.0), (1.0, 0.0)),
    )
    report = cd.describe(mechanism)
    assert (report.coordinates, report.rank, report.mobility) == (4, 3, 1)
    # An outer dead centre is singular for its drive alone.
    report = cd.describe(cd.load("slider_crank"))
    assert (report.coordinates, report.rank, report.mobility) == (4, 3, 1)


def test_counting_misses_special_dimensions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three meshes with the same ratio are one equation; counted, they lock both wheels."""
    meshes = (coupling(name, "a", "b", -2.0) for name in ("first", "second", "third"))
    mechanism = cd.load(gears(*meshes))
    assert cd.describe(mechanism).rank == 1
    monkeypatch.setattr(module, "MOST_COORDINATES", 0)
    report = cd.describe(mechanism)
    assert (report.rank, report.mobility) == (2, 0)


def test_reports_are_the_same_each_time() -> None:
    mechanism = cd.load(four_bar(loop("continuous")))
    assert cd.describe(mechanism) == cd.describe(mechanism)


def test_loops_that_cannot_be_closed_are_refused() -> None:
    text = four_bar(loop("continuous"), rocker="9.0")
    with pytest.raises(
        cd.AssemblyError, match="four_bar: the loops cannot be closed; the least"
    ) as caught:
        cd.describe(cd.load(text))
    assert caught.value.residual > 0.1
    assert caught.value.position is None


def test_warnings_are_listed() -> None:
    text = four_bar(loop("continuous")).replace('<mass value="2"/>', '<mass value="0"/>')
    with pytest.raises(cd.ModelError):
        cd.load(text)
    mechanism = cd.load(text, strict=False)
    report = cd.describe(mechanism)
    (warning,) = report.warnings
    assert report.warnings == mechanism.warnings
    assert str(report).endswith(f"\n  warning: {warning}")
    assert "<li>warning: " in report._repr_html_()


def test_welds_that_close_loops_are_listed() -> None:
    """A planar four-bar whose coupler is cut in two and welded together again."""
    mechanism = described(
        *(link(name) for name in "abcd"),
        hinge("A", "ground", "a"),
        hinge("B", "a", "b", (0.0, 0.3)),
        hinge("D", "ground", "c", (1.0, 0.0)),
        hinge("E", "c", "d", (0.0, 0.8)),
        closing_pin("b", "d", (0.5, 0.25), (-0.5, -0.25)).replace("continuous", "fixed"),
    )
    report = cd.describe(mechanism)
    assert (report.rank, report.mobility) == (3, 1)
    (weld,) = report.loops
    assert weld.type == "fixed"
    assert weld.indeterminate == dict.fromkeys("ABDEC", "force z, moment xy")


def test_redundancy_between_loops_is_seen() -> None:
    """A third parallel crank adds a loop of rank 3, of which the second leaves two equations."""
    report = cd.describe(three_cranks())
    assert [loop.rank for loop in report.loops] == [3, 3]
    assert (report.rank, report.mobility) == (5, 1)
    (component,) = report.components
    assert component.self_stresses == 7
    for item in report.loops:
        assert item.indeterminate is not None
        # The crank is a member between two pins: in its plane it passes a force along its line.
        assert item.indeterminate["A"] == "force yz, moment xy"


def test_what_is_driven_first_is_told_first() -> None:
    """Motors, then what has limits, slides, hinges, and turns of balls."""
    kinds = {
        "ball": ("spherical", ""),
        "hinge": ("continuous", ""),
        "rail": ("prismatic", '<limit lower="-1e9" upper="1e9" effort="0" velocity="0"/>'),
        "flap": ("revolute", '<limit lower="-1" upper="1" effort="0" velocity="0"/>'),
        "ram": ("prismatic", '<limit lower="0" upper="1" effort="0" velocity="0"/>'),
        "motor": ("continuous", ""),
    }
    parts = ['<link name="base"/>']
    for name, (kind, limit) in kinds.items():
        own = ' independent="true"' * (name == "motor")
        parts.append(
            f'<link name="of_{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>'
            f'</inertial></link><joint name="{name}" type="{kind}"{own}><parent link="base"/>'
            f'<child link="of_{name}"/><axis xyz="0 0 1"/>{limit}</joint>'
        )
    report = cd.describe(cd.load(f'<robot name="all">{"".join(parts)}</robot>'))
    order = ["motor", "ram", "flap", "rail", "hinge", "ball.x", "ball.y", "ball.z"]
    assert list(report.drivable) == order
    assert f"can be driven or held: {', '.join(order)}" in str(report)
    legs = cd.describe(cd.load("stewart_platform")).drivable[:6]
    assert legs == tuple(f"leg_{index}" for index in range(1, 7))
