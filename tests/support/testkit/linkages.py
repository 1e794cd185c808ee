"""Descriptions of linkages with real masses, closed in various ways."""

from __future__ import annotations

import numpy as np

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 41)
RATES = {"speed": 4.0, "acceleration": -7.0}
LINK = """<link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>
<inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
SLIDER = """<robot name="slider_crank"><link name="ground"/>
{crank}{rod}{slider}
<joint name="a" type="continuous"><parent link="ground"/><child link="crank"/>
  <axis xyz="0 0 1"/></joint>
<joint name="b" type="continuous"><parent link="crank"/><child link="rod"/>
  <origin xyz="0 0.3 0"/><axis xyz="0 0 1"/></joint>
{rest}</robot>"""
LIMIT = '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>'


def four_bar(
    loop: str,
    *,
    axis: str = "0 0 1",
    rocker: str = "2.5",
) -> str:
    """A planar four-bar in the x-y plane, closed by `loop` between coupler and rocker.

    Ground pivots 2 apart, crank 0.5, coupler and rocker such that it closes with all coordinates
    at zero: crank along y, coupler from (0, 0.5) to (2, 2.5), rocker from (2, 0) to (2, 2.5).
    """
    return f"""<robot name="four_bar"><link name="ground"/>
{LINK.format(name="crank", com="0 0.25 0", mass="1")}
{LINK.format(name="coupler", com="1 1 0", mass="2")}
{LINK.format(name="rocker", com="0 1.25 0", mass="3")}
<joint name="a" type="continuous"><parent link="ground"/><child link="crank"/>
  <origin xyz="0 0 0"/><axis xyz="{axis}"/></joint>
<joint name="b" type="continuous"><parent link="crank"/><child link="coupler"/>
  <origin xyz="0 0.5 0"/><axis xyz="{axis}"/></joint>
