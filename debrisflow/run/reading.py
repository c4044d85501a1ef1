"""Files of a run as text and XML: from others, perhaps, and so read with care.

What a file claims is compared with its size before memory is taken for it.  Only a regular file is
opened, since a pipe would never end.
"""

from __future__ import annotations

from collections.abc import Iterator
from io import BufferedReader, TextIOWrapper
from pathlib import Path, PureWindowsPath
from typing import NoReturn
from xml.etree import ElementTree

from debrisflow.errors import OutputError
from debrisflow.files import opened

CHUNK = 2**20  # bytes
MOST_BYTES = 4_000_000_000  # of a file; a frame of ten million particles has a quarter of it
DEEPEST = 64  # of elements within elements


def text_of(path: Path) -> str:
    """Return the text of a file in UTF-8, without a mark of byte order.

    Reading stops at the first zero byte, so that a file with a hole takes no memory for it.

    Raises
    ------
    OutputError
        If it is missing, is no regular file or is no text.
    """
    parts: list[bytes] = []
    with _opened(path) as file:
        while part := file.read(CHUNK):
            if b"\0" in part:
                raise OutputError(f"{path} cannot be read: it is no text, it has zero bytes")
            parts.append(part)
    try:
        return b"".join(parts).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise OutputError(f"{path} cannot be read: it is no text in UTF-8: {error}") from error


def lines_of(path: Path) -> Iterator[str]:
    """Yield the lines of a text, one after another; of what is no text, signs of replacement.

    Very long lines come in parts.

    Raises
    ------
    OutputError
        If it is missing or no regular file.
    """
    with TextIOWrapper(_opened(path), encoding="utf-8", errors="replace") as file:
        while line := file.readline(CHUNK):
            yield line.rstrip("\n")


def must_be_file(path: Path) -> None:
    """Refuse what is missing or no regular file, such as a pipe, a device or a folder.

    Raises
    ------
    OutputError
    """
    _opened(path).close()


def _opened(path: Path) -> BufferedReader:
    try:
        return opened(path, MOST_BYTES)
    except FileNotFoundError as error:
        raise OutputError(f"{path} is missing") from error
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(f"{path} cannot be read: {reason}") from error


class _Plain(ElementTree.TreeBuilder):
    """Builds elements, and refuses declarations of a document and elements that are very deep."""

    def __init__(self) -> None:
        super().__init__()
        self._depth = 0

    def doctype(self, *_: str | None) -> NoReturn:
        """Refuse a declaration: entities of one may expand without end or name other files."""
        raise ElementTree.ParseError("it declares a DOCTYPE, which no file of a run has")

    def start(self, tag: str, attrs: dict[str, str]) -> ElementTree.Element:
        """Begin an element."""
        self._depth += 1
        if self._depth > DEEPEST:
            raise ElementTree.ParseError(f"its elements are more than {DEEPEST} deep")
        return super().start(tag, attrs)

    def end(self, tag: str) -> ElementTree.Element:
        """End an element."""
        self._depth -= 1
        return super().end(tag)


def xml_of(path: Path, head: str = "") -> ElementTree.Element:
    """Return the root of an XML file without a DOCTYPE, and so without entities of its own.

    Parameters
    ----------
    path : Path
    head : str, optional
        With which the file may begin, and which is not read.

    Raises
    ------
    OutputError
        If it is missing, damaged or has a DOCTYPE.
    """
    text = text_of(path).removeprefix(head)
    try:
        return ElementTree.fromstring(text, ElementTree.XMLParser(target=_Plain()))
    except (ElementTree.ParseError, ValueError) as error:
        raise OutputError(f"{path} is damaged: {error}") from error


def within(folder: Path, name: str) -> Path:
    """Return a file that a file of a run names, which must lie within a folder.

    Parameters
    ----------
    folder : Path
    name : str
        With slashes between its parts.

    Raises
    ------
    ValueError
        If it is absolute, leads upwards, or leads out of the folder by a link.

    Examples
    --------
    >>> within(Path("run"), "vtu/000001.vtu").as_posix()
    'run/vtu/000001.vtu'
    >>> within(Path("run"), "../../etc/passwd")
    Traceback (most recent call last):
    ValueError: it names '../../etc/passwd', which is not within its folder
    """
    path = PureWindowsPath(name)  # has the roots and parts of both kinds of system
    is_plain = name.isprintable() and "\\" not in name and ":" not in name
    is_down = path.parts and ".." not in path.parts and not path.root
    if not (is_plain and is_down and _leads_into(folder, folder / name)):
        raise ValueError(f"it names {name!r:.200}, which is not within its folder")
    return folder / name


def _leads_into(folder: Path, file: Path) -> bool:
    """Return whether a file lies in a folder after its links are followed."""
    try:
        return file.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # links in a circle
        return False
