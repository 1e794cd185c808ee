"""Files are read as their byte order mark or declaration says, or refused."""

from __future__ import annotations

import codecs
from pathlib import Path

import numpy as np
import pytest
from testkit.linkages import coupling, gears

import cardan_dyn as cd

NAME = "Zahnräder_µ"
PLAIN = gears(coupling("Prüfling", "a", "b", -2.5)).replace('name="gears"', f'name="{NAME}"')


def declared(encoding: str, quote: str = '"') -> str:
    return f"<?xml version='1.0' encoding = {quote}{encoding}{quote} ?>{PLAIN}"


BYTES = {
    "nothing": PLAIN.encode(),
    "utf-8": declared("UTF-8").encode(),
    "utf-8, called otherwise": declared("utf8").encode(),
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
    # Marks and null bytes leave no choice, whatever is declared.
    "utf-8 with a mark, declared otherwise": codecs.BOM_UTF8 + declared("cp1252").encode(),
    "utf-16, declared otherwise": declared("latin-1").encode("utf-16"),
    "utf-16 without a mark, declared otherwise": declared("utf-8").encode("utf-16-le"),
}


@pytest.mark.parametrize("data", BYTES.values(), ids=BYTES.keys())
def test_encodings(data: bytes, tmp_path: Path) -> None:
    """Names come back, and the proof, which reads the text again, agrees."""
    path = tmp_path / "räder.urdf"
    path.write_bytes(data)
    mechanism = cd.load(path)
    assert mechanism.name == NAME
    assert mechanism.description == cd.load(PLAIN).description
    assert mechanism.description.source.text.endswith(PLAIN)
    turn = cd.Scene(mechanism, drive="a", loads={"b": 1.0}).sweep([0.3, 0.4])
    np.testing.assert_allclose(turn.coupling_moment["Prüfling"], -1.0)


@pytest.mark.parametrize("encoding", ["gb2312", "GBK", "gb18030", "big5", "Shift_JIS", "euc-jp"])
def test_encodings_of_several_bytes_a_letter(encoding: str, tmp_path: Path) -> None:
    """Some of their second bytes are those of `\\` and `|` in ASCII."""
    path = tmp_path / "a.urdf"
    text = declared(encoding).replace("Prüfling", "teeth").replace(NAME, "表一")
    path.write_bytes(text.encode(encoding))
    assert cd.load(path).name == "表一"
    path.write_bytes(path.read_bytes().replace("表一".encode(encoding), b"\xff\xff"))
    with pytest.raises(cd.ModelError, match=r"a\.urdf: malformed XML: .*codec can't decode"):
        cd.load(path)


def test_other_documents_are_refused_in_any_encoding(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    for encoding in ("utf8", "gbk", "latin-1", "utf-16"):
        head, _, rest = declared(encoding).replace("ü", "u").replace("ä", "a").partition("?>")
        text = f'{head}?><!DOCTYPE robot SYSTEM "file:///nowhere">{rest}'.replace("µ", "m")
        path.write_bytes(text.encode(encoding))
        with pytest.raises(cd.ModelError, match="its DOCTYPE refers to another document"):
            cd.load(path)


@pytest.mark.parametrize("encoding", ["utf-16", "iso-8859-1", "x-unknown"])
def test_the_declaration_of_a_text_does_not_count(encoding: str) -> None:
    """A text has been decoded already."""
    assert cd.load(declared(encoding)).name == NAME


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (declared("utf-8").encode("latin-1"), "is it in the encoding that it declares"),
        (PLAIN.encode("latin-1"), "is it in the encoding that it declares, UTF-8 where"),
        (declared("us-ascii").encode(), "is it in the encoding that it declares"),
        (declared("cp1252").encode("latin-1") + b"<!--\x81-->", "is it in the encoding"),
        (declared("utf-16").encode(), "is it in the encoding that it declares"),
        (declared("klingon").encode(), "unknown encoding: klingon"),
        (declared("").encode(), "XML declaration not well-formed"),
        (declared("rot13").encode(), "'rot13' is not a text encoding"),
        (declared("hex").encode(), "'hex' is not a text encoding"),
        (declared("utf-7").encode(), "is it in the encoding that it declares"),
        (declared("idna").encode(), "is it in the encoding that it declares"),
        (declared("a\x00b").encode(), "malformed XML"),
        (codecs.BOM_UTF16_LE + b"\x00\xd8<", "cannot be read .*'utf-16"),
    ],
)
def test_wrong_declarations(data: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.urdf"
    path.write_bytes(data)
    with pytest.raises(cd.ModelError, match=rf"wrong\.urdf: .*{message}"):
        cd.load(path)


def test_what_stands_in_a_comment_declares_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    path.write_text(PLAIN.replace("<link", '<!-- <?xml encoding="latin-1"?> --><link', 1), "utf-8")
    assert cd.load(path).name == NAME


def test_included_files_have_their_own_encodings(tmp_path: Path) -> None:
    (tmp_path / "part.xml").write_bytes(
        '<?xml version="1.0" encoding="latin-1"?><mujoco><worldbody><body name="Körper"/>'
        "</worldbody></mujoco>".encode("latin-1")
    )
    main = tmp_path / "main.xml"
    main.write_bytes('<mujoco model="ß"><include file="part.xml"/></mujoco>'.encode("utf-16"))
    assert "Körper" in cd.load(main).links


@pytest.mark.parametrize("as_file", [False, True])
def test_comments_that_xml_forbids_and_gazebo_reads(as_file: bool, tmp_path: Path) -> None:
    """Its own worlds show calls with `--option` in comments, and begin with an empty line."""
    plain = '<robot name="x"><link name="a"/>{}</robot>'
    text = "\n" + plain.format('<!-- gz topic --help\n --> <link name="b"/><!-- x -- y -->')
    joint = (
        '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
        "<!-- gz sim -v --></robot>"
    )
    source: str | Path = text.replace("</robot>", joint)
    if as_file:
        path = tmp_path / "robot.urdf"
        path.write_text(str(source), encoding="utf-8")
        source = path
    mechanism = cd.load(source)
    assert [link.name for link in mechanism.description.links] == ["a", "b"]
    assert cd.Mechanism(mechanism.description).description == mechanism.description
    with pytest.raises(cd.ModelError, match="malformed XML"):
        cd.load(text.replace('<link name="b"/>', "<link name=b/>"))
