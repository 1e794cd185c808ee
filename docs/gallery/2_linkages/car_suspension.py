"""
Double wishbone of a car
========================

Two wishbones of unequal length guide the wheel: as it rises, its top leans inwards, so that it
stays upright on the road while the body rolls. Camber is checked against circles in the view from
the front, and the forces of the rods against the six equations of the wheel carrier.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

# x forwards, y outwards, z up [m]; the balls of the carrier and the hinges, which lie along x.
LOWER, UPPER, TIE = np.array([[0.0, 0.70, 0.20], [0.0, 0.65, 0.50], [-0.12, 0.68, 0.28]])
LOWER_HINGE, UPPER_HINGE, RACK = np.array(
    [[0.0, 0.35, 0.22], [0.0, 0.40, 0.48], [-0.12, 0.36, 0.29]]
)
CONTACT = np.array([0.0, 0.76, 0.0])


def xyz(place):
    return f'<origin xyz="{place[0]} {place[1]} {place[2]}"/>'


car = cd.load(f"""<robot name="double_wishbone">
  <link name="body"/> <link name="lower"/> <link name="upper"/> <link name="carrier"/>
  <link name="tie"/>
  <joint name="lower_hinge" type="continuous"><parent link="body"/><child link="lower"/>
    {xyz(LOWER_HINGE)}<axis xyz="1 0 0"/></joint>
  <joint name="upper_hinge" type="continuous"><parent link="body"/><child link="upper"/>
    {xyz(UPPER_HINGE)}<axis xyz="1 0 0"/></joint>
  <joint name="lower_ball" type="spherical"><parent link="lower"/><child link="carrier"/>
    {xyz(LOWER - LOWER_HINGE)}</joint>
  <joint name="rack" type="universal"><parent link="body"/><child link="tie"/>
    {xyz(RACK)}<axis xyz="1 0 0"/><axis2 xyz="0 0 1"/></joint>
  <loop name="upper_ball" type="spherical">
    <predecessor link="upper">{xyz(UPPER - UPPER_HINGE)}</predecessor>
    <successor link="carrier">{xyz(UPPER - LOWER)}</successor></loop>
  <loop name="tie_ball" type="spherical">
    <predecessor link="tie">{xyz(TIE - RACK)}</predecessor>
    <successor link="carrier">{xyz(TIE - LOWER)}</successor></loop>
</robot>""")
push = np.array([-1500.0, 800.0, 4000.0])  # N, braking in a bend
load = cd.Wrench(push, frame="world", point=CONTACT - LOWER)
scene = cd.Scene(car, drive="lower_hinge", loads={"carrier": load})
rise = scene.sweep(np.radians(np.linspace(-14.0, 14.0, 141)))

# Camber: the line of both balls moves like a planar four-bar.
low = LOWER_HINGE[1:] @ [1, 1j] + ((LOWER - LOWER_HINGE)[1:] @ [1, 1j]) * np.exp(1j * rise.position)
way = UPPER_HINGE[1:] @ [1, 1j] - low
post, arm = np.linalg.norm(UPPER - LOWER), np.linalg.norm(UPPER - UPPER_HINGE)
along = (np.abs(way) ** 2 + post**2 - arm**2) / (2.0 * np.abs(way))
line = way / np.abs(way) * (along - 1j * np.sqrt(post**2 - along**2))
ball, top = rise.origin("lower_ball"), rise.origin("upper_ball")
np.testing.assert_allclose((top - ball)[:, 1:] @ [1, 1j], line, atol=1e-13)

# Free body of the carrier: three forces at each ball, one along the tie rod; the upper wishbone
# is light,
# so that its ball has no moment about its hinge.
tie, contact = rise.origin("tie_ball"), rise.point("carrier", CONTACT - LOWER).position
rod = (tie - RACK) / np.linalg.norm(tie - RACK, axis=1, keepdims=True)
matrix, right = np.zeros((141, 7, 7)), np.zeros((141, 7))
matrix[:, :3, :3] = matrix[:, :3, 3:6] = np.eye(3)
matrix[:, :3, 6], matrix[:, 3:6, 6] = rod, np.cross(tie - ball, rod)
matrix[:, 3:6, 3:6] = np.cross((top - ball)[:, None], np.eye(3)).swapaxes(1, 2)
matrix[:, 6, 4], matrix[:, 6, 5] = -(top - UPPER_HINGE)[:, 2], (top - UPPER_HINGE)[:, 1]
right[:, :3], right[:, 3:6] = -push, -np.cross(contact - ball, push)
found = np.linalg.solve(matrix, right[..., None])[..., 0]
for name, columns in (("lower_ball", slice(0, 3)), ("upper_ball", slice(3, 6))):
    np.testing.assert_allclose(rise.wrench(name, "world").force, found[:, columns], atol=1e-7)

travel = 1e3 * (contact[:, 2] - contact[70, 2])
upright = rise.point("carrier").orientation[:, :, 1]  # the wheel's axle
camber = np.degrees(np.arcsin(upright[:, 2]))
figure, (first, second) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
first.plot(camber, travel, label="camber")
first.plot(np.degrees(np.arctan2(upright[:, 0], upright[:, 1])), travel, "--", label="toe")
first.set(xlabel="angle of the axle [°]", ylabel="wheel travel [mm]")
for label, force in (
    ("lower ball", np.linalg.norm(found[:, :3], axis=1)),
    ("upper ball", np.linalg.norm(found[:, 3:6], axis=1)),
    ("tie rod", np.abs(found[:, 6])),
):
    second.plot(travel, force, label=label)
second.set(xlabel="wheel travel [mm]", ylabel="force [N]", title="1.5 kN brake, 4 kN on the road")
first.legend()
second.legend()
