"""XML files of other programs, read without ever following what they declare."""

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


def _parse(data: bytes, path: Path) -> Element:
    def refuse(*_):
        raise ReadError(path, "it declares a document type, which may hide anything", "remove the DOCTYPE")

    parser, builder = expat.ParserCreate(), TreeBuilder()
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
