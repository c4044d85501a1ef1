"""Particle files and images of grids: their arrays, read without VTK.

A run writes few of the many forms that VTK knows: one piece, arrays in base64 that are compressed
by zlib, within their elements or appended.  These are read here, and no more is unpacked than a
file can hold; VTK trusts the numbers in a file.
"""

from __future__ import annotations

import binascii
import math
import zlib
from base64 import b64decode
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from debrisflow.errors import OutputError
from debrisflow.run.reading import must_be_file, xml_of

Array = NDArray[np.generic]
END = b"</VTKFile>"
TYPES = {
    f"{word}{bits}": f"{letter}{bits // 8}"
    for word, letter, sizes in (
        ("Float", "f", (32, 64)),
        ("Int", "i", (8, 16, 32, 64)),
        ("UInt", "u", (8, 16, 32, 64)),
    )
    for bits in sizes
}
MOST_COMPONENTS = 9
MOST_TIMES = 40.0
"""By which the particles of a file exceed its size at most; of a lattice at rest by 8."""
DEFLATE = 1032  # times that zlib shortens at most
SLACK = 2**20  # bytes that any file may take


class DamagedError(ValueError):
    """What is wrong with a file, in words that follow its name."""


class Points(NamedTuple):
    """The points of a file.

    Attributes
    ----------
    position : (n, 3) array or None, m
        None in an image.
    arrays : dict of str to (n,) or (n, components) array
        By their names.
    """

    position: Array | None
    arrays: dict[str, Array]


def read_points(file: Path, count: int | None = None) -> Points:
    """Return the points of a particle file, or of an image, and the arrays on them.

    Parameters
    ----------
    file : Path
    count : int, optional
        How many points there must be, where that is known.

    Raises
    ------
    OutputError
        If it is missing or damaged, or claims more than it can hold.
    """
    must_be_file(file)
    _must_be_whole(file)
    root = xml_of(file)
    try:
        return _points(root, file.stat().st_size, count)
    except DamagedError as error:
        raise OutputError(f"{file} is damaged: {error}") from error


def _must_be_whole(file: Path) -> None:
    with file.open("rb") as stream:
        stream.seek(max(0, file.stat().st_size - 64))
        if END not in stream.read():
            raise OutputError(f"{file} is damaged: it is cut off before its end")


def _points(root: ElementTree.Element, size: int, count: int | None) -> Points:
    """Return the points below the root of a file of a size, bytes."""
    pieces = root.findall("./*/Piece")
    if root.tag != "VTKFile" or len(pieces) != 1:
        raise DamagedError("it is no file of VTK with one piece")
    claimed = _count(pieces[0])
    if count is not None and claimed != count:
        raise DamagedError(f"it has {claimed} points where {count} are wanted")
    elements = pieces[0].findall("./PointData/DataArray")
    places = pieces[0].findall("./Points/DataArray")
    both = (*places, *elements)
    shapes = [_Shape.of(element, claimed, root) for element in both]
    # an image has no more points than its probe, but may be all zeros
    most = DEFLATE if count is not None else MOST_TIMES
    if sum(shape.bytes for shape in shapes) > most * size + SLACK:
        raise DamagedError(f"it claims {claimed} points, which a file of {size} bytes cannot hold")
    unpack = _Unpacking(root)
    found = [unpack.array(shape, element) for shape, element in zip(shapes, both, strict=True)]
    position = found[0] if places else None
    if position is not None and (len(places) > 1 or position.shape != (claimed, 3)):
        raise DamagedError("its points have no three coordinates")
    names = [shape.name for shape in shapes[len(places) :]]
    return Points(position, dict(zip(names, found[len(places) :], strict=True)))


def _count(piece: ElementTree.Element) -> int:
    """Return how many points a piece claims."""
    if "NumberOfPoints" in piece.attrib:
        return _number(piece, "NumberOfPoints")
    try:
        ends = [int(word) for word in piece.get("Extent", "").split()]
    except ValueError as error:
        raise DamagedError("its extent is no numbers") from error
    counts = [last - first + 1 for first, last in zip(ends[::2], ends[1::2], strict=False)]
    if len(ends) != 6 or min(counts) < 1:
        raise DamagedError("it has neither a number of points nor an extent")
    return math.prod(counts)


