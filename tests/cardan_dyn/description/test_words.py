"""Misspelled words are refused, those of other programs named in the warnings."""

from __future__ import annotations

from pathlib import Path

import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.words import similar_word, unknown_keys

LOOPED = (
    '<robot name="r"><link name="a"/><link name="b"/>'
    '<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
    '<origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>'
    '<loop name="l" type="continuous"><predecessor link="a"/>'
    '<successor link="b"><origin xyz="-1 0 0"/></successor><axis xyz="0 0 1"/></loop></robot>'
)


@pytest.mark.parametrize(
    ("written", "misspelled", "meant"),
    [
        ("loop", "lop", "loop"),
        ("loop", "loops", "loop"),
        ("loop", "Loop", "loop"),
        ("axis", "axs", "axis"),
        ("axis", "axsi", "axis"),
        ("axis", "axes", "axis"),
        ("loop", "lopo", "loop"),
        ("predecessor", "predecesor", "predecessor"),
        ("origin", "orign", "origin"),
    ],
)
def test_misspelled_elements_of_urdf_are_refused(written: str, misspelled: str, meant: str) -> None:
    text = LOOPED.replace(f"<{written} ", f"<{misspelled} ")
    text = text.replace(f"</{written}>", f"</{misspelled}>")
    with pytest.raises(cd.ModelError, match=f"'{misspelled}' is unknown; did you mean '{meant}'"):
        cd.load(text)


@pytest.mark.parametrize(
    ("written", "misspelled", "meant"),
    [
        ('axis xyz="', 'axis xy="', "xyz"),
        ('axis xyz="', 'axis xzy="', "xyz"),
        ('axis xyz="', 'axis zyx="', "xyz"),
        ('origin xyz="', 'origin xyy="', "xyz"),
        ('type="', 'typ="', "type"),
    ],
)
def test_misspelled_attributes_of_urdf_are_refused(
    written: str, misspelled: str, meant: str
) -> None:
    with pytest.raises(cd.ModelError, match=f"did you mean '{meant}'"):
        cd.load(LOOPED.replace(written, misspelled))


def test_lenient_reading_warns_of_misspelled_words() -> None:
    text = LOOPED.replace("<loop ", "<lop ").replace("</loop>", "</lop>")
    mechanism = cd.load(text, strict=False)
    assert mechanism.loops == ()
    assert any("'lop' of <robot> is unknown" in warning for warning in mechanism.warnings)


def test_words_of_other_programs_are_named_once() -> None:
    text = LOOPED.replace(
        "</robot>",
        '<sensor name="imu"/><sensor name="camera"/><gazebo reference="a"><anything/></gazebo>'
        '<x:lop xmlns:x="http://example.org/other"/></robot>',
    )
    assert [warning.split(": ", 1)[1] for warning in cd.load(text).warnings] == [
        "element 'sensor' of <robot> is unknown and was passed over (2 times)",
        "elements of the namespace 'http://example.org/other' were passed over",
        "<gazebo> is for other programs and was passed over",
    ]


@pytest.mark.parametrize("name", cd.bundled_names())
def test_bundled_descriptions_contain_no_unknown_word(name: str) -> None:
    mechanism = cd.load(name)
    # Springs are the one thing that waits to be taken.
    springs = [line for line in mechanism.warnings if "elements=described_elements" in line]
    assert list(mechanism.warnings) == springs
    assert bool(springs) == bool(mechanism.joint_springs)


def test_shapes_may_contain_anything() -> None:
    shape = '<visual><geometry><mesh filename="a.stl" scal="1 1 1"/></geometry></visual>'
    text = LOOPED.replace('<link name="a"/>', f'<link name="a">{shape}</link>')
    assert not cd.load(text).warnings


def test_urdf_files_are_named(tmp_path: Path) -> None:
    path = tmp_path / "wrong.urdf"
    path.write_text(LOOPED.replace("<axis ", "<axs "), encoding="utf-8")
    with pytest.raises(cd.ModelError, match=r"wrong\.urdf: <joint> 'j': element 'axs'"):
        cd.load(path)


def test_axes_without_numbers_are_refused() -> None:
    with pytest.raises(cd.ModelError, match="<axis> has no xyz"):
        cd.load(LOOPED.replace('axis xyz="', 'axis direction="'), strict=False)


@pytest.mark.parametrize("word", ["gear_velocity", "soft_lower", "jerk"])
def test_words_of_published_robots_pass(word: str) -> None:
    limit = f'<limit lower="-1" upper="1" effort="1" velocity="1" {word}="2"/>'
    text = LOOPED.replace('<axis xyz="0 0 1"/></joint>', f'<axis xyz="0 0 1"/>{limit}</joint>')
    assert any(word in warning for warning in cd.load(text).warnings)


SDF = '<sdf version="1.9"><model name="m"><link name="a">{}</link></model></sdf>'
MASS = "<inertial><mass>1</mass>{}</inertial>"


def test_known_words_of_sdf_pass() -> None:
    inside = '<pose relative_to="__model__">0 0 0 0 0 0</pose><visual name="v"><anything/></visual>'
    found = cd.load(SDF.format(inside)).warnings
    assert not any("unknown and" in warning for warning in found)


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("<inertal/>", "<link> 'a': element 'inertal' is unknown; did you mean 'inertial'"),
        ('<pose relativ_to="b"/>', "<pose>: attribute 'relativ_to'.*did you mean 'relative_to'"),
        (MASS.format("<inertia><lxx>1</lxx></inertia>"), "element 'lxx' is unknown; did you"),
        ('<inertial><mass unit="g">1</mass></inertial>', "<mass>: attribute 'unit' .*: none"),
        ("<odd/>", "<link> 'a': element 'odd' is unknown; elements: "),
    ],
)
def test_unknown_words_of_sdf(inside: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(SDF.format(inside))


def test_lenient_reading_of_sdf_warns() -> None:
    found = cd.load(SDF.format("<odd/><odd/>"), strict=False).warnings
    assert "SDF text: element 'odd' of <link> is unknown and was passed over (2 times)" in found


def test_what_other_programs_write_into_sdf_is_named() -> None:
    text = SDF.format("<d:gravity/><d:gravity/>").replace("<sdf ", '<sdf xmlns:d="drake" ')
    found = cd.load(text).warnings
    assert "SDF text: elements of the namespace 'drake' were passed over" in found


KNOWN = ("closed_loop", "type", "name_mot")


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("types", "type"),
        ("tpye", "type"),
        ("closed_lop", "closed_loop"),
        ("name_motor", "name_mot"),
        ("typists", None),
        ("foo", None),
    ],
)
def test_similar_words_are_found(word: str, meant: str | None) -> None:
    assert similar_word(word, KNOWN) == meant


def test_keys_that_are_misspelled_are_refused_and_others_named() -> None:
    assert unknown_keys(["foo", "type", 7, "foo"], KNOWN, "file", strict=True) == [
        "file: foo is unknown and was passed over",
        "file: 7 is unknown and was passed over",
    ]
    with pytest.raises(cd.ModelError, match=r"file: key 'types' is unknown; did you mean 'type'"):
        unknown_keys(["types"], KNOWN, "file", strict=True)
    assert unknown_keys(["types"], KNOWN, "file", strict=False) == [
        "file: types is unknown and was passed over"
    ]
