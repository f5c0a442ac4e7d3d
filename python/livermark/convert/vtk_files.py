"""Reads VTK files, legacy (to version 5.1) and XML: polydata and unstructured grids, with all of their pieces and arrays.
Meshes are made of them in vtk_grids.

The reader of meshio loses pieces, takes no axes from field data, and knows few types of numbers; VTK itself is 240 MB more
than what is installed for other reasons. https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html"""
from __future__ import annotations

import base64
import lzma
import re
import urllib.parse
import xml.etree.ElementTree as ElementTree
import zlib
from typing import Any, NamedTuple, Optional

import numpy

from livermark.errors import InputError

#: VTK writes its vtkIdType as int.
LEGACY_TYPES = {"char": "i1", "signed_char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2", "int": "i4",
                "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8", "vtkidtype": "i4", "float": "f4", "double": "f8",
                **{f"vtktype{sign}int{8 * size}": f"{sign or 'i'}{size}" for sign in ("", "u") for size in (1, 2, 4, 8)}}
XML_TYPES = {"Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
             "UInt64": "u8", "Float32": "f4", "Float64": "f8", "String": "u1"}
SECTIONS_OF_CELLS = ("CELLS", "POLYGONS", "TRIANGLE_STRIPS", "VERTICES", "LINES")
COMPONENTS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1}


class Cells(NamedTuple):
    corners: numpy.ndarray  #: point numbers of all cells, one cell after the other
    ends: numpy.ndarray  #: (M) where each cell ends

    def lists(self) -> list[numpy.ndarray]:
        return numpy.split(self.corners, self.ends[:-1]) if len(self.ends) else []


class Piece:
    def __init__(self) -> None:
        self.points = numpy.zeros((0, 3))
        self.cells: dict[str, Cells] = {}  # by the names of legacy sections
        self.types = numpy.zeros(0, dtype=int)  # of CELLS
        self.point_data: dict[str, numpy.ndarray] = {}
        self.cell_data: dict[str, numpy.ndarray] = {}
        self.not_numbers: list[str] = []  # names of other values


class Dataset(NamedTuple):
    kind: str  #: POLYDATA or UNSTRUCTURED_GRID
    texts: dict[str, str]  #: of field data
    pieces: list[Piece]


def shown(word: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in word[:40])


def _too_short() -> InputError:
    return InputError("the file ends too early")


def checked_cells(corners: Any, ends: Any) -> Cells:
    cells = Cells(numpy.asarray(corners).astype(int), numpy.asarray(ends).astype(int))
    if (numpy.diff(cells.ends, prepend=0) < 0).any() or (cells.ends[-1] if len(cells.ends) else 0) != len(cells.corners):
        raise InputError("the numbers of corners of its cells do not fit the list of corners")
    return cells


def _rows(values: numpy.ndarray, num_components: int) -> numpy.ndarray:
    return values if num_components == 1 else values.reshape(-1, num_components)