def _number(element: ElementTree.Element, name: str, default: str = "") -> int:
    """Return a number of an element that is not negative."""
    text = element.get(name, default).strip()
    if not (text.isascii() and text.isdecimal() and len(text) <= 18):
        raise DamagedError(f"{name} is no whole number: {text!r:.40}")
    return int(text)


@dataclass(frozen=True)
class _Shape:
    """What an element says of its array.

    Attributes
    ----------
    name : str
    type : numpy dtype
    rows, components : int
    """

    name: str
    type: np.dtype[np.generic]
    rows: int
    components: int

    @classmethod
    def of(cls, element: ElementTree.Element, rows: int, root: ElementTree.Element) -> _Shape:
        name = element.get("Name", "")
        known = TYPES.get(element.get("type", ""))
        if known is None:
            raise DamagedError(f"its array {name!r:.40} has no type that is known")
        components = _number(element, "NumberOfComponents", "1")
        if not 1 <= components <= MOST_COMPONENTS:
            raise DamagedError(f"its array {name!r:.40} has {components} components")
        return cls(name, np.dtype(_order(root) + known), rows, components)

    @property
    def bytes(self) -> int:
        """Return the size of the array."""
        return self.rows * self.components * self.type.itemsize


def _order(root: ElementTree.Element) -> str:
    return ">" if root.get("byte_order") == "BigEndian" else "<"


class _Unpacking:
    """Unpacks the arrays of a file.

    Parameters
    ----------
    root : Element
    """

    def __init__(self, root: ElementTree.Element) -> None:
        header = TYPES.get(root.get("header_type", "UInt32"), "")
        if header not in ("u4", "u8") or root.get("compressor") != "vtkZLibDataCompressor":
            raise DamagedError("it is not compressed as the files of a run are")
        self._header = np.dtype(_order(root) + header)
        appended = root.find("AppendedData")
        is_text = appended is not None and appended.get("encoding") == "base64"
        text = (appended.text or "").strip() if appended is not None and is_text else ""
        self._appended = text.removeprefix("_")

    def array(self, shape: _Shape, element: ElementTree.Element) -> Array:
        """Return the array of an element, (rows,) or (rows, components)."""
        form = element.get("format")
        if form == "binary":
            text = (element.text or "").strip()
        elif form == "appended":
            text = self._appended[_number(element, "offset") :]
        else:
            raise DamagedError(f"its array {shape.name!r:.40} is not in the form of a run's")
        try:
            blocks = b"".join(self._blocks(text, shape.bytes))
        except (binascii.Error, zlib.error, ValueError) as error:
            raise DamagedError(
                f"its array {shape.name!r:.40} cannot be unpacked: {error}"
            ) from error
        array = np.frombuffer(blocks, shape.type)
        # of the byte order of this machine, and writable, as arrays are that VTK reads
        array = array.astype(shape.type.newbyteorder("="))
        return array.reshape(shape.rows, shape.components) if shape.components > 1 else array

    def _blocks(self, text: str, size: int) -> Iterator[bytes]:
        """Yield the blocks of an array, which have a size together, bytes.

        A header in base64 tells their number, their size, that of the last one if it is another,
        and the compressed sizes; then the blocks follow one another in base64.
        """
        item = self._header.itemsize
        whole, block, last = self._numbers(text, 3)
        packed = self._numbers(text, 3 + whole)[3:] if whole <= len(text) // item else []
        if len(packed) != whole or (whole - (last > 0)) * block + last != size:
            raise ValueError("its size is not that of its points")
        start = _letters((3 + whole) * item)
        data = b64decode(text[start : start + _letters(sum(packed))], validate=True)
        if len(data) != sum(packed):
            raise ValueError("it is cut off")
        place = 0
        for number, length in enumerate(packed):
            wanted = last if last and number == whole - 1 else block
            unpacking = zlib.decompressobj()
            # a byte more tells what is too long, without unpacking all of it
            found = unpacking.decompress(data[place : place + length], wanted + 1)
            if len(found) != wanted:
                raise ValueError("a block has another size than its header tells")
            yield found
            place += length

    def _numbers(self, text: str, count: int) -> list[int]:
        """Return the first numbers of a header."""
        data = b64decode(text[: _letters(count * self._header.itemsize)], validate=True)
        found = np.frombuffer(data[: count * self._header.itemsize], self._header)
        if found.size != count:
            raise ValueError("its header is cut off")
        return [int(number) for number in found]


def _letters(count: int) -> int:
    """Return how many letters some bytes have in base64."""
    return 4 * -(-count // 3)
