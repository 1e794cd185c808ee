"""Words of SDFormat: the elements and attributes that are known, by element.

A word that is not here is refused. If unknown words were passed over, a misspelt `expressed_in`
would turn an axis. The lists are those of SDFormat 1.12, and what versions from 1.4 on knew
besides. Elements of another namespace belong to other programs and are named in the warnings.
"""

from __future__ import annotations

from xml.etree import ElementTree

from ...errors import ModelError, choices


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


CHILDREN = {
    tag: _words(words)
    for tag, words in {
        "sdf": "model world actor light",
        "world": "model include frame joint actor atmosphere audio gravity gui light "
        "magnetic_field physics plugin population road scene spherical_coordinates state wind",
        "model": "static self_collide allow_auto_disable enable_wind frame pose link joint plugin "
        "gripper include model",
        "frame": "pose",
        "link": "pose inertial gravity enable_wind self_collide kinematic must_be_base_link "
        "velocity_decay collision visual sensor projector audio_sink audio_source battery light "
        "particle_emitter material frame plugin",
        "inertial": "mass pose inertia density auto_inertia_params fluid_added_mass frame",
        "inertia": "ixx iyy izz ixy ixz iyz",
        "velocity_decay": "linear angular",
        "joint": "parent child pose axis axis2 physics sensor gearbox_ratio "
        "gearbox_reference_body thread_pitch screw_thread_pitch frame",
        "axis": "xyz dynamics limit mimic initial_position use_parent_model_frame",
        "axis2": "xyz dynamics limit mimic initial_position use_parent_model_frame",
        "dynamics": "damping friction spring_reference spring_stiffness",
        "limit": "lower upper effort velocity stiffness dissipation",
        "physics": "simbody ode provide_feedback",
    }.items()
}
"""Element to its children, for the elements that are read; others may contain anything."""
ATTRIBUTES = {
    tag: _words(words)
    for tag, words in {
        "sdf": "version",
        "world": "name",
        "model": "name canonical_link placement_frame namespace",
        "frame": "name attached_to",
        "pose": "relative_to frame rotation_format degrees",
        "link": "name",
        "inertial": "auto",
        "joint": "name type",
        "xyz": "expressed_in",
    }.items()
}
"""Element to its attributes; other elements that are read have none."""
_NOT_READ = _words(
    "collision visual sensor projector audio_sink audio_source battery light particle_emitter "
    "material plugin gripper physics include auto_inertia_params fluid_added_mass actor "
    "atmosphere audio gravity gui magnetic_field population road scene spherical_coordinates "
    "state wind mimic"
)
"""Known elements whose contents are read elsewhere or have nothing to do with wrenches."""


def check_words(root: ElementTree.Element, where: str, strict: bool) -> list[str]:
    """Refuse unknown elements and attributes; return warnings about those that are passed over.

    Args:
        root: outermost element of an SDF text.
        where: how messages name the source of the text.
        strict: whether unknown words of no namespace are refused.

    Raises:
        ModelError: a word is not known; the message lists those that are.
    """
    passed_over: dict[str, int] = {}
    waiting = [root]
    while waiting:
        element = waiting.pop()
        for kind, words, known in (
            ("element", [child.tag for child in element], CHILDREN.get(element.tag, frozenset())),
            ("attribute", list(element.keys()), ATTRIBUTES.get(element.tag, frozenset())),
        ):
            for word in words:
                if isinstance(word, str) and word not in known:
                    _check_word(word, kind, element, known, where, strict)
                    label = f"{kind} {word!r} of <{element.tag}>"
                    passed_over[label] = passed_over.get(label, 0) + 1
        known = CHILDREN.get(element.tag, frozenset())
        waiting += [child for child in element if child.tag in known - _NOT_READ]
    return [
        f"{where}: {label} is unknown and was passed over" + (f" ({count} times)" * (count > 1))
        for label, count in passed_over.items()
    ]


def _check_word(
    word: str,
    kind: str,
    element: ElementTree.Element,
    known: frozenset[str],
    where: str,
    strict: bool,
) -> None:
    """Refuse an unknown word, unless it belongs to the namespace of another program."""
    if not strict or "}" in word or ":" in word:
        return
    name = f" {element.get('name')!r}" if element.get("name") else ""
    raise ModelError(
        f"{where}: <{element.tag}>{name}: {kind} {word!r} is unknown; {kind}s: "
        f"{choices(known, word)}; load(..., strict=False) passes it over"
    )
