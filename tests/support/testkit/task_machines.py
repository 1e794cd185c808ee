"""Machines whose tip moves as given: five-bar, Stewart platform, excavator, parallel ankle, arm."""

from __future__ import annotations

import numpy as np

from cardan_dyn.kit.arrays import Array

X, Y, Z = np.eye(3)
HERE = np.zeros(3)


def numbers(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def origin(place: Array, turn: Array = HERE) -> str:
    return f'<origin xyz="{numbers(place)}" rpy="{numbers(turn)}"/>'


def link(name: str, mass: float = 0.0, centre: Array = HERE, inertia: Array = X) -> str:
    """Inertia `(3,)` about the centre: xx, yy, zz."""
    if not mass:
        return f'<link name="{name}"/>'
    xx, yy, zz = map(float, inertia)
    return (
        f'<link name="{name}"><inertial>{origin(centre)}<mass value="{mass}"/>'
        f'<inertia ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}"/></inertial></link>'
    )


def joint(
    name: str, kind: str, parent: str, child: str, place: Array, axis: Array, turn: Array = 0.0 * X
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'{origin(place, turn)}<axis xyz="{numbers(axis)}"/></joint>'
    )


def loop(name: str, kind: str, ends: str, places: tuple[Array, Array], axis: Array) -> str:
    first, second = ends.split()
    return (
        f'<loop name="{name}" type="{kind}"><predecessor link="{first}">{origin(places[0])}'
        f'</predecessor><successor link="{second}">{origin(places[1])}</successor>'
        f'<axis xyz="{numbers(axis)}"/></loop>'
    )


def robot(name: str, *elements: str) -> str:
    return f'<robot name="{name}">{"".join(elements)}</robot>'


def rod(name: str, mass: float, length: float) -> str:
    about = mass * length**2 / 12.0 * (Y + Z)
    return link(name, mass, 0.5 * length * X, about)


FIVE_BAR = {"m1": 1.9848129005862, "m2": 0.715744556202147}
"""Where the tip is at (0.05, 0.28), elbows apart."""


def five_bar(proximal: float = 0.5, distal: float = 0.4, payload: float = 1.0) -> str:
    """Bases 0.2 apart, proximal links 0.2, distal ones 0.25 long; masses of each."""
    return robot(
        "five_bar",
        *(link("base"), rod("p1", proximal, 0.2), rod("p2", proximal, 0.2)),
        *(rod("d1", distal, 0.25), rod("d2", distal, 0.25), link("load", payload, inertia=0.0 * X)),
        joint("m1", "continuous", "base", "p1", -0.1 * X, Z),
        joint("m2", "continuous", "base", "p2", 0.1 * X, Z),
        joint("e1", "continuous", "p1", "d1", 0.2 * X, Z),
        joint("e2", "continuous", "p2", "d2", 0.2 * X, Z),
        joint("tip", "fixed", "d1", "load", 0.25 * X, Z),
        loop("pin", "continuous", "d1 d2", (0.25 * X, 0.25 * X), Z),
    )


def five_bar_start() -> dict[str, float]:
    start, tip = dict(FIVE_BAR), np.array([0.05, 0.28])
    for number, side in (1, -1.0), (2, 1.0):
        q = start[f"m{number}"]
        elbow = np.array([0.1 * side + 0.2 * np.cos(q), 0.2 * np.sin(q)])
        start[f"e{number}"] = np.arctan2(*(tip - elbow)[::-1]) - q
    return start


FEET = 0.5 * np.array(
    [[np.cos(a), np.sin(a), 0.0] for a in np.radians([-10, 10, 110, 130, 230, 250])]
)
HEADS = 0.3 * np.array(
    [[np.cos(a), np.sin(a), 0.0] for a in np.radians([-50, 50, 70, 170, 190, 290])]
)
RAISED = 0.6 * Z
LEGS = [f"leg_{k}" for k in range(6)]


def angles(rotation: Array) -> Array:
    """Roll, pitch and yaw of a rotation."""
    return np.array(
        [
            np.arctan2(rotation[2, 1], rotation[2, 2]),
            -np.arcsin(rotation[2, 0]),
            np.arctan2(rotation[1, 0], rotation[0, 0]),
        ]
    )


def stewart() -> str:
    """Six massless legs between balls, at zero where the platform is 0.6 above the base."""
    parts = [link("base"), link("rim")]
    parts.append(link("platform", 20.0, np.array([0.01, 0.02, 0.03]), np.array([0.5, 0.6, 0.9])))
    for k, (foot, head) in enumerate(zip(FEET, HEADS + RAISED, strict=True)):
        way = head - foot
        along = way / np.linalg.norm(way)
        across = np.cross(Y, along)
        across /= np.linalg.norm(across)
        axes = np.stack([across, np.cross(along, across), along], axis=1)
        parts += [link(f"lower_{k}"), link(f"upper_{k}")]
        foot_place = foot, X, angles(axes)
        parts.append(joint(f"foot_{k}", "spherical", "base", f"lower_{k}", *foot_place))
        length = np.linalg.norm(way) * Z
        parts.append(joint(f"leg_{k}", "prismatic", f"lower_{k}", f"upper_{k}", length, Z))
        if k == 0:
            back = 0.0 * X, X, angles(axes.T)
            parts.append(joint("head_0", "spherical", "upper_0", "rim", *back))
            parts.append(joint("mount", "fixed", "rim", "platform", -HEADS[0], X))
        else:
            places = 0.0 * X, HEADS[k]
            parts.append(loop(f"head_{k}", "spherical", f"upper_{k} platform", places, X))
    return robot("stewart", *parts)


LEG_LENGTHS = np.linalg.norm(HEADS + RAISED - FEET, axis=1)


def in_plane(x: float, z: float) -> Array:
    return np.array([x, 0.0, z])


# The excavator at zero, all points in the plane y = 0.
FOOT, STICK_PIN, BUCKET_PIN = in_plane(0, 0), in_plane(3.2, 2.4), in_plane(4.6, 0.6)
BOOM_BASE, BOOM_HEAD = in_plane(0.6, -0.4), in_plane(1.6, 1.9)
STICK_BASE, STICK_HEAD = in_plane(1.2, 2.2), in_plane(2.64, 3.12)
BUCKET_BASE, ROCKER_PIN = in_plane(3.5, 2.7), in_plane(4.3, 1.0)
ROCKER_HEAD, BUCKET_EAR = in_plane(4.75, 1.35), in_plane(5.05, 0.75)
TIP = in_plane(5.2, -0.6)
CYLINDERS = ["boom_cylinder", "stick_cylinder", "bucket_cylinder"]
LENGTHS = [
    float(np.linalg.norm(head - base))
    for base, head in (
        (BOOM_BASE, BOOM_HEAD),
        (STICK_BASE, STICK_HEAD),
        (BUCKET_BASE, ROCKER_HEAD),
    )
]
MASSES = {"boom": 1500.0, "stick": 700.0, "bucket": 500.0, "rocker": 40.0, "bar": 60.0}
CENTRES = {
    "boom": in_plane(1.7, 1.6),
    "stick": in_plane(3.7, 1.9),
    "bucket": in_plane(4.9, 0.1),
    "rocker": 0.5 * (ROCKER_PIN + ROCKER_HEAD),
    "bar": 0.5 * (ROCKER_HEAD + BUCKET_EAR),
}


def excavator(has_mass: bool = True) -> str:
    """Boom, stick and bucket in the plane x z, each moved by a cylinder without mass."""
    starts = {"boom": FOOT, "stick": STICK_PIN, "bucket": BUCKET_PIN}
    starts |= {"rocker": ROCKER_PIN, "bar": ROCKER_HEAD}
    parts = [link("chassis")]
    for name, mass in MASSES.items():
        centre = CENTRES[name] - starts[name]
        parts.append(link(name, mass * has_mass, centre, 0.1 * mass * np.ones(3)))
    cylinders = (
        ("boom", "chassis", BOOM_BASE, FOOT, "boom", BOOM_HEAD, FOOT),
        ("stick", "boom", STICK_BASE, FOOT, "stick", STICK_HEAD, STICK_PIN),
        ("bucket", "stick", BUCKET_BASE, STICK_PIN, "rocker", ROCKER_HEAD, ROCKER_PIN),
    )
    loops = []
    for name, carrier, base, of_carrier, moved, head, of_moved in cylinders:
        barrel, piston = f"{name}_barrel", f"{name}_piston"
        along = (head - base) / np.linalg.norm(head - base)
        parts += [link(barrel), link(piston)]
        parts.append(joint(f"{barrel}_pin", "continuous", carrier, barrel, base - of_carrier, Y))
        parts.append(joint(f"{name}_cylinder", "prismatic", barrel, piston, head - base, along))
        ends = 0.0 * X, head - of_moved
        loops.append(loop(f"{piston}_pin", "continuous", f"{piston} {moved}", ends, Y))
    parts.append(joint("boom_pin", "continuous", "chassis", "boom", FOOT, Y))
    parts.append(joint("stick_pin", "continuous", "boom", "stick", STICK_PIN, Y))
    parts.append(joint("bucket_pin", "continuous", "stick", "bucket", BUCKET_PIN - STICK_PIN, Y))
    parts.append(joint("rocker_pin", "continuous", "stick", "rocker", ROCKER_PIN - STICK_PIN, Y))
    parts.append(joint("bar_pin", "continuous", "rocker", "bar", ROCKER_HEAD - ROCKER_PIN, Y))
    places = BUCKET_EAR - ROCKER_HEAD, BUCKET_EAR - BUCKET_PIN
    loops.append(loop("ear_pin", "continuous", "bar bucket", places, Y))
    return robot("excavator", *parts, *loops)


def carried(point: Array, from_ends: tuple[Array, Array], to_ends: tuple[Array, Array]) -> Array:
    """Return where a point of a body is whose points `from_ends` have come to `to_ends`.

    Points are (x, z), of complex numbers where derivatives are taken.
    """
    before, after = from_ends[1] - from_ends[0], to_ends[1] - to_ends[0]
    square = before @ before
    cosine = before @ after / square
    sine = (before[0] * after[1] - before[1] * after[0]) / square
    x, z = point - from_ends[0]
    return np.array([cosine * x - sine * z, sine * x + cosine * z]) + to_ends[0]


def third(first: Array, second: Array, like: tuple[Array, Array, Array]) -> Array:
    """Return the third corner of a triangle that has two corners, and the sides of another."""
    near, far = ((like[2] - like[k]) @ (like[2] - like[k]) for k in (0, 1))
    way, was = second - first, like[1] - like[0]
    square = way @ way
    along = (near - far + square) / (2.0 * square)
    side = np.sign(was[0] * (like[2] - like[0])[1] - was[1] * (like[2] - like[0])[0])
    across = side * np.sqrt(near / square - along**2)
    return first + along * way + across * np.array([-way[1], way[0]])


def excavator_at(task: Array) -> tuple[Array, Array]:
    """Return how much longer the cylinders are than at zero, and the potential energy.

    Args:
        task: x and z of the tip, and the angle of the bucket about y.
    """
    foot, tip, stick_at, bucket_at, boom_base, boom_head, stick_base, stick_head, bucket_base = (
        point[[0, 2]]
        for point in (
            *(FOOT, TIP, STICK_PIN, BUCKET_PIN, BOOM_BASE, BOOM_HEAD),
            *(STICK_BASE, STICK_HEAD, BUCKET_BASE),
        )
    )
    linkage = tuple(point[[0, 2]] for point in (ROCKER_PIN, BUCKET_EAR, ROCKER_HEAD))
    cosine, sine = np.cos(task[2]), np.sin(task[2])
    turned = np.array([[cosine, sine], [-sine, cosine]])

    def of_bucket(point: Array) -> Array:
        return task[:2] + turned @ (point - tip)

    bucket_pin = of_bucket(bucket_at)
    stick_pin = third(foot, bucket_pin, (foot, bucket_at, stick_at))
    boom = (foot, stick_at), (foot, stick_pin)
    stick = (stick_at, bucket_at), (stick_pin, bucket_pin)
    rocker_pin, ear = carried(linkage[0], *stick), of_bucket(linkage[1])
    rocker_head = third(rocker_pin, ear, linkage)
    ends = [
        (boom_base, carried(boom_head, *boom)),
        (carried(stick_base, *boom), carried(stick_head, *stick)),
        (carried(bucket_base, *stick), rocker_head),
    ]
    lengths = [np.sqrt((head - base) @ (head - base)) for base, head in ends]
    centres = {name: centre[[0, 2]] for name, centre in CENTRES.items()}
    heights = {
        "boom": carried(centres["boom"], *boom),
        "stick": carried(centres["stick"], *stick),
        "bucket": of_bucket(centres["bucket"]),
        "rocker": 0.5 * (rocker_pin + rocker_head),
        "bar": 0.5 * (rocker_head + ear),
    }
    energy = sum(9.81 * MASSES[name] * place[1] for name, place in heights.items())
    return np.array(lengths) - LENGTHS, np.array(energy)


# The ankle: motors on the shank turn cranks about y, rods between balls move the foot.
MOTORS = np.array([[-0.05, 0.04, 0.25], [-0.05, -0.04, 0.25]])
CRANK, SOLE = -0.04 * X, np.array([0.05, 0.0, -0.06])
HEELS = np.array([[-0.06, 0.045, -0.03], [-0.06, -0.045, -0.03]])
FOOT_MASS = 1.5


def ankle() -> str:
    parts = [link("shank"), link("cross"), link("foot", FOOT_MASS, SOLE, 0.01 * np.ones(3))]
    parts.append(joint("pitch", "revolute", "shank", "cross", 0.0 * X, Y))
    parts.append(joint("roll", "revolute", "cross", "foot", 0.0 * X, X))
    loops = []
    for side, motor, heel in zip("lr", MOTORS, HEELS, strict=True):
        parts += [link(f"crank_{side}"), link(f"rod_{side}")]
        parts.append(joint(f"motor_{side}", "continuous", "shank", f"crank_{side}", motor, Y))
        ends = f"crank_{side}", f"rod_{side}"
        parts.append(joint(f"upper_{side}", "spherical", *ends, CRANK, X))
        places = heel - motor - CRANK, heel
        loops.append(loop(f"lower_{side}", "spherical", f"rod_{side} foot", places, X))
    return robot("ankle", *parts, *loops).replace(
        "</joint>", '<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
    )


def tilted(pitch: complex, roll: complex, point: Array) -> Array:
    """Return a point of the foot in the axes of the shank."""
    cp, sp, cr, sr = np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
    x, y, z = point[0], cr * point[1] - sr * point[2], sr * point[1] + cr * point[2]
    return np.array([cp * x + sp * z, y, -sp * x + cp * z])


def rod_gap(side: int, motor: complex, pitch: complex, roll: complex) -> complex:
    """Return how much the square of a rod's length would have to change."""
    way = tilted(pitch, roll, HEELS[side]) - MOTORS[side] - tilted(motor, 0.0, CRANK)
    rod = HEELS[side] - MOTORS[side] - CRANK
    return way @ way - rod @ rod


# An arm of six hinges, the last three of which do not meet in a point.
ARM = {
    "pan": ("base shoulder", 0.089 * Z, 0.0 * X, Z, 3.7),
    "lift": ("shoulder upper", 0.136 * Y, 1.57 * Y, Y, 8.4),
    "elbow": ("upper fore", np.array([0.0, -0.12, 0.425]), 0.0 * X, Y, 2.3),
    "wrist_1": ("fore wrist", 0.392 * Z, 1.57 * Y, Y, 1.2),
    "wrist_2": ("wrist palm", 0.093 * Y, 0.0 * X, Z, 1.2),
    "wrist_3": ("palm hand", 0.095 * Z, 0.0 * X, Y, 0.2),
}
ARM_START = {
    "pan": 0.1,
    "lift": -1.1,
    "elbow": 1.3,
    "wrist_1": -0.4,
    "wrist_2": -1.2,
    "wrist_3": 0.3,
}


def arm() -> str:
    parts = [link("base")]
    for name, (ends, place, turn, axis, mass) in ARM.items():
        parent, child = ends.split()
        parts.append(
            link(child, mass, np.array([0.01, 0.02, 0.1]), mass * np.array([0.02, 0.03, 0.01]))
        )
        parts.append(joint(name, "continuous", parent, child, place, axis, turn))
    return robot("arm", *parts)
