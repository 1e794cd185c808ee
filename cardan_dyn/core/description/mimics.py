"""Mimics: joints of the tree that follow others, as `<mimic>` of URDF says.

`<mimic joint="a" multiplier="k" offset="c"/>` in a joint says that its coordinate is k times that
of joint a plus c. It is a coupling of joints. It may have a `name`, which URDF does not know.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from xml.etree.ElementTree import Element

from ...kit.errors import ModelError, choices
from .coupled_forces import with_forces
from .description import CouplingDescription, JointDescription
from .elements import SINGLE_TYPES, number, only, unique
from .left_out import line_of


def mimics(
    robot: Element,
    joints: Iterable[JointDescription],
    taken: Collection[str],
    where: str,
    solved: Collection[str] = (),
) -> tuple[list[CouplingDescription], list[str]]:
    """Return the couplings that the joints of a URDF state, and warnings about what is left out.

    The couplings have the order of the joints. A fixed joint follows nothing: robots whose grippers
    were fixed still have its mimics. Nor does a joint that loops decide.

    Args:
        robot: outermost element of the URDF.
        joints: its joints.
        taken: names of its loops and of its couplings of links.
        where: how messages name the source of the text.
        solved: joints that loops decide, which their mimics only approximate.

    Raises:
        ModelError: what is wrong with one of them.
    """
    known = {joint.name: joint for joint in joints}
    stated = {}
    for element in robot.findall("joint"):
        name = element.get("name", "")
        mimic = only(element, "mimic", f"{where}: joint {name!r}")
        if mimic is not None:
            stated[name] = mimic
    names = {*known, *taken, *(mimic.get("name", "") for mimic in stated.values())}
    at_rest = [joint for joint in stated if known[joint].type == "fixed"]
    result = []
    for joint, mimic in stated.items():
        if joint in at_rest or joint in solved:
            continue
        name = mimic.get("name") or unique(default_name(joint), names)
        result.append(_mimic(name, joint, mimic, known, f"{where}: joint {joint!r}: <mimic>"))
    check_mimics(result, where)
    decided = [joint for joint in stated if joint in solved and joint not in at_rest]
    return result, [
        *line_of(where, "<mimic>", at_rest, "fixed joints follow nothing"),
        *line_of(where, "<mimic>", decided, "loops decide where these joints are"),
    ]


def default_name(joint: str) -> str:
    """Return the name of the coupling by which a joint mimics another, unless it is taken."""
    return f"{joint}_mimic"


def check_mimics(couplings: Iterable[CouplingDescription], where: str) -> None:
    """Refuse couplings of joints that `<mimic>` cannot state.

    Raises:
        ModelError: a joint mimics several others, or joints mimic each other in a circle.
    """
    mimicked: dict[str, str] = {}
    for coupling in couplings:
        if not coupling.of_joints:
            continue
        if coupling.successor in mimicked:
            raise ModelError(
                f"{where}: joint {coupling.successor!r} mimics {mimicked[coupling.successor]!r} "
                f"and {coupling.predecessor!r}; let it mimic one of them"
            )
        mimicked[coupling.successor] = coupling.predecessor
    for joint in mimicked:
        chain = [joint]
        while chain[-1] in mimicked:
            chain.append(mimicked[chain[-1]])
            if chain[-1] == joint:
                raise ModelError(
                    f"{where}: joints mimic each other in a circle: {' -> '.join(chain)}; "
                    "remove one <mimic>"
                )
            if chain[-1] in chain[:-1]:
                break  # A circle that this joint is not part of; the next ones find it.


def _mimic(
    name: str,
    joint: str,
    mimic: Element,
    joints: Mapping[str, JointDescription],
    at: str,
) -> CouplingDescription:
    mimicked = mimic.get("joint")
    single = [other.name for other in joints.values() if other.type in SINGLE_TYPES]
    if not mimicked:
        raise ModelError(f'{at}: joint="..." is missing; joints: {choices(single)}')
    if mimicked not in joints:
        listed = choices(single, mimicked)
        raise ModelError(f"{at}: joint {mimicked!r} does not exist; joints: {listed}")
    if mimicked == joint:
        raise ModelError(f"{at}: a joint cannot mimic itself; name another one, or remove <mimic>")
    for end in (joints[joint], joints[mimicked]):
        if end.type not in SINGLE_TYPES:
            raise ModelError(
                f"{at}: joint {end.name!r} is {end.type}; only joints with one coordinate mimic "
                f"and are mimicked: {choices(single)}; remove <mimic>, or change the type"
            )
    multiplier = number(mimic.get("multiplier"), "1", f"{at} multiplier")
    offset = number(mimic.get("offset"), "0", f"{at} offset")
    coupling = CouplingDescription(name, mimicked, joint, multiplier, offset, of_joints=True)
    return with_forces(coupling, mimic, at)
