"""
Full force balance of a four-bar
================================

A counterweight on the crank and one on the rocker can keep the common centre of mass at rest, so
that no force shakes the bed (Berkof and Lowen, 1969). Where they have to be is a linear
least-squares problem in their places; it is solved here from a random start, and found where the
closed form has it. The shaking moment rises meanwhile: what to look at depends on the bed.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import Bounds, least_squares

import cardan_dyn as cd

CRANK, COUPLER, ROCKER, FRAME = 0.08, 0.40, 0.25, 0.47


def link(name, mass, x=0.0, y=0.0, inertia=0.0):
    return f"""<link name="{name}"><inertial><origin xyz="{x} {y} 0"/><mass value="{mass}"/>
      <inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}"/></inertial></link>"""


def hinge(name, parent, child, x):
    return f"""<joint name="{name}" type="continuous"><parent link="{parent}"/>
      <child link="{child}"/><origin xyz="{x} 0 0"/><axis xyz="0 0 1"/></joint>"""


def weight(name, mass, on):
    """Return a point mass on a link, whose place is a fixed joint's."""
    return f"""{link(name, mass)}<joint name="{name}" type="fixed"><parent link="{on}"/>
      <child link="{name}"/></joint>"""


bar = cd.load(f"""<robot name="bar"><link name="base"/>
  {link("crank", 1.5, 0.03, 0.0, 0.002)}{link("coupler", 1.6, 0.2, 0.01, 0.029)}
  {link("rocker", 2.3, 0.09, 0.0, 0.006)}
  {weight("crank_weight", 2.0, "crank")}{weight("rocker_weight", 3.0, "rocker")}
  {hinge("crank_bearing", "base", "crank", 0.0)}{hinge("crank_pin", "crank", "coupler", CRANK)}
  {hinge("rocker_bearing", "base", "rocker", FRAME)}
  <loop name="rocker_pin" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="coupler"><origin xyz="{COUPLER} 0 0"/></predecessor>
    <successor link="rocker"><origin xyz="{ROCKER} 0 0"/></successor></loop></robot>""")
places = [f"origin:{name}_weight.{axis}" for name in ("crank", "rocker") for axis in "xy"]
scene = cd.Scene(
    bar, drive="crank_bearing", held=dict.fromkeys(places, 0.0), near={"rocker_bearing": 1.9}
)
angle = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
bearings = ("crank_bearing", "rocker_bearing")


def shaking(sweep):
    """Force of the links on the bed, in the plane, in a row [N]."""
    return -sum(sweep.wrench(name, "world").force for name in bearings)[:, :2].ravel()


def change(sweep, by):
    # The axes of both bearings turn as before, wherever the weights are. Across the plane, forces
    # are not unique.
    turned = (sweep.rotation(name)[:, :2, :2] @ by[name].force[:, :2, None] for name in bearings)
    return -sum(turned).ravel()


variables = cd.DesignVariables(
    lambda places: scene.sweep(angle, speed=20.0, held=places),
    dict.fromkeys(places, ("-300 mm", "300 mm")),
)
force = variables.quantity(shaking, change)
(start,) = variables.starts(1, seed=1)
best = least_squares(force, start, jac=force.jac, bounds=Bounds(*variables.bounds), xtol=1e-15)
found = variables.values(best.x)

# Static moments [kg m] that balance all of the links, of complex numbers in the links' axes.
on_coupler = 1.6 * (0.2 + 0.01j)
crank = -1.6 * CRANK + on_coupler * CRANK / COUPLER - 1.5 * 0.03
rocker = -on_coupler * ROCKER / COUPLER - 2.3 * 0.09
wanted = [crank.real / 2.0, crank.imag / 2.0, rocker.real / 3.0, rocker.imag / 3.0]
np.testing.assert_allclose(list(found.values()), wanted, rtol=0.0, atol=1e-9)

figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.8), layout="constrained")
for label, moved in (("without", dict.fromkeys(places, 0.0)), ("balanced", found)):
    # Without weights that lie on the bearings, nothing of them shakes either.
    turn = scene.sweep(angle, speed=20.0, held=moved)
    x, y = shaking(turn).reshape(-1, 2).T
    first, second = (turn.wrench(name, "world") for name in bearings)
    moment = -(first.moment + second.moment)[:, 2] - FRAME * second.force[:, 1]
    left.plot(x, y, ".-", label=label)
    right.plot(np.degrees(angle), moment, label=label)
    shaken = [np.sqrt(np.mean(x**2 + y**2)), np.sqrt(np.mean(moment**2))]
    print(f"{label}: {shaken[0]:.6g} N, {shaken[1]:.6g} N·m")
    expected = {"without": [75.78352732842876, 4.808833604338], "balanced": [0.0, 12.969106258062]}
    np.testing.assert_allclose(shaken, expected[label], rtol=1e-10, atol=1e-9)
left.set(xlabel="shaking force, x [N]", ylabel="y [N]", aspect="equal")
right.set(xlabel="crank [°]", ylabel="shaking moment [N·m]")
left.legend()
