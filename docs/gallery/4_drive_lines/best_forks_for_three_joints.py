"""
Best forks for a line of three joints
=====================================

With d = -ln cos β for each joint, forks can close a line exactly if no d exceeds the sum of all
others, and what is left otherwise is the difference. Branch and bound puts the forks on the teeth
of a spline; what it returns is proven best.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn.drive_lines as dl

line = dl.DriveLine.from_toml("""
speed_rpm = 3000
torque_nm = 400
[[shafts]]
slope_side_deg = 0
bearings = [{ distance_mm = 60 }, { distance_mm = 180 }]
[[shafts]]
length = "1.0 m"
slope_side_deg = 4
bearings = [{ distance_mm = 850 }]
[[shafts]]
length = "1.2 m"
slope_side_deg = 6
slope_plan_deg = 3
spline = { friction = 0.1, radius_mm = 25 }
[[shafts]]
slope_side_deg = -1
bearings = [{ distance_mm = 70 }, { distance_mm = 220 }]
""")
miss = -np.log(np.cos(line.joint_angles))
left = max(2.0 * miss.max() - miss.sum(), 0.0)
best, on_teeth = line.phasing(), line.phasing(teeth=24)
np.testing.assert_allclose(best.value, np.arccos(np.exp(-left)), rtol=1e-8)
assert best.proven and on_teeth.proven

# All 24 × 24 ways to put the splines, tried.
offsets = np.radians(np.arange(24) * 15.0)
grid = np.stack(np.meshgrid(offsets, offsets, indexing="ij"), axis=-1).reshape(-1, 2)
positions = np.linspace(0.0, np.pi, 61)
ratio = line.analyse(variants=line.variants(fork_offsets=grid), positions=positions).ratio[..., -1]
residual = np.arccos(np.sqrt(ratio.min(axis=1) / ratio.max(axis=1)))
np.testing.assert_allclose(residual.min(), on_teeth.value, rtol=1e-3)

figure, axes = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
drawn = axes.pcolormesh(*np.degrees([offsets, offsets]), np.degrees(residual).reshape(24, 24).T)
figure.colorbar(drawn, label="residual angle [°]")
axes.plot(*np.degrees(np.mod(on_teeth.fork_offsets, 2.0 * np.pi)), "r*", markersize=14)
axes.set(xlabel="forks of shaft 2 [°]", ylabel="forks of shaft 3 [°]", title="Splines of 24 teeth")
