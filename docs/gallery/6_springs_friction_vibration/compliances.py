"""
Elastic bearings share what statics leaves open
===============================================

A door on two hinges: statics does not say which of them carries its weight. With ``compliance=``
for the joints that give way, the package returns what makes the elastic energy least. Side by
side, that is textbook: springs share a load as their stiffnesses do.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

# A beam on two hinges in line: its weight along the common axis is carried by either of them.
hanging = cd.load("""<robot name="door"><link name="frame"/><link name="door"/>
  <joint name="upper" type="continuous"><parent link="frame"/><child link="door"/>
    <origin xyz="0 0 1.6"/><axis xyz="0 0 1"/></joint>
  <loop name="lower" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="frame"><origin xyz="0 0 0.2"/></predecessor>
    <successor link="door"><origin xyz="0 0 -1.4"/></successor></loop></robot>""")
weight = cd.Wrench((0.0, 0.0, -300.0), frame="world", point=(0.45, 0.0, -0.7))
scene = cd.Scene(hanging, drive="upper", loads={"door": weight})
least = scene.sweep(0.0)
assert not least["upper"].unique[2]

# Hinges that give way by 1e-6 m/N and 1e-5 rad/(N·m), the lower one otherwise along z.
ratios = np.geomspace(0.05, 20.0, 25)
shares, pulls = [], []
for ratio in ratios:
    upper = [1e-6] * 3 + [1e-5] * 3
    lower = [1e-6, 1e-6, ratio * 1e-6] + [1e-5] * 3
    turn = scene.replace(compliance={"upper": upper, "lower": lower}).sweep(0.0)
    shares.append(turn["upper"].force[0, 2])
    pulls.append(turn["upper"].force[0, 0])
# Springs side by side: forces are as their stiffnesses; the moment of the weight is a pair of
# forces.
np.testing.assert_allclose(shares, 300.0 * ratios / (1.0 + ratios), rtol=1e-9)
# Least energy of a pair of forces X and two moments M: 2 c X² + 2 m M² with 1.4 X + 2 M = 135 N·m.
pair = 300.0 * 0.45 / (1.4 + 4.0 * 1e-6 / (1.4 * 1e-5))
np.testing.assert_allclose(np.abs(pulls), pair, rtol=1e-9)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.semilogx(ratios, shares, label="upper hinge, vertical")
axes.semilogx(ratios, 300.0 - np.array(shares), label="lower hinge, vertical")
axes.semilogx(ratios, np.abs(pulls), "k--", label="both, horizontal")
axes.set(xlabel="lower compliance / upper compliance", ylabel="force [N]")
axes.set_title("A door of 300 N on two hinges")
axes.legend()
