"""Words of URDF: misspelled ones are refused, those of other programs named in the warnings."""

from __future__ import annotations

from pathlib import Path

import pytest

import cardan_dyn as cd

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
def test_misspelled_elements_are_refused(written: str, misspelled: str, meant: str) -> None:
    text = LOOPED.replace(f"<{written} ", f"<{misspelled} ")
    text = text.replace(f"</{written}>", f"</{misspelled}>")
    with pytest.raises(cd.ModelError, match=f"'{misspelled}' is unknown .* did you mean '{meant}'"):
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
def test_misspelled_attributes_are_refused(written: str, misspelled: str, meant: str) -> None:
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


def test_files_are_named(tmp_path: Path) -> None:
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
