"""
Landing gear with an over-centre lock
=====================================

A folding strut holds the leg of a landing gear. Once its knee has passed the line between the
strut's ends, drag on the wheel presses it against a stop instead of folding it: the moment that
the strut needs changes its sign there. How firm the lock is follows from the lever arm of its
lower half.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd


def planar(at, joints, loops):
    """Return a linkage that moves in the plane, its pins being `at` complex places [m] at zero."""
    where, text = {"frame": 0j}, '<link name="frame"/>'

    def origin(joint, link):
        place = at[joint] - where[link]
        return f'<origin xyz="{place.real} {place.imag} 0"/>'

    for joint, parent, child in joints:
        text += f'<link name="{child}"/><joint name="{joint}" type="continuous">'
        text += f'<parent link="{parent}"/><child link="{child}"/>{origin(joint, parent)}'
        text += '<axis xyz="0 0 1"/></joint>'
        where[child] = at[joint]
    for joint, one, other in loops:
        text += f'<loop name="{joint}" type="continuous"><axis xyz="0 0 1"/>'
        text += f'<predecessor link="{one}">{origin(joint, one)}</predecessor>'
        text += f'<successor link="{other}">{origin(joint, other)}</successor></loop>'
    return cd.load(f'<robot name="linkage">{text}</robot>')


# The leg hangs from A. Its strut from D by the knee K to B is just straight at zero: 1.5 m.
top, pin = 0.9 + 0.3j, -0.9j
gear = planar(
    {"A": 0j, "D": top, "K": top + 0.8 * (pin - top) / 1.5, "B": pin},
    [("A", "frame", "leg"), ("D", "frame", "upper"), ("K", "upper", "lower")],
    [("B", "lower", "leg")],
)
drag = cd.Wrench((10e3, 0.0, 0.0), frame="world", point=(0.0, -1.6, 0.0))  # at the wheel's axle
angle = np.radians(np.linspace(-20.0, 8.0, 281))
turn = cd.Scene(gear, drive="D", loads={"leg": drag}).sweep(angle)

# By free bodies: the lower half is a rod. Its force balances the drag about A, and turns D.
at = {name: turn.origin(name)[:, :2] @ [1.0, 1j] for name in "ADKB"}
axle = at["B"] / 0.9 * 1.6
rod = (at["B"] - at["K"]) / np.abs(at["B"] - at["K"])
force = 10e3 * axle.imag / np.imag(np.conj(at["B"]) * rod)
moment = force * np.imag(np.conj(at["K"] - at["D"]) * rod)
np.testing.assert_allclose(turn.drive_effort, moment, atol=1e-7)
np.testing.assert_allclose(turn["K"].shear, np.abs(force), rtol=1e-9)
# The lock: no moment on the line, and of the other sign on either side.
assert abs(np.interp(0.0, angle, turn.drive_effort)) < 1e-6
assert turn.drive_effort[0] * turn.drive_effort[-1] < 0.0

figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
for sample, colour in ((0, "0.7"), (100, "0.5"), (280, "C0")):
    for line in (["A", "B"], ["D", "K", "B"]):
        points = np.array([at[name][sample] for name in line])
        left.plot(points.real, points.imag, "o-", color=colour)
    left.plot(axle[sample].real, axle[sample].imag, "o", color=colour, markersize=18)
left.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Folded by 20°, 10°, locked by 8°")
right.plot(np.degrees(angle), turn.drive_effort / 1e3)
right.axhline(0.0, color="0.7")
right.set(xlabel="strut beyond its line [°]", ylabel="moment that the strut needs [kN·m]")
right.set_title("10 kN of drag")
