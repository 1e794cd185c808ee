"""Encoding: bytes of XML and YAML files to text, as their byte order mark or declaration says.

XML 1.0 (appendix F) finds the encoding from the first bytes: a byte order mark, or how `<?xml` is
written; of those that write ASCII as ASCII, the declaration names one, UTF-8 without any.
"""

from __future__ import annotations

import codecs
import re
import warnings

from ..errors import ModelError

_MARKS = (
    # UTF-32 first: its mark for little endian begins with the one of UTF-16.
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (codecs.BOM_UTF8, "utf-8-sig"),
)
"""Byte order marks, with the codec that removes them."""
_UNMARKED = (
    (b"<\0\0\0?\0\0\0", "utf-32-le"),
    (b"\0\0\0<\0\0\0?", "utf-32-be"),
    (b"<\0?\0", "utf-16-le"),
    (b"\0<\0?", "utf-16-be"),
)
"""How a declaration begins in encodings that do not write ASCII as ASCII."""
_DECLARED = re.compile(r"<\?xml\s[^>]*?\bencoding\s*=\s*(?:\"([^\"<>]*)\"|'([^'<>]*)')", re.ASCII)
_LONGEST_DECLARATION = 1000
"""Bytes in which a declaration ends; of longer ones no encoding is read, and the parser refuses
what is no UTF-8."""
_PROBE = r"""<a b="\x41 \u0041 +AGE- .xn--mnchen-3ya. ~{ &c;"/>"""
"""ASCII that an encoding of XML has to leave as it is: Python also has codecs for escapes, UTF-7
and names of hosts, which would read other numbers from the same bytes than everybody else."""


def xml_text(data: bytes, where: str) -> str:
    """Return the text of an XML file, without a byte order mark.

    Args:
        data: the bytes of the file.
        where: how messages name the file.

    Raises:
        ModelError: the declared encoding is unknown, or the bytes are not in it.
    """
    found = next((codec for mark, codec in (*_MARKS, *_UNMARKED) if data.startswith(mark)), None)
    head = data[:_LONGEST_DECLARATION].decode(found or "latin-1", errors="replace")
    match = _DECLARED.match(head)
    declared = "" if match is None else match[1] or match[2] or ""
    if found is None:
        return _decoded(data, _checked(declared, where) if declared else "utf-8", declared, where)
    if declared and _family(declared) != _family(found):
        raise ModelError(
            f"{where}: it declares the encoding {declared!r}, but its first bytes are those of "
            f"{found.removesuffix('-sig')}; correct the declaration, or save it in {declared}"
        )
    return _decoded(data, found, declared, where)


def yaml_text(data: bytes, where: str) -> str:
    """Return the text of a YAML file: UTF-8, or UTF-16 and UTF-32 with a byte order mark.

    Raises:
        ModelError: the bytes are not in that encoding.
    """
    found = next((codec for mark, codec in _MARKS if data.startswith(mark)), "utf-8")
    return _decoded(data, found, "", where)


def _family(name: str) -> str:
    """Return the name of an encoding without its byte order, as codecs write it."""
    return re.sub(r"[-_]?(le|be|sig)$", "", name.lower()).replace("_", "-").replace("utf8", "utf-8")


def _checked(declared: str, where: str) -> str:
    """Return the declared encoding of a file that writes ASCII as ASCII.

    Raises:
        ModelError: Python does not know it, or it is another kind of code.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # The codec for escapes warns of unknown ones.
            is_kept = _PROBE.encode("ascii").decode(declared) == _PROBE
    except (LookupError, ValueError):  # Unknown; not for text; not the one of these bytes.
        is_kept = False
    if not is_kept:
        raise ModelError(
            f"{where}: it declares the encoding {declared!r}, which is unknown or none that its "
            'first bytes can be in; save it in UTF-8 and write encoding="utf-8"'
        )
    return declared


def _decoded(data: bytes, codec: str, declared: str, where: str) -> str:
    """Return bytes as text.

    Args:
        data: the bytes.
        codec: of Python.
        declared: the encoding that the file names; empty without one.
        where: how messages name the file.

    Raises:
        ModelError: the bytes are not in that encoding.
    """
    try:
        return data.decode(codec)
    except (ValueError, MemoryError) as error:
        source = f"the encoding {declared!r} that it declares" if declared else codec
        raise ModelError(
            f"{where}: cannot be read as text: its bytes are not in {source} ({error}); declare "
            "the encoding that it was saved in, or save it in UTF-8"
        ) from error
