"""Bytes become the text that their byte order mark or declaration says, or an error."""

from __future__ import annotations

import codecs
from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import coupling, gears

import cardan_dyn as cd
from cardan_dyn.description.encoding import xml_text, yaml_text

NAME = "Zahnräder_µ"
PLAIN = gears(coupling("Prüfling", "a", "b", -2.5)).replace('name="gears"', f'name="{NAME}"')


def declared(encoding: str, quote: str = '"') -> str:
    return f"<?xml version='1.0' encoding = {quote}{encoding}{quote} ?>{PLAIN}"


BYTES = {
    "nothing": PLAIN.encode(),
    "utf-8": declared("UTF-8").encode(),
    "utf-8 with a mark": codecs.BOM_UTF8 + declared("utf8").encode(),
    "latin-1": declared("ISO-8859-1").encode("iso-8859-1"),
    "single quotes": declared("iso-8859-15", "'").encode("iso-8859-15"),
    "windows": declared("Windows-1252").encode("cp1252"),
    "macintosh": declared("macintosh").encode("mac-roman"),
    "utf-16": declared("UTF-16").encode("utf-16"),
    "utf-16, big": codecs.BOM_UTF16_BE + declared("utf-16").encode("utf-16-be"),
    "utf-16, undeclared": PLAIN.encode("utf-16"),
    "utf-16 without a mark": declared("utf-16").encode("utf-16-le"),
    "utf-16-be without a mark": declared("UTF-16BE").encode("utf-16-be"),
    "utf-32": declared("utf-32").encode("utf-32"),
    "utf-32 without a mark": declared("UTF-32LE").encode("utf-32-le"),
}


@pytest.mark.parametrize("data", BYTES.values(), ids=BYTES.keys())
def test_encodings(data: bytes, tmp_path: Path) -> None:
    """Names come back, and the proof, which reads the text again, agrees."""
    path = tmp_path / "räder.urdf"
    path.write_bytes(data)
    mechanism = cd.load(path)
    assert mechanism.name == NAME
    assert mechanism.description == cd.load(PLAIN).description
    turn = cd.Scene(mechanism, drive="a", loads={"b": 1.0}).sweep([0.3, 0.4])
    np.testing.assert_allclose(turn.coupling_moment["Prüfling"], -1.0)


@pytest.mark.parametrize("encoding", ["utf-16", "iso-8859-1", "x-unknown"])
def test_the_declaration_of_a_text_does_not_count(encoding: str) -> None:
    """A text has been decoded already."""
    assert cd.load(declared(encoding)).name == NAME


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (declared("utf-8").encode("latin-1"), r"are not in the encoding 'utf-8' .*'utf-8' codec"),
        (PLAIN.encode("latin-1"), r"its bytes are not in utf-8 \(.*\); declare the encoding"),
        (declared("us-ascii").encode(), "not in the encoding 'us-ascii' that it declares"),
        (declared("cp1252").encode("latin-1") + b"<!--\x81-->", "not in the encoding 'cp1252'"),
        (declared("utf-16").encode(), "declares the encoding 'utf-16', which is unknown or none"),
        (declared("klingon").encode(), "'klingon', which is unknown or none .* save it in UTF-8"),
        (declared("").encode(), ""),
        (declared("rot13").encode(), "'rot13', which is unknown"),
        (declared("hex").encode(), "'hex', which is unknown"),
        (declared("unicode_escape").encode(), "'unicode_escape', which is unknown"),
        (declared("utf-7").encode(), "'utf-7', which is unknown"),
        (declared("idna").encode(), "'idna', which is unknown"),
        (declared("a\x00b").encode(), ""),
        (declared("latin-1").encode("utf-16"), "declares .* 'latin-1', but .* those of utf-16"),
        (codecs.BOM_UTF8 + declared("cp1252").encode(), "'cp1252', but .* those of utf-8;"),
        (declared("utf-8").encode("utf-16-le"), "'utf-8', but .* those of utf-16-le"),
        (codecs.BOM_UTF16_LE + b"\x00\xd8<", "its bytes are not in utf-16"),
    ],
)
def test_wrong_declarations(data: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.urdf"
    path.write_bytes(data)
    with pytest.raises(cd.ModelError, match=rf"wrong\.urdf: .*{message}"):
        cd.load(path)


def test_what_stands_in_a_comment_declares_nothing() -> None:
    text = '<robot name="ä"><!-- <?xml encoding="latin-1"?> --></robot>'
    assert xml_text(text.encode(), "x") == text


def test_yaml_is_unicode() -> None:
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "utf-32"):
        assert yaml_text("name_mot: [ä]".encode(encoding), "x") == "name_mot: [ä]"
    with pytest.raises(cd.ModelError, match=r"x: .* not in utf-8 .*; declare|save"):
        yaml_text("ä".encode("latin-1"), "x")


def test_included_files_have_their_own_encodings(tmp_path: Path) -> None:
    (tmp_path / "part.xml").write_bytes(
        '<?xml version="1.0" encoding="latin-1"?><mujoco><worldbody><body name="Körper"/>'
        "</worldbody></mujoco>".encode("latin-1")
    )
    main = tmp_path / "main.xml"
    main.write_bytes('<mujoco model="ß"><include file="part.xml"/></mujoco>'.encode("utf-16"))
    assert "Körper" in cd.load(main).links
