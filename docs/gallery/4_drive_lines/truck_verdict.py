"""
A truck's drive line before the rules of practice
=================================================

A line of shafts from a file, with its duty cycle, held against every rule that its data allow: a
row has the exact value, the limit with its source, and the margin. Where a rule of practice is an
approximation, the row says what it gives instead. Three rows are done by hand here, from the
numbers of the file.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn.drive_lines as dl

truck = dl.DriveLine.from_toml("truck")
verdict = truck.verdict()
print(verdict.summary)
# Nothing is missed. What is open are forces of bearings in gearbox and axle, whose limits the file
# does not say, and torsional critical speeds, for which their inertias are missing.
assert not verdict.failed
print({(row.rule, row.note) for row in verdict.open})
rows = verdict.to_dataframe()


def value(where, quantity):
    """Return the exact value of a row."""
    return float(rows[(rows["where"] == where) & (rows.quantity == quantity)].value.iloc[0])


# Slopes of 4, 5, 8.5 and 4.86° in one view make angles of 1, 3.5 and 3.64°.
assert round(np.degrees(value("joint_3", "joint angle")), 6) == 3.64
# Forks in line: the second joint works against both others, cos β_E = cos β₁ cos β₃ / cos β₂.
cosines = np.cos(np.radians([1.0, 3.5, 3.64]))
product = cosines[0] * cosines[2] / cosines[1]
np.testing.assert_allclose(value("axle", "residual angle"), np.arccos(product), rtol=1e-9)
# Shear in the tube of 110 × 5.5 mm under 12 kN·m: 16 T D / (π (D⁴ - d⁴)).
stress = 16.0 * 12e3 * 0.11 / (np.pi * (0.11**4 - 0.099**4))
np.testing.assert_allclose(value("coupling_shaft", "shear stress up to T·K"), stress, rtol=3e-4)

judged = rows[rows.margin.notna()].sort_values("margin").head(14)
figure, axes = plt.subplots(figsize=(7.6, 4.6), layout="constrained")
axes.barh(judged["where"] + ": " + judged.quantity, 100.0 * judged.margin)
axes.tick_params(axis="y", labelsize=7)
axes.set(xlabel="margin to the limit [%]", title="Truck: the rows that are closest to their limit")