class _Legacy:
    """Reads word by word; numbers in binary files are big-endian."""

    def __init__(self, data: bytes) -> None:
        lines = data.split(b"\n", 3)
        if len(lines) < 4:
            raise _too_short()
        kind = lines[2].strip().upper()
        if kind not in (b"ASCII", b"BINARY"):
            raise InputError("the third line says neither ASCII nor BINARY")
        self.is_binary = kind == b"BINARY"
        self.data = lines[3]
        self.at = 0

    def word(self) -> str:
        found = re.compile(rb"\s*(\S+)").match(self.data, self.at)
        if not found:
            return ""
        self.at = found.end()
        return found[1].decode("ascii", "replace")

    def name(self) -> str:
        return urllib.parse.unquote(self.word())

    def count(self) -> int:
        text = self.word()
        if not text.isdigit():
            raise InputError(f"'{shown(text)}' has to be a number of things")
        return int(text)

    def rest_of_line(self) -> list[str]:
        end = self.data.find(b"\n", self.at)
        words = self.data[self.at:end if end >= 0 else len(self.data)].decode("ascii", "replace").split()
        self.at = end if end >= 0 else len(self.data)
        return words

    def line_end(self) -> None:
        end = self.data.find(b"\n", self.at)
        self.at = len(self.data) if end < 0 else end + 1

    def next_is(self, word: str) -> bool:
        mark = self.at
        if self.word().upper() == word:
            return True
        self.at = mark
        return False

    def take(self, num_bytes: int) -> bytes:
        if self.at + num_bytes > len(self.data):
            raise _too_short()
        self.at += num_bytes
        return self.data[self.at - num_bytes:self.at]

    def numbers(self, count: int, name: str) -> numpy.ndarray:
        kind = name.lower()
        if kind not in LEGACY_TYPES and kind != "bit":
            raise InputError(f"'{shown(name)}' is no type of numbers that is read; save the values in another type")
        if self.is_binary:
            self.line_end()
            if kind == "bit":
                return numpy.unpackbits(numpy.frombuffer(self.take((count + 7) // 8), "u1"))[:count]
            number = numpy.dtype(">" + LEGACY_TYPES[kind])
            return numpy.frombuffer(self.take(count * number.itemsize), number)
        words = self.data[self.at:].split(None, count)
        if len(words) < count:
            raise _too_short()
        self.at = len(self.data) - (len(words[count]) if len(words) > count else 0)
        return numpy.array([float(word) for word in words[:count]])

    def strings(self, count: int) -> str:
        """The first of some texts. A binary file has the length before each, in one, two, four or eight bytes."""
        self.line_end()
        texts = []
        for _ in range(count):
            if self.at >= len(self.data):
                raise _too_short()
            if self.is_binary:
                size = 1 << (3 - (self.data[self.at] >> 6))
                texts.append(self.take(int.from_bytes(self.take(size), "big") & ((1 << (8 * size - 2)) - 1)))
            else:
                start = self.at
                self.line_end()
                texts.append(self.data[start:self.at])
        return texts[0].decode("ascii", "replace").strip() if texts else ""

    def cells(self) -> Cells:
        """A section, in either version of the format."""
        first, second = self.count(), self.count()
        if self.next_is("OFFSETS"):
            offsets = self.numbers(first, self.word())
            if self.word() != "CONNECTIVITY":
                raise InputError("CONNECTIVITY has to follow the OFFSETS")
            return checked_cells(self.numbers(second, self.word()), offsets[1:])
        values = self.numbers(second, "int").astype(int).tolist()
        corners: list[int] = []
        ends, at = [], 0
        for _ in range(first):
            if at >= second or values[at] < 0:
                raise InputError("the list of cells has not as many cells as it says")
            corners += values[at + 1:at + 1 + values[at]]
            ends.append(len(corners))
            at += 1 + values[at]
        if at != second:
            raise InputError("the list of cells is not as long as its cells are")
        return checked_cells(corners, ends)

    def skip_metadata(self) -> None:
        end = self.data.find(b"\n\n", self.at)
        self.at = len(self.data) if end < 0 else end

    def field(self, values: dict[str, numpy.ndarray], texts: dict[str, str]) -> None:
        self.word()
        for _ in range(self.count()):
            name = self.name()
            while name == "METADATA":
                self.skip_metadata()
                name = self.name()
            num_components, num_tuples, kind = self.count(), self.count(), self.word()
            if kind in ("string", "utf8_string"):
                texts[name] = self.strings(num_components * num_tuples)
                continue
            values[name] = _rows(self.numbers(num_components * num_tuples, kind), num_components)
            if kind in ("char", "unsigned_char"):
                texts[name] = bytes(values[name].astype("u1").ravel()).decode("ascii", "replace")

    def attribute(self, section: str, count: int, values: dict[str, numpy.ndarray]) -> None:
        """Values of points or cells."""
        name = self.name()
        if section == "SCALARS":
            kind, *given = self.rest_of_line()
            num_components = int(given[0]) if given else 1
            if self.next_is("LOOKUP_TABLE"):
                self.word()
        elif section in ("COLOR_SCALARS", "LOOKUP_TABLE"):
            kind = "unsigned_char" if self.is_binary else "float"
            num_components = self.count()
            if section == "LOOKUP_TABLE":
                self.numbers(4 * num_components, kind)
                return
        elif section == "TEXTURE_COORDINATES":
            num_components, kind = self.count(), self.word()
        elif section in COMPONENTS:
            num_components, kind = COMPONENTS[section], self.word()
        else:
            raise InputError(f"'{shown(section)}' begins no section that can be read")
        values[name] = _rows(self.numbers(count * num_components, kind), num_components)


def _read_legacy(data: bytes) -> Dataset:
    file, piece, kind = _Legacy(data), Piece(), ""
    texts: dict[str, str] = {}
    values: Optional[dict[str, numpy.ndarray]] = None  # of points or cells
    count = 0
    while word := file.word().upper():
        if word == "DATASET":
            kind = file.word().upper()
            if kind not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                raise InputError(f"it is a data set of the type {shown(kind)}, which has no tetrahedra; save an unstructured "
                                 "grid")
        elif word == "POINTS":
            num_points = file.count()
            piece.points = file.numbers(3 * num_points, file.word()).reshape(-1, 3)
        elif word in SECTIONS_OF_CELLS:
            piece.cells[word] = file.cells()
        elif word == "CELL_TYPES":
            piece.types = file.numbers(file.count(), "int").astype(int)
        elif word == "METADATA":
            file.skip_metadata()
        elif word in ("POINT_DATA", "CELL_DATA"):
            if kind == "POLYDATA":  # whose values nobody needs
                break
            count, values = file.count(), piece.point_data if word == "POINT_DATA" else piece.cell_data
        elif word == "FIELD":
            strings: dict[str, str] = {}
            file.field({} if values is None else values, strings)
            if values is None:
                texts.update(strings)
            piece.not_numbers += [name for name in strings if values is not None and name not in values]
        elif values is not None:
            file.attribute(word, count, values)
        else:
            raise InputError(f"'{shown(word)}' begins no section that can be read")
    return Dataset(kind, texts, [piece])


class _Xml:
    def __init__(self, data: bytes) -> None:
        start = re.search(rb"<AppendedData[^>]*>\s*_", data)
        self.appended = b""
        if start:
            end = data.rfind(b"</AppendedData>")
            self.appended = data[start.end():end if end > 0 else len(data)]
            self.is_raw = b'"raw"' in start.group(0)
            data = data[:start.end() - 1] + b"</AppendedData></VTKFile>"
        self.root = ElementTree.fromstring(data)
        self.order = "<" if self.root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
        self.header = numpy.dtype(self.order + XML_TYPES[self.root.get("header_type", "UInt32")])
        self.decompress = self._decompressor(self.root.get("compressor") or "")

    def _decompressor(self, name: str) -> Any:
        """A function of the bytes and of how many come out."""
        if name == "vtkLZ4DataCompressor":
            try:
                import lz4.block
            except ImportError:
                raise InputError("it is compressed by vtkLZ4DataCompressor; install python3-lz4, or save it without "
                                 "compression") from None
            return lambda data, size: lz4.block.decompress(data, uncompressed_size=size)
        known = {"": None, "vtkZLibDataCompressor": lambda data, size: zlib.decompress(data),
                 "vtkLZMADataCompressor": lambda data, size: lzma.decompress(data)}
        if name not in known:
            raise InputError(f"it is compressed by {shown(name)}; save it without compression")
        return known[name]

    def array(self, node: Any) -> numpy.ndarray:
        kind = numpy.dtype(self.order + XML_TYPES[node.get("type")])
        form = node.get("format", "ascii")
        if form == "ascii":
            return numpy.array((node.text or "").split(), dtype=float).astype(kind)
        if form == "appended":
            return numpy.frombuffer(self.blocks(self.appended[int(node.get("offset", "0")):], not self.is_raw), kind)
        return numpy.frombuffer(self.blocks(re.sub(rb"\s", b"", (node.text or "").encode()), True), kind)

    def blocks(self, source: bytes, is_base64: bool) -> bytes:
        """The bytes behind the header with their number, or with those of each compressed block."""
        size = self.header.itemsize

        def head(count: int) -> numpy.ndarray:
            start = base64.b64decode(source[:4 * ((count * size + 2) // 3)]) if is_base64 else source
            return numpy.frombuffer(start[:count * size], self.header).astype(int)

        def body(count: int, length: int) -> bytes:
            if is_base64 and self.decompress:  # the header is encoded by itself
                start = 4 * ((count * size + 2) // 3)
                data = base64.b64decode(source[start:start + 4 * ((length + 2) // 3)])[:length]
            elif is_base64:
                data = base64.b64decode(source[:4 * ((count * size + length + 2) // 3)])[count * size:][:length]
            else:
                data = source[count * size:count * size + length]
            if len(data) < length:
                raise _too_short()
            return data

        if not self.decompress:
            return body(1, int(head(1)[0]))
        num_blocks = int(head(1)[0])
        _, usual, last, *lengths = head(3 + num_blocks).tolist()
        data, at, whole = body(3 + num_blocks, sum(lengths)), 0, []
        for k, length in enumerate(lengths):
            size_of_block = last if last and k == num_blocks - 1 else usual
            whole.append(self.decompress(data[at:at + length], size_of_block))
            if len(whole[-1]) != size_of_block:
                raise _too_short()
            at += length
        return b"".join(whole)

    def values(self, parent: Any, not_numbers: list[str]) -> dict[str, numpy.ndarray]:
        found = {}
        for node in [] if parent is None else parent:
            if node.tag == "DataArray" and node.get("type") in XML_TYPES:
                found[node.get("Name", "")] = _rows(self.array(node), int(node.get("NumberOfComponents") or 1))
            else:
                not_numbers.append(node.get("Name", ""))
        return found


def _piece_of(file: _Xml, node: Any) -> Piece:
    piece = Piece()
    points = node.find("Points/DataArray")
    if points is not None:
        piece.points = file.array(points).reshape(-1, 3)
    if len(piece.points) != int(node.get("NumberOfPoints", "0")):
        raise InputError(f"a piece has {len(piece.points)} points and not the {node.get('NumberOfPoints', '0')} that it says")
    for name, section in (("Cells", "CELLS"), ("Polys", "POLYGONS"), ("Strips", "TRIANGLE_STRIPS")):
        wanted = ("connectivity", "offsets", "types")
        arrays = {array.get("Name"): file.array(array) for array in node.findall(name + "/DataArray")
                  if array.get("Name") in wanted}
        if "connectivity" in arrays and "offsets" in arrays:
            piece.cells[section] = checked_cells(arrays["connectivity"], arrays["offsets"])
            piece.types = arrays.get("types", piece.types).astype(int)
        if name == "Cells" and len(piece.types) != int(node.get("NumberOfCells", "0")):
            raise InputError(f"a piece has {len(piece.types)} cells and not the {node.get('NumberOfCells', '0')} that it says")
    return piece


def _read_xml(data: bytes) -> Dataset:
    file = _Xml(data)
    kind = file.root.get("type", "")
    if kind.startswith("P") and kind != "PolyData":
        raise InputError("it only names other files, in which the pieces are; open it in ParaView and save one file")
    if kind not in ("PolyData", "UnstructuredGrid"):
        raise InputError(f"it is a data set of the type {shown(kind)}, which has no tetrahedra; save an unstructured grid")
    texts = {array.get("Name", ""): bytes(file.array(array).astype("u1")).split(b"\0")[0].decode("ascii", "replace")
             for array in file.root.iterfind(kind + "/FieldData/") if array.get("Name") == "SPACE"}
    pieces = []
    for node in file.root.iterfind(kind + "/Piece"):
        piece = _piece_of(file, node)
        pieces.append(piece)
        if kind == "UnstructuredGrid":
            piece.point_data = file.values(node.find("PointData"), piece.not_numbers)
            piece.cell_data = file.values(node.find("CellData"), piece.not_numbers)
    return Dataset("POLYDATA" if kind == "PolyData" else "UNSTRUCTURED_GRID", texts, pieces)


def is_vtk(data: bytes) -> bool:
    return data.startswith(b"# vtk DataFile") or b"<VTKFile" in data[:2000]


def read_dataset(data: bytes) -> Dataset:
    """What a file has, whose bytes these are. Raises InputError, in which the file is not named."""
    try:
        return _read_legacy(data) if data.startswith(b"# vtk DataFile") else _read_xml(data)
    except (InputError, MemoryError):
        raise
    except Exception:  # in words for programmers
        raise InputError("it is damaged, or no VTK file") from None
