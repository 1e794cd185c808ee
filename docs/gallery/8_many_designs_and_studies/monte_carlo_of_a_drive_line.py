"""
Monte-Carlo of a drive line
===========================

How even is a double shaft that is assembled with tolerances? A study draws samples of angles and
fork phase, and computes them in chunks. It runs in this process here; on a cluster, hand
``cd.study`` a Dask ``client=`` in place of ``workers=1``, and a path as ``store=``, which keeps
what is finished if a worker dies.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import norm, uniform

import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.analytic import drive_line

nominal = {"joint_angle_1": 0.3, "joint_angle_2": 0.3, "fork_phase": 0.0}
scene = cd.Scene(cd.load("double_shaft_z"), drive="bearing_in", held=nominal, outputs=[])
turn = np.linspace(0.0, np.pi, 73)[:-1]


def assembled(**parts):
    """Return the residual angle of a chunk of samples [rad]."""
    held = {name: np.asarray(value)[..., None] for name, value in parts.items()}
    ratio = scene.sweep(turn, held=held).motion.ratio("bearing_out")
    # A single joint at β runs between cos β and 1 / cos β.
    return {"residual_angle": np.arccos(np.sqrt(ratio.min(axis=-1) / ratio.max(axis=-1)))}


tolerances = {
    "joint_angle_1": (norm(0.3, np.radians(0.2)), "rad"),
    "joint_angle_2": (norm(0.3, np.radians(0.2)), "rad"),
    "fork_phase": (uniform(-np.radians(0.5), np.radians(1.0)), "rad"),
}
study = cd.study(
    assembled,
    studies.samples(tolerances, 1024, seed=1),
    vectorized=True,
    units={"residual_angle": "rad"},
    workers=1,
)
data = study.run().dataset
found = data.residual_angle.to_numpy()

# Every sample against the closed form of a single joint that is as uneven.
betas = np.stack([data.joint_angle_1, data.joint_angle_2], axis=-1)
phases = drive_line.fork_phases([[0.0]], data.fork_phase.to_numpy()[:, None])
np.testing.assert_allclose(found, drive_line.residual_angle(betas, phases), rtol=2e-3)
limit = np.radians(3.0)
share = float(np.mean(found > limit))
print(f"{100.0 * share:.1f} % exceed 3°")

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.hist(np.degrees(found), bins=40)
axes.axvline(3.0, color="C3", label=f"limit of 3°: {100.0 * share:.0f} % exceed it")
axes.set(
    xlabel="residual angle [°]", ylabel="samples of 1024", title="Double shaft with tolerances"
)
axes.legend()