<joint name="d" type="continuous"><parent link="ground"/><child link="rocker"/>
  <origin xyz="2 0 0"/><axis xyz="{axis}"/></joint>
{loop.replace("ROCKER", rocker)}</robot>"""


def loop(kind: str, predecessor: str = "coupler", successor: str = "rocker") -> str:
    origins = {"coupler": "2 2 0", "rocker": "0 ROCKER 0", "ground": "2 0 0"}
    return (
        f'<loop name="c" type="{kind}"><predecessor link="{predecessor}">'
        f'<origin xyz="{origins[predecessor]}"/></predecessor><successor link="{successor}">'
        f'<origin xyz="{origins[successor]}"/></successor><axis xyz="0 0 1"/></loop>'
    )


def slider_crank(guide: str | None) -> str:
    """Crank 0.3, rod 1.0, slider on the x axis; closed at its pin or else at its guide."""
    reach = float(np.sqrt(1.0 - 0.09))
    tip = f"{reach!r} -0.3 0"
    if guide is None:
        rest = (
            f'<joint name="d" type="prismatic"><parent link="ground"/><child link="slider"/>'
            f'<origin xyz="{reach!r} 0 0"/><axis xyz="1 0 0"/>'
            '<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
            f'<loop name="c" type="continuous"><predecessor link="rod"><origin xyz="{tip}"/>'
            '</predecessor><successor link="slider"/><axis xyz="0 0 1"/></loop>'
        )
    else:
        rest = (
            f'<joint name="c" type="continuous"><parent link="rod"/><child link="slider"/>'
            f'<origin xyz="{tip}"/><axis xyz="0 0 1"/></joint>'
            f'<loop name="d" type="{guide}"><predecessor link="ground">'
            f'<origin xyz="{reach!r} 0 0"/></predecessor><successor link="slider"/>'
            '<axis xyz="1 0 0"/></loop>'
        )
    links = {
        "crank": LINK.format(name="crank", com="0 0.1 0", mass="1"),
        "rod": LINK.format(name="rod", com="0.4 -0.1 0", mass="2"),
        "slider": LINK.format(name="slider", com="0 0 0", mass="3"),
    }
    return SLIDER.format(**links, rest=rest)


def tilted_slider_crank(length: float, planar: bool) -> str:
    """A slider-crank that lies anyhow in space; its piston slides on a rail or in a plane."""

    def origin(*xyz: float, rpy: str = "0 0 0") -> str:
        return f'<origin xyz="{" ".join(repr(length * x) for x in xyz)}" rpy="{rpy}"/>'

    guide = ("planar", "0 0 1") if planar else ("prismatic", "1 0 0")
    rail = (
        f'<link name="rail"/><joint name="rail_guide" type="prismatic"><parent link="base"/>'
        f'<child link="rail"/>{origin(3, 0.2, 0)}<axis xyz="1 0 0"/>{LIMIT}</joint>'
        '<loop name="bolt" type="fixed"><predecessor link="piston"/><successor link="rail"/></loop>'
    )
    return f"""<robot name="crank"><link name="world"/><link name="base"/><link name="crank"/>
      <link name="rod"/><link name="piston"/>{rail if planar else ""}
      <joint name="mount" type="fixed"><parent link="world"/><child link="base"/>
        {origin(1, 2, 3, rpy="0.3 0.4 0.5")}</joint>
      <joint name="crank_bearing" type="continuous"><parent link="base"/><child link="crank"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="crank_pin" type="continuous"><parent link="crank"/><child link="rod"/>
        {origin(1, 0, 0)}<axis xyz="0 0 1"/></joint>
      <joint name="guide" type="{guide[0]}"><parent link="base"/><child link="piston"/>
        {origin(3, 0.2, 0)}<axis xyz="{guide[1]}"/>{LIMIT}</joint>
      <loop name="piston_pin" type="continuous"><predecessor link="rod">{origin(2, 0.2, 0)}
        </predecessor><successor link="piston"/><axis xyz="0 0 1"/></loop></robot>"""


def carriage(length: float) -> str:
    """A carriage s along x with an arm that turns about the y-axis h through its origin, welded."""
    return f"""<robot name="carriage"><link name="ground"/><link name="carriage"/><link name="arm"/>
      <joint name="s" type="prismatic"><parent link="ground"/><child link="carriage"/>
        <axis xyz="1 0 0"/>{LIMIT}</joint>
      <joint name="h" type="continuous"><parent link="carriage"/><child link="arm"/>
        <origin xyz="0 {length!r} 0"/><axis xyz="0 1 0"/></joint>
      <loop name="weld" type="fixed"><predecessor link="arm"/><successor link="ground">
        <origin xyz="0 {length!r} 0"/></successor></loop></robot>"""


def gears(*couplings: str, third: bool = False) -> str:
    """Wheels about parallel axes on the ground."""
    names = ("a", "b", "c") if third else ("a", "b")
    wheels = "".join(
        LINK.format(name=f"wheel_{name}", com="0 0 0", mass=str(k + 1))
        + f'<joint name="{name}" type="continuous"><parent link="ground"/>'
        f'<child link="wheel_{name}"/><origin xyz="{k} 0 0"/><axis xyz="0 0 1"/></joint>'
        for k, name in enumerate(names)
    )
    return f'<robot name="gears"><link name="ground"/>{wheels}{"".join(couplings)}</robot>'


def coupling(name: str, first: str, second: str, ratio: float, stated: str = "") -> str:
    """Couple two wheels; what is stated are attributes of the coupling."""
    return (
        f'<coupling name="{name}" {stated}><predecessor link="wheel_{first}"/>'
        f'<successor link="wheel_{second}"/><ratio value="{ratio!r}"/></coupling>'
    )


def rack(first: str, second: str) -> str:
    """A wheel (joint a) and a rack (joint b); two of the links are coupled with the ratio -0.3."""
    return f"""<robot name="rack"><link name="ground"/>
      {LINK.format(name="wheel", com="0 0 0", mass="1")}
      {LINK.format(name="rack", com="0 5 0", mass="1")}
      <joint name="a" type="continuous"><parent link="ground"/><child link="wheel"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="b" type="prismatic"><parent link="ground"/><child link="rack"/>
        <origin xyz="0 4 0"/><axis xyz="1 0 0"/>{LIMIT}</joint>
      <coupling name="mesh"><predecessor link="{first}"/><successor link="{second}"/>
        <ratio value="-0.3"/></coupling></robot>"""


HINGE = '<joint name="{}" axis="0 0 1"/>'
BODY = '<inertial pos="0.01 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>'


def neck(longer: float) -> str:
    """A head on three rods side by side, closed by frames at zero; one rod is longer by so much."""
    rods = "".join(
        f'<body name="{name}" pos="{x} {y} 0.3" quat="0.844862 0 0 0.534985">{BODY}'
        f"{HINGE.format(name)}{{}}</body>"
        for name, x, y in (("arm", 0, 0), ("left", 0.0072, 0.0019), ("right", -0.0072, -0.0019))
    )
    pins = "".join(
        f'<body name="{name}" pos="{x!r} {y!r} 0.01">{BODY}{HINGE.format(name)}</body>'
        for name, x, y in (
            ("left_pin", 0.00479615 + longer, -0.00569622),
            ("right_pin", -0.00479615, 0.00569622),
        )
    )
    on_plate = f"{BODY}{HINGE.format('plate')}{pins}"
    plate = f'<body name="plate" pos="0.042406 0 0">{on_plate}</body>'
    welds = "".join(f'<weld body1="{name}" body2="{name}_pin"/>' for name in ("left", "right"))
    return (
        f'<mujoco model="neck"><worldbody>{rods.format(plate, "", "")}</worldbody>'
        f"<equality>{welds}</equality></mujoco>"
    )
