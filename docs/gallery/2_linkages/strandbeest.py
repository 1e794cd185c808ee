"""
Strandbeest
===========

Theo Jansen's leg walks by thirteen lengths, his "holy numbers". A crank turns, and the foot goes
straight back on the ground and up and forward in the air. Its path is checked against the same
leg built by intersections of circles, position by position.
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


def meet(one, radius_1, other, radius_2, side):
    """Return where two circles meet, on the left (1) or right (-1) of the way from one to other."""
    way = other - one
    along = (abs(way) ** 2 + radius_1**2 - radius_2**2) / (2.0 * abs(way))
    return one + way / abs(way) * (along + 1j * side * np.sqrt(radius_1**2 - along**2))


def leg(crank):
    """Return the joints of Jansen's leg by circles, in his letters for lengths [m]."""
    a, b, c, d, e, f, g, h, i, j, k, m = 0.01 * np.array(
        [38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49.0, 50.0, 61.9, 15.0]
    )
    tip = m * np.exp(1j * crank)
    fixed = -a - 0.078j + 0.0 * tip
    knee = meet(tip, j, fixed, b, -1)
    hip = meet(fixed, d, knee, e, 1)
    lower = meet(tip, k, fixed, c, 1)
    ankle = meet(hip, f, lower, g, -1)
    foot = meet(ankle, h, lower, i, -1)
    return {"B": fixed, "M": tip, "K": knee, "H": hip, "L": lower, "A": ankle, "foot": foot}


at = {name: complex(place) for name, place in leg(0.0).items()}
beest = planar(
    {"crank": 0j, "B1": at["B"], "B2": at["B"], "M1": at["M"], "M2": at["M"], "K": at["K"]}
    | {"H": at["H"], "L1": at["L"], "L2": at["L"], "A": at["A"]},
    [
        ("crank", "frame", "wheel"),
        ("B1", "frame", "triangle"),
        ("B2", "frame", "c"),
        ("M1", "wheel", "j"),
        ("M2", "wheel", "k"),
        ("H", "triangle", "f"),
        ("L1", "c", "shin"),
    ],
    [("K", "j", "triangle"), ("L2", "k", "c"), ("A", "f", "shin")],
)
angle = np.linspace(0.0, 2.0 * np.pi, 361)
turn = cd.Scene(beest, drive="crank").sweep(angle)
offset = at["foot"] - at["L"]
foot = turn.point("shin", (offset.real, offset.imag, 0.0)).position
by_hand = leg(angle)
np.testing.assert_allclose(foot[:, 0] + 1j * foot[:, 1], by_hand["foot"], atol=1e-13)

figure, axes = plt.subplots(figsize=(5.6, 5.6), layout="constrained")
now = {name: place[60] for name, place in by_hand.items()} | {"O": 0j}
for line in ("OM", "MKHBK", "MLB", "HAL"):
    axes.plot(*np.array([[now[name].real, now[name].imag] for name in line]).T, "o-", color="C0")
ends = np.array([now["A"], now["foot"], now["L"]])
axes.plot(ends.real, ends.imag, "o-", color="C0")
axes.plot(foot[:, 0], foot[:, 1], color="C3", linewidth=2.5, label="path of the foot")
axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Jansen's leg")
axes.legend()
