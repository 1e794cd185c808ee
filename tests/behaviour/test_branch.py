"""Branches are never followed past where assembly modes meet."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd

LINK = (
    '<link name="{0}"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx=".01" '
    'iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)


def parallelogram(crank: float, base: float, lean: float) -> str:
    """Assembly modes meet where all links are in line: crank at ±π/2 from upright."""
    tip = f"{-crank * np.sin(lean)!r} {crank * np.cos(lean)!r} 0".replace("np.float64", "")
    tip = tip.replace("(", "").replace(")", "")
    links = "".join(LINK.format(name) for name in "abc")
    return f"""<robot name="parallelogram"><link name="ground"/>{links}
<joint name="A" type="continuous"><parent link="ground"/><child link="a"/>
  <axis xyz="0 0 1"/></joint>
<joint name="B" type="continuous"><parent link="a"/><child link="b"/>
  <origin xyz="{tip}"/><axis xyz="0 0 1"/></joint>
<joint name="D" type="continuous"><parent link="ground"/><child link="c"/>
  <origin xyz="{base} 0 0"/><axis xyz="0 0 1"/></joint>
<loop name="C" type="continuous"><predecessor link="b"><origin xyz="{base} 0 0"/></predecessor>
  <successor link="c"><origin xyz="{tip}"/></successor><axis xyz="0 0 1"/></loop></robot>"""


@pytest.mark.parametrize(
    ("crank", "base", "lean"),
    [
        (1.0, 2.0, 0.0),
        (0.5, 2.0, 0.0),
        (0.6884100539236251, 1.8549032498426308, -0.38007837606199213),
        (0.9627273973468053, 1.2553406364634119, -0.7546186796478531),
        (0.3, 0.31, 0.6),
    ],
)
def test_no_branch_leads_past_where_assembly_modes_meet(
    crank: float, base: float, lean: float
) -> None:
    """Beyond it a parallelogram and an antiparallelogram go on, and neither is the right one."""
    mechanism = cd.load(parallelogram(crank, base, lean))
    low, high = -np.pi / 2.0 - lean, np.pi / 2.0 - lean
    limits = cd.Scene(mechanism, drive="A").motion_range()
    assert limits == pytest.approx((low, high), abs=5e-6)
    scene = cd.Scene(mechanism, drive="A", loads={"D": -3.0})
    for _ in range(3):
        for beyond in (low - 0.4, high + 0.3, 6.4, -20.0):
            with pytest.raises(cd.SingularConfigurationError, match="the way on is not unique"):
                scene.sweep([0.0, beyond])
        near = np.array([low + 1e-3, 0.0, high - 1e-3])
        turn = scene.sweep(near)
        np.testing.assert_allclose(turn.motion.position("D"), near, atol=1e-11)
        # The rounding of the description itself is magnified by the distance squared.
        np.testing.assert_allclose(turn.drive_effort, 3.0, rtol=1e-8)
