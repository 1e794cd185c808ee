"""Records compare by content, and show themselves."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.description import (
    CouplingDescription,
    Description,
    Dynamics,
    JointDescription,
    Limits,
    LinkDescription,
    LoopDescription,
    Mesh,
    SourceText,
)
from cardan_dyn.core.response.identity import digest

X, Y, Z = np.eye(3)


def example() -> Description:
    return Description(
        "example",
        (
            LinkDescription("ground"),
            LinkDescription("arm", 2.5, np.array([0.1, 0.0, -0.0]), np.diag([1.0, 2.0, 2.5])),
            LinkDescription("hand", 1.0),
        ),
        (
            JointDescription("hinge", "revolute", "ground", "arm", np.eye(4), Z, Z),
            JointDescription("cross", "universal", "arm", "hand", np.eye(4), X, Y),
        ),
        ("cross", "hinge"),
        (LoopDescription("ball", "spherical", "hand", "ground", np.eye(4), np.eye(4), X, X),),
        (CouplingDescription("mesh", "ground", "arm", -2.5),),
        ("hinge",),
    )


def test_equal_contents_are_equal() -> None:
    assert example() == example()
    assert (example() != example()) is False
    for copied in (copy.deepcopy(example()), pickle.loads(pickle.dumps(example()))):
        assert copied == example()
    assert example() != "example"
    assert example().links[0] != example().joints[0]
    assert example().links[1] in list(example().links)
    assert cd.load("four_bar").description == cd.load("four_bar").description
    assert cd.load("four_bar").description != cd.load("slider_crank").description


LINK, (JOINT, CROSS) = example().links[1], example().joints
LOOP = replace(example().loops[0], type="universal", axis_2=Y)
ELSEWHERE = np.eye(4)
ELSEWHERE[0, 3] = 5e-324
CHANGES = [
    (
        LINK,
        {
            "name": "leg",
            "mass": float(np.nextafter(2.5, 3.0)),
            "centre": np.array([0.1, 0.0, 5e-324]),
            "inertia": np.diag([1.0, 2.0, 3.0]),
        },
    ),
    (
        CROSS,
        {
            **{"name": "h", "type": "continuous", "parent": "ground", "child": "arm"},
            **{"origin": ELSEWHERE, "axis": Y, "axis_2": Z, "child_placement": ELSEWHERE},
            "limits": Limits(upper=3.0),
            **{"adjustable": "revolute", "dynamics": Dynamics(1.0, 2.0, 3.0, 0.5)},
            "armature": (0.1,),
        },
    ),
    (
        LOOP,
        {
            **{"name": "h", "type": "fixed", "predecessor": "arm", "successor": "arm"},
            **{"predecessor_origin": ELSEWHERE, "successor_origin": ELSEWHERE},
            **{"axis": Y, "axis_2": Z},
            **{"dynamics": Dynamics(rest=0.5), "armature": (0.1,)},
        },
    ),
    (Limits(), {"lower": 0.0, "upper": 1.0, "velocity": 2.0, "effort": 3.0, "least_effort": -1.0}),
    (
        CouplingDescription("m", "a", "b", 1.0),
        {
            **{"name": "n", "predecessor": "c", "successor": "c", "ratio": 1.0 + 2.0**-52},
            **{"offset": 1e-300, "of_joints": True, "forces": "none", "mesh": Mesh()},
            "higher": (0.5,),
        },
    ),
    (
        example(),
        {
            **{"name": "other", "order": ("hinge", "cross"), "independent_joints": ()},
            **{"links": example().links[::-1], "joints": example().joints[:1]},
            **{"loops": (), "couplings": (CouplingDescription("mesh", "ground", "arm", 2.0),)},
        },
    ),
]


@pytest.mark.parametrize(("record", "changes"), CHANGES, ids=lambda item: type(item).__name__)
def test_every_field_counts(record: object, changes: dict[str, object]) -> None:
    compared = {item.name for item in fields(record) if item.compare}
    assert compared == set(changes)
    assert replace(record) == record
    for name, value in changes.items():
        assert replace(record, **{name: value}) != record, name


def test_how_it_was_written_does_not_count() -> None:
    """Source, notation and warnings may differ; no response depends on them."""
    rewritten = replace(
        example(), source=SourceText("<robot/>", None), notation="MJCF", warnings=("odd",)
    )
    assert rewritten == example()
    assert digest(rewritten) == digest(example())


def test_zero_has_two_signs_that_are_equal() -> None:
    link = replace(LINK, centre=np.array([0.1, -0.0, 0.0]))
    assert link == LINK


def test_records_have_no_hash() -> None:
    """Equal ones would need equal hashes, and arrays have none."""
    for record in (example(), LINK, JOINT, LOOP, Limits(), example().couplings[0]):
        with pytest.raises(TypeError, match="unhashable"):
            hash(record)


def test_agreement_up_to_rounding() -> None:
    near = replace(LINK, mass=2.5 * (1.0 + 1e-12), inertia=LINK.inertia + 1e-12)
    described = replace(example(), links=(example().links[0], near, example().links[2]))
    assert described != example()
    assert described.agrees(example(), 2e-12)
    assert not described.agrees(example(), 1e-13)
    # Infinite limits agree with each other only.
    assert Limits(velocity=1.0).agrees(Limits(velocity=1.0 + 1e-9), 1e-8)
    assert not Limits(velocity=1e300).agrees(Limits(), 1e-8)
    assert not example().agrees(None, 1.0)
    assert not replace(LINK, centre=np.zeros(4)).agrees(LINK, 1.0)
    assert not LINK.agrees(replace(LINK, mass=None), 1.0)  # type: ignore[arg-type]
    # Names have no tolerance.
    assert not replace(LINK, name="leg").agrees(LINK, 1.0)


def test_the_root_is_nobodys_child() -> None:
    assert example().root == "ground"
    assert replace(example(), links=example().links[::-1]).root == "ground"


def test_printing() -> None:
    assert str(example()) == "\n".join(
        [
            "example",
            "links:",
            "  ground  massless",
            "  arm     2.5 kg    centre (0.1, 0, 0) m",
            "  hand    1 kg      centre (0, 0, 0) m",
            "joints:",
            "  hinge  revolute   ground -> arm  axis (0, 0, 1)                independent",
            "  cross  universal  arm -> hand    axes (1, 0, 0) and (0, 1, 0)",
            "loops:",
            "  ball  spherical  hand -> ground",
            "couplings:",
            "  mesh  ratio -2.5  ground -> arm",
        ]
    )
    assert str(replace(example(), links=(), joints=(), loops=(), couplings=())) == "example"


def test_representations_are_short() -> None:
    assert repr(example()) == ("<Description 'example': 3 links, 2 joints, 1 loop, 1 coupling>")
    assert repr(LINK) == "<LinkDescription 'arm': 2.5 kg>"
    assert repr(JOINT) == "<JointDescription 'hinge': revolute, 'ground' -> 'arm'>"
    assert repr(LOOP) == "<LoopDescription 'ball': universal, 'hand' -> 'ground'>"


def test_arrays_cannot_be_written_to() -> None:
    for description in (example(), pickle.loads(pickle.dumps(example()))):
        arrays = [description.links[0].inertia, description.joints[0].origin]
        arrays += [loop.axis for loop in description.loops]
        for array in arrays:
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0.0
