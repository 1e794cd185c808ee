"""Fingerprints: what decides results changes them, and nothing else does."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path
from types import FunctionType

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.studies.fingerprint import differences, fingerprint

FUNCTION = '''
FACTOR = 2.0
UNUSED = 3.0

def inner(x):
    return x + 1

def outer(x):
    """Say what it does."""
    # A comment.
    return FACTOR * inner(x)
'''


def outer_of(text: str, path: Path) -> FunctionType:
    """Return the function of a module, which has a file as modules have."""
    path.write_text(text)
    names: dict[str, FunctionType] = {"__name__": "module"}
    exec(compile(text, str(path), "exec"), names)
    return names["outer"]


def changed(old: str, new: str, folder: Path) -> list[str]:
    assert old in FUNCTION
    before = fingerprint(outer_of(FUNCTION, folder / "before.py"))
    after = fingerprint(outer_of(FUNCTION.replace(old, new), folder / "after.py"))
    return differences(before, after)


def test_code_and_what_it_uses_are_told_apart(tmp_path: Path) -> None:
    assert changed("x + 1", "x + 2", tmp_path) == ["the code of inner"]
    assert changed("FACTOR * inner", "inner", tmp_path) == ["FACTOR", "the code of outer"]
    assert changed("FACTOR = 2.0", "FACTOR = 2.5", tmp_path) == ["FACTOR"]


def test_what_makes_no_difference_is_none(tmp_path: Path) -> None:
    assert changed("# A comment.", "# Another comment, which is longer.", tmp_path) == []
    assert changed("UNUSED = 3.0", "UNUSED = 4.0", tmp_path) == []
    assert changed("Say what it does.", "Tell what it does.", tmp_path) == []


USED = {
    "a default": "def outer(x, k=NUMBER):\n    return k * x\n",
    "the first of two defaults": "def outer(x, k=NUMBER, m=7):\n    return k * x + m\n",
    "a default that is a list": "def outer(x, k=[NUMBER]):\n    return k[0] * x\n",
    "a default of a name alone": "def outer(x, *, k=NUMBER):\n    return k * x\n",
    "a default of an inner function": (
        "def inner(x, k=NUMBER):\n    return k * x\ndef outer(x):\n    return inner(x)\n"
    ),
    "a default of a method": (
        "class C:\n    def k(self, x, k=NUMBER):\n        return k * x\n"
        "def outer(x):\n    return C().k(x)\n"
    ),
    "what is enclosed": (
        "def made(k):\n    def outer(x):\n        return k * x\n    return outer\n"
        "outer = made(NUMBER)\n"
    ),
    "a global": "k = NUMBER\ndef outer(x):\n    return k * x\n",
    "an argument of a partial": (
        "import functools\ndef f(k, x):\n    return k * x\nouter = functools.partial(f, NUMBER)\n"
    ),
    "a named argument of a partial": (
        "import functools\ndef f(x, k):\n    return k * x\nouter = functools.partial(f, k=NUMBER)\n"
    ),
    "the object of a method": (
        "class C:\n    def __init__(self, k):\n        self.k = k\n"
        "    def times(self, x):\n        return self.k * x\nouter = C(NUMBER).times\n"
    ),
    "an object that is called": (
        "class C:\n    def __init__(self, k):\n        self.k = k\n"
        "    def __call__(self, x):\n        return self.k * x\nouter = C(NUMBER)\n"
    ),
    "an attribute of a class": "class C:\n    k = NUMBER\ndef outer(x):\n    return C.k * x\n",
    "a property": (
        "class C:\n    @property\n    def k(self):\n        return NUMBER\n"
        "def outer(x):\n    return C().k * x\n"
    ),
    "a base class": (
        "class B:\n    def k(self):\n        return NUMBER\nclass C(B):\n    pass\n"
        "def outer(x):\n    return C().k() * x\n"
    ),
    "an inner class": (
        "class C:\n    class D:\n        k = NUMBER\ndef outer(x):\n    return C.D.k * x\n"
    ),
    "a member": (
        "import enum\nclass C(enum.Enum):\n    k = NUMBER\n"
        "def outer(x):\n    return C.k.value * x\n"
    ),
    "a named tuple": (
        "import collections\nC = collections.namedtuple('C', 'k')\nc = C(NUMBER)\n"
        "def outer(x):\n    return c.k * x\n"
    ),
    "the first of two closures": (
        "def made(k):\n    return lambda x: k * x\nf, g = made(NUMBER), made(7)\n"
        "def outer(x):\n    return f(x) + g(x)\n"
    ),
    "the first of two lambdas": (
        "f = lambda x: NUMBER * x; g = lambda x: 7 * x\ndef outer(x):\n    return f(x) - g(x)\n"
    ),
    "a global called like a builtin": "input = NUMBER\ndef outer(x):\n    return input * x\n",
    "a decorator": (
        "import functools\ndef more(f):\n    @functools.wraps(f)\n    def inner(x):\n"
        "        return NUMBER * f(x)\n    return inner\n@more\ndef outer(x):\n    return x\n"
    ),
    "the first of two mechanisms of one name": (
        "import cardan_dyn as cd\ndef made(size):\n    return cd.load('<robot name=\"r\">'\n"
        '        \'<link name="a"/><link name="b"/><joint name="j" type="continuous">\'\n'
        '        \'<origin xyz="0 0 %s"/><parent link="a"/><child link="b"/></joint></robot>\'\n'
        "        % size)\nm, n = made(NUMBER), made(7)\ndef outer(x):\n    return m, n\n"
    ),
}
"""Modules in which NUMBER decides what is returned."""


@pytest.mark.parametrize("what", USED)
def test_whatever_a_function_uses_is_a_part(what: str, tmp_path: Path) -> None:
    first, same, other = (
        fingerprint(outer_of(USED[what].replace("NUMBER", number), tmp_path / "module.py"))
        for number in ("1", "1", "2")
    )
    assert differences(first, same) == []
    assert differences(first, other) != []


@pytest.mark.parametrize("use", ["first(x) - second(x)", "both[0](x) - both[1](x)"])
def test_which_function_a_name_stands_for_is_a_part(use: str, tmp_path: Path) -> None:
    text = (
        "def p(x):\n    return x\ndef q(x):\n    return 2 * x\nfirst, second = both = [@]\n"
        f"def outer(x):\n    return {use}\n"
    )
    one, other = (
        fingerprint(outer_of(text.replace("@", order), tmp_path / "module.py"))
        for order in ("p, q", "q, p")
    )
    assert differences(one, other) != []


def test_code_is_what_runs_and_not_what_its_file_has_become(tmp_path: Path) -> None:
    path = tmp_path / "module.py"
    function = outer_of("def outer(x):\n    return x\n", path)
    before = fingerprint(function)
    path.write_text("def outer(x):\n    return 2 * x\n")
    assert differences(before, fingerprint(function)) == []


def test_arguments_and_enclosed_values_are_parts() -> None:
    def scaled(x: float, by: float) -> float:
        return x * by

    assert differences(fingerprint(partial(scaled, by=2.0)), fingerprint(partial(scaled, by=3.0)))

    def enclosing(values: np.ndarray) -> FunctionType:
        def function(x: float) -> float:
            return float(values.sum()) * x

        return function  # type: ignore[return-value]

    first, same, other = (enclosing(np.array(item)) for item in ([1.0], [1.0], [2.0]))
    assert differences(fingerprint(first), fingerprint(same)) == []
    assert differences(fingerprint(first), fingerprint(other)) == ["values"]


@pytest.mark.slow
def test_fingerprints_are_the_same_in_every_process() -> None:
    code = (
        "import cardan_dyn as cd, numpy as np\n"
        "from cardan_dyn import studies\n"
        "from cardan_dyn.practice.studies.fingerprint import fingerprint\n"
        "words = {'a', 'b', 'c', 'd'}\n"
        "scene = cd.Scene(cd.load('elastic_thoma_rig'), drive='bearing_in', free='tilt_z',\n"
        "                 held={'joint_angle': 0.1, 'tilt_y': 0.0},\n"
        "                 elements=cd.described_elements(cd.load('elastic_thoma_rig'))[:1])\n"
        "def function(x):\n    return scene, words\n"
        "print(sorted(fingerprint(function).items()))\n"
        "held = scene.replace(held={'tilt_z': 0.0}, elements=None)\n"
        "wanted = studies.Sweeps(held, 'drive_effort')\n"
        "print(sorted(fingerprint(wanted).items()))\n"
    )
    told = [
        subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": seed, "PYTHONPATH": str(Path(__file__).parents[3])},
        ).stdout
        for seed in ("1", "2")
    ]
    assert told[0] == told[1]
    assert "the description of 'elastic_thoma_rig'" in told[0]


def test_what_urdf_cannot_say_differs_by_any_digit() -> None:
    def mechanism(ratio: float) -> cd.Mechanism:
        geom = '<geom type="sphere" size="0.1" mass="1"/>'
        body = f'<body name="{{0}}"><joint name="{{0}}" type="hinge" axis="0 0 1"/>{geom}</body>'
        return cd.load(
            "<mujoco><worldbody>" + "".join(body.format(name) for name in "abc") + "</worldbody>"
            '<equality><joint joint1="a" joint2="b" polycoef="0 2 0 0 0"/>'
            f'<joint joint1="a" joint2="c" polycoef="0 {ratio!r} 0 0 0"/></equality></mujoco>'
        )

    first, second = mechanism(0.5), mechanism(0.5 + 1e-15)
    with pytest.raises(cd.ModelError, match="mimic"):
        cd.write(first, "never.urdf")
    assert fingerprint(partial(max, first)) == fingerprint(partial(max, mechanism(0.5)))
    assert fingerprint(partial(max, first)) != fingerprint(partial(max, second))
