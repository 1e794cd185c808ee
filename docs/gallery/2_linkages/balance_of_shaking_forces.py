"""
Balancing the shaking force of a slider-crank
=============================================

A counterweight on the crank can take the rotating masses away, and half of the first order of
what goes to and fro; the orders of the piston itself stay. The amplitudes of a crank of 45 and a
rod of 150 mm are those of the series in every textbook: λ + λ³/4 + 15 λ⁵/128 … in second order,
and λ³/4 + 3 λ⁵/16 … in fourth.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd


def machine(counterweight):
    """Return a slider-crank whose rod is a mass at each end, and a crank with so many kg m."""
    body = '<inertial><origin xyz="{} 0 0"/><mass value="{}"/>'
    body += '<inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial>'
    hinge = '<axis xyz="0 0 1"/>'
    return cd.load(f"""<robot name="engine"><link name="frame"/>
      <link name="crank">{body.format(-counterweight / 3.0, 3.0)}</link>
      <link name="rod">{body.format(0.0, 0.7)}</link>
      <link name="piston">{body.format(0.0, 1.6)}</link>
      <joint name="bearing" type="continuous">
        <parent link="frame"/><child link="crank"/>{hinge}</joint>
      <joint name="crank_pin" type="continuous"><parent link="crank"/><child link="rod"/>
        <origin xyz="0.045 0 0"/>{hinge}</joint>
      <joint name="guide" type="prismatic"><parent link="frame"/><child link="piston"/>
        <origin xyz="0.195 0 0"/><axis xyz="1 0 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
      <loop name="piston_pin" type="continuous">{hinge}
        <predecessor link="rod"><origin xyz="0.15 0 0"/></predecessor>
        <successor link="piston"/></loop></robot>""")


speed, ratio = 50.0 * np.pi, 0.3
angle = np.linspace(0.0, 2.0 * np.pi, 721)
figure, axes = plt.subplots(figsize=(5.6, 5.0), layout="constrained")
rotating, sliding = 0.7 * 0.045, 1.6 * 0.045
for name, weight in (
    ("no counterweight", 0.0),
    ("rotating masses balanced", rotating),
    ("and half of the piston", rotating + 0.5 * sliding),
):
    turn = cd.Scene(machine(weight), drive="bearing").sweep(angle, speed=speed)
    wrenches = [turn.wrench(joint, "world").force for joint in ("bearing", "guide")]
    force = -sum(wrenches)  # of the machine on its bed
    axes.plot(force[:, 0], force[:, 1], label=name)
    orders = 2.0 * np.fft.rfft(force[:-1, 0]).real / 720 / (sliding * speed**2)
    across = 2.0 * np.abs(np.fft.rfft(force[:-1, 1]))[1] / 720 / (sliding * speed**2)
    left = (rotating - weight) / sliding
    np.testing.assert_allclose([orders[1], across], [1.0 + left, abs(left)], atol=1e-12)
    second = ratio + ratio**3 / 4.0 + 15.0 * ratio**5 / 128.0 + 35.0 * ratio**7 / 512.0
    fourth = -(ratio**3) / 4.0 - 3.0 * ratio**5 / 16.0 - 35.0 * ratio**7 / 256.0
    np.testing.assert_allclose(orders[[2, 4]], [second, fourth], rtol=4e-3)
axes.set(xlabel="force on the bed along the cylinder [N]", ylabel="across it [N]", aspect="equal")
axes.set_title("Shaking force over a turn at 1500 rpm")
axes.legend(fontsize=8)
