"""Arguments: a seed to a call of the package, as Python code, with arguments that may be wrong.

Code, because it is its own reproducer: what it needs stands in `pool.namespace`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random

from oddities import odd
from pool import OPTIONS, namespace

SCENES = ("four_bar", "four_bar", "slider_crank", "universal_joint", "thoma_rig", "gear", "arm")

PLACES = (
    *("0.1", "[0.0, 0.1]", "np.linspace(0.0, 0.3, 4)", "[[0.0], [0.1]]", "[[0.0, 0.1]]", "1", "-3"),
    *("[0, 1]", "1e6", "[1e-9]"),
    *("np.linspace(0.0, 6.3, 40)", "np.zeros((2, 2))", "[100.0, -100.0]"),
    *("[0.3, 0.1, 0.2]", "1e12", "np.float32([0.1])"),
    *("[1e17]", "1e300", "[0.2, 0.2]", "np.ones(900)"),
)
NAMES: dict[str, tuple[str, ...]] = {
    "four_bar": ("crank_bearing", "crank_pin", "rocker_bearing", "rocker_pin"),
    "slider_crank": ("crank_bearing", "crank_pin"),
    "universal_joint": ("bearing_in", "pin_in", "joint_angle", "bearing_out", "pin_out"),
    "thoma_rig": ("bearing_in", "pin_in", "joint_angle", "bearing_out", "pin_out"),
    "gear": ("first", "second"),
    "arm": ("turn", "slide"),
}
LINKS = ("crank", "coupler", "rocker", "shaft_out", "cross", "one", "two", "base", "house")


def _name(rng: Random, scene_name: str, wrong: float = 0.35) -> str:
    if rng.random() < wrong:
        return odd(rng)
    return repr(rng.choice(NAMES[scene_name]))


def _value(rng: Random, *good: str, wrong: float = 0.45) -> str:
    return odd(rng) if rng.random() < wrong else rng.choice(good)


def _mapping(rng: Random, scene_name: str, values: Callable[[], str]) -> str:
    """Return code for a mapping of names to values, or for none at all."""
    if rng.random() < 0.2:
        return odd(rng)
    keys = [_name(rng, scene_name, 0.1) for _ in range(rng.choice([0, 1, 1, 1, 2]))]
    if rng.random() < 0.25:
        keys.append(repr(rng.choice(LINKS)))
    code = "{" + ", ".join(f"{key}: {values()}" for key in keys if _hashable(key)) + "}"
    if rng.random() < 0.08:
        return f"list({code}.items())"
    return code


@cache
def _hashable(code: str) -> bool:
    try:
        hash(eval(code, namespace(Path())))
    except (TypeError, ValueError):
        return False
    return True


def _wrench(rng: Random) -> str:
    parts = [_value(rng, "[1.0, 0.0, 2.0]", "np.ones((4, 3))", "[0, 0, 1]") for _ in range(2)]
    frame = _value(rng, "'link'", "'world'", wrong=0.25)
    return f"cd.Wrench({parts[0]}, {parts[1]}, {frame})"


def _loads(rng: Random, scene_name: str) -> str:
    def value() -> str:
        if rng.random() < 0.3:
            return _wrench(rng)
        return _value(rng, "1.0", "-2", "[1.0, 2.0, 3.0]", "[0.0] * 6", "np.ones((4, 6))", "1e150")

    return _mapping(rng, scene_name, value)


def _scene(rng: Random) -> str:
    scene_name = rng.choice(SCENES)
    if scene_name == "thoma_rig":
        scene_name = "four_bar"
    options = {}
    text = OPTIONS[scene_name]
    for part in ("drive", "held"):
        if f"{part}=" in text:
            # What the scene needs, so that other arguments are reached.
            options[part] = str(_arguments(text)[part])
    makers: dict[str, Callable[[], str]] = {
        "drive": lambda: _value(
            rng,
            f"[{_name(rng, scene_name)}]",
            f"({_name(rng, scene_name)}, {_name(rng, scene_name)})",
            f"np.array([{_name(rng, scene_name, 0.0)}])",
            f"{{{_name(rng, scene_name, 0.0)}}}",
            _name(rng, scene_name),
        ),
        "held": lambda: _mapping(
            rng, scene_name, lambda: _value(rng, "0.1", "0", "-0.2", "3.0", "1e9")
        ),
        "loads": lambda: _loads(rng, scene_name),
        "gravity": lambda: _value(rng, "[0, 0, -9.81]", "(0.0, 1e200, 0.0)", "[[0, 0, 1]]"),
        "outputs": lambda: _value(
            rng,
            f"[{_name(rng, scene_name)}]",
            "[]",
            _name(rng, scene_name),
            f"{{{_name(rng, scene_name, 0.0)}}}",
        ),
        "compliance": lambda: _mapping(
            rng,
            scene_name,
            lambda: _value(rng, "[1e-9] * 6", "np.eye(6)", "[0.0] * 6", "[1e-300] * 6"),
        ),
        "strict": lambda: _value(rng, "True", "False"),
        "near": lambda: _mapping(rng, scene_name, lambda: _value(rng, "0.1", "0", "-0.2", "1e9")),
        "branch": lambda: _value(rng, "'A'", "'B'", "'Z9'"),
    }
    names = rng.choices(list(makers), k=rng.choice([1, 1, 2, 3]))
    options |= {name: makers[name]() for name in dict.fromkeys(names)}
    first = odd(rng) if rng.random() < 0.03 else f"mechanism({scene_name!r})"
    return f"cd.Scene({first}, {', '.join(f'{key}={code}' for key, code in options.items())})"


@cache
def _arguments(text: str) -> dict[str, str]:
    """Return the arguments that code for keywords gives, as code."""
    return {name: repr(value) for name, value in eval(f"dict({text})").items()}


def _rates(rng: Random) -> str:
    rates = ("0.0", "3.0", "-100", "[1.0, 2.0]", "1e200", "[[1.0], [2.0]]", "1e-200", "1e6")
    parts = [f"{name}={_value(rng, *rates)}" for name in ("speed", "acceleration")]
    return ", ".join(part for part in parts if rng.random() < 0.5)


def _sweep(rng: Random) -> str:
    scene_name = rng.choice(SCENES)
    closed = f"scene({scene_name!r}).assemble([0.0, 0.1])", "scene('gear').assemble([0.1])"
    place = _value(rng, *PLACES, *closed)
    options = ", ".join(part for part in (_rates(rng), _acting(rng, scene_name)) if part)
    return f"scene({scene_name!r}).sweep({place}, {options})"


def _acting(rng: Random, scene_name: str) -> str:
    """Return code for what else is given to a sweep, most often nothing."""
    makers: dict[str, Callable[[], str]] = {
        "held": lambda: _held(rng, scene_name),
        "loads": lambda: _loads(rng, scene_name),
        "gravity": lambda: _value(
            rng, "[0, 0, -9.81]", "np.ones((4, 3))", "np.ones((2, 1, 3))", "(0.0, 1e200, 0.0)"
        ),
        "inertia": lambda: _inertia(rng),
        "along_path": lambda: _value(rng, "True", "False", wrong=0.25),
    }
    return ", ".join(f"{name}={make()}" for name, make in makers.items() if rng.random() < 0.15)


def _held(rng: Random, scene_name: str) -> str:
    values = "0.1", "[0.3, -0.2]", "[[0.2], [0.5]]", "1.5", "0.4", "[[[0.1]]]", "1e9"
    if scene_name in ("universal_joint", "thoma_rig") and rng.random() < 0.7:
        return f"{{'joint_angle': {_value(rng, *values, wrong=0.25)}}}"
    return _mapping(rng, scene_name, lambda: _value(rng, *values))


def _inertia(rng: Random) -> str:
    links = [repr(rng.choice(LINKS)) for _ in range(rng.choice([1, 1, 2]))]
    values = "2.0", "0", "[1.0, 0.5]", "[[1.0], [3.0]]", "-1.0", "1e300", "np.ones((4, 1))"
    return "{" + ", ".join(f"{link}: {_value(rng, *values, wrong=0.25)}" for link in links) + "}"


def _close(rng: Random) -> str:
    scene_name = rng.choice(SCENES)
    options = ""
    if rng.random() < 0.4:
        options = f", held={_held(rng, scene_name)}"
    if rng.random() < 0.2:
        options += ", along_path=True"
    return f"scene({scene_name!r}).assemble({_value(rng, *PLACES)}{options})"


def _reach(rng: Random) -> str:
    scene_name = rng.choice(SCENES)
    options = f", held={_held(rng, scene_name)}" if rng.random() < 0.5 else ""
    return f"scene({scene_name!r}).reachable({_value(rng, *PLACES)}{options})"


def _build(rng: Random) -> str:
    scene_name = rng.choice(["four_bar", "slider_crank", "universal_joint", "gear", "arm"])
    options = []
    if rng.random() < 0.6:
        options.append(_value(rng, "1e-9", "1e-13", "1e-6", "0.5", "1e-300", wrong=0.6))
    if rng.random() < 0.5:
        ends = [_value(rng, "0.0", "0.3", "-0.2", "1.0", "1e-12", "1e9") for _ in range(2)]
        options.append(f"interval=({ends[0]}, {ends[1]})" if rng.random() < 0.9 else "interval=3")
    return f"scene({scene_name!r}).response({', '.join(options)})"


def _answered(rng: Random) -> str:
    scene_name = rng.choice(["four_bar", "slider_crank", "universal_joint", "gear"])
    options = _rates(rng)
    if rng.random() < 0.3:
        options += f", loads={_loads(rng, scene_name)}"
    if rng.random() < 0.3:
        options += f", gravity={_value(rng, '[0, 0, -1.0]', 'np.ones((4, 3))', '[0, 0, 1e300]')}"
    options = options.strip(", ")
    method = rng.choice(
        ["sweep", "sweep", "turn", "inertia", "inertia_derivative", "ratio", "save", "load"]
    )
    made = f"response({scene_name!r})"
    if method == "sweep":
        return f"{made}.sweep({_value(rng, *PLACES)}, {options})"
    if method == "turn":
        counts = ("1", "7", "720", "np.int32(5)", "True", "0", "-3", "10**5", "10**400", "2**63")
        return f"{made}.uniform({_value(rng, *counts)}, {options})"
    if method == "ratio":
        return f"{made}.ratio({_name(rng, scene_name)}, {_value(rng, *PLACES)})"
    if method == "save":
        paths = ("directory / 'saved'", "str(directory / 'saved.npz')", "directory", "'/nowhere/a'")
        return f"{made}.save({_value(rng, *paths)})"
    if method == "load":
        return _loaded(rng, scene_name)
    return f"{made}.{method}({_value(rng, *PLACES)})"


def _loaded(rng: Random, scene_name: str) -> str:
    """Return code that reads a saved response that was damaged."""
    kind = rng.randrange(8)
    if kind == 0:
        damage = f"cut={rng.randrange(6000)}"
    elif kind == 1:
        damage = f"flip={rng.randrange(6000)}"
    elif kind == 2:
        names = ("header", "values", "place", "periodic", "zero", "constant", "unique")
        damage = f"drop={rng.choice(names)!r}"
    elif kind in (3, 4):
        names = ("values", "place", "periodic", "zero", "constant", "unique")
        new = rng.choice(
            [
                "np.zeros(0)",
                "np.array('x')",
                "np.zeros((2, 2))",
                "np.array([np.nan, 1.0])",
                "np.array([0.0, 0.0])",
                "np.array([1, 2, 3])",
                "np.array(1j)",
                "old[:1]",
                "old.T",
                "old * np.nan",
                "old.astype(str)",
                "old[..., None]",
                "old * 2",
                "old.ravel()[:2]",
            ]
        )
        damage = f"change=({rng.choice(names)!r}, lambda old: {new})"
    elif kind in (5, 6):
        keys = ["columns", "proof", "mechanism", "identity", "format", "outputs", "efforts"]
        keys += ["couplings", "coupling_unique"]
        new = rng.choice(
            [
                "None",
                "[]",
                "{}",
                "'x'",
                "3",
                "[1]",
                "old",
                "[old]",
                "{'error': 'x'}",
                "float('nan')",
                "{key: None for key in old}",
                "{key: 'x' for key in old}",
                "list(old)[:1]",
            ]
        )
        damage = f"head=({rng.choice(keys)!r}, lambda old: {new})"
    else:
        damage = ""
    if rng.random() < 0.6 and damage.startswith(("drop", "change", "head")):
        damage += ", sealed=True"
    path = f"saved({scene_name!r}, {damage})" if rng.random() < 0.9 else odd(rng)
    other = (
        f"scene({scene_name!r})" if rng.random() < 0.9 else rng.choice(["scene('arm')", odd(rng)])
    )
    return f"{other}.load_response({path})"


def _asked(rng: Random) -> str:
    """Return code that asks a mechanism, scene or sweep for something by name."""
    scene_name = rng.choice(SCENES)
    name = _name(rng, scene_name, 0.6)
    frame = _value(rng, "'joint'", "'parent'", "'world'")
    source = rng.choice(["swept({!r})", "swept({!r})", "response({!r}).sweep([0.0, 0.1])"])
    source = source.format(
        "four_bar" if "response" in source and scene_name in ("arm",) else scene_name
    )
    return rng.choice(
        [
            f"mechanism({scene_name!r}).joint({name})",
            f"mechanism({scene_name!r}).link({_value(rng, *map(repr, LINKS))})",
            f"cd.describe(mechanism({scene_name!r}))",
            f"{source}[{name}]",
            f"{source}.wrench({name}, {frame})",
            f"{source}.wrench({name}, frame={frame})",
            f"{source}.rotation({name})",
            f"{source}.origin({name})",
            f"{source}.motion.position({name})",
            f"{source}.motion.velocity({name})",
            f"{source}.motion.acceleration({name})",
            f"{source}.motion.ratio({name}, {_value(rng, '0', '1', '-1', '-2', '7')})",
            f"{source}.drive_effort",
            f"scene({scene_name!r}).plan()",
            f"scene({scene_name!r}).motion_range()",
            f"scene({scene_name!r}).branches()"
            if scene_name != "thoma_rig"
            else "scene('gear').branches()",
        ]
    )


def _load(rng: Random) -> str:
    source = _value(rng, "'four_bar'", "TEXTS['gear']", "Path('/nowhere')", "'.'", wrong=0.8)
    strict = f", strict={_value(rng, 'True', 'False')}" if rng.random() < 0.3 else ""
    return f"cd.load({source}{strict})"


FAMILIES: tuple[tuple[float, Callable[[Random], str]], ...] = (
    (30.0, _scene),
    (20.0, _sweep),
    (4.0, _close),
    (3.0, _reach),
    (3.0, _build),
    (24.0, _answered),
    (22.0, _asked),
    (4.0, _load),
    (3.0, _wrench),
)


def call(seed: int) -> str:
    """Return the code that belongs to a seed."""
    rng = Random(f"argument {seed}")
    (make,) = rng.choices([make for _, make in FAMILIES], [weight for weight, _ in FAMILIES])
    return make(rng).replace(", )", ")")
