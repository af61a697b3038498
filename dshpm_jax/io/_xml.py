"""XML files of other programs, read without ever following what they declare."""

import re
from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from dshpm_jax.io._errors import ReadError

MAX_BYTES = 64 << 20
"""Subject files have some tens of kilobytes, musculoskeletal models some megabytes."""


def read_xml(path: Path, root: str) -> Element:
    """The root element of an XML file, which must be called `root`.

    A document type declaration is refused: entities can swell a small file without bound or fetch others, and no
    program that writes our formats declares any.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ReadError(path, f"more than {MAX_BYTES >> 20} MiB are no subject file", "give another file")
        data = path.read_bytes()
    except OSError as error:
        raise ReadError(path, f"cannot be read ({error.strerror})", "check the path and its permissions") from None
    if not data.strip():
        raise ReadError(path, "the file is empty", "export it again")
    found = _parse(data, path)
    if found.tag != root:
        raise ReadError(path, f"it holds <{found.tag[:40]}>, expected <{root}>", "give another file")
    return found


def _is_as_declared(data: bytes) -> bool:
    """Whether a file that says that it is UTF-8, or says nothing, is: people type names in other encodings."""
    declared = re.match(rb"""<\?xml[^>]*encoding\s*=\s*["']([^"']*)""", data)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") or (declared and declared[1].lower() not in (b"utf-8", b"utf8")):
        return True
    try:
        data.decode()
    except UnicodeDecodeError:
        return False
    return True


def _parse(data: bytes, path: Path) -> Element:
    def refuse(*_):
        raise ReadError(path, "it declares a document type, which may hide anything", "remove the DOCTYPE")

    encoding = None if _is_as_declared(data) else "iso-8859-1"
    parser, builder = expat.ParserCreate(encoding), TreeBuilder()
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, LookupError, ValueError) as error:  # the last two: encodings that nobody knows
        if isinstance(error, ReadError):
            raise
        raise ReadError(path, f"is no XML ({error})", "export it again") from None
    return builder.close()
