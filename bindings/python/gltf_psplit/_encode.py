"""Encodes arrays as Draco streams and containers."""
from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _native
from ._errors import InvalidInputError, UnsupportedError
from ._gltf import TYPES
from ._input import attribute_name, flag, integer, mapping, number, numbers, rows, thread_count
from ._mesh import Attribute, Mesh

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._native import _Given, _Grid


class Container(NamedTuple):
    """A mesh in patches, with the JSON that is needed to decode it: `decode_container(*container)`.

    Attributes:
        data: the container's bytes, for the extension's buffer view.
        attributes: the extension's `attributes`: unique ids by name.
        accessors: the accessors of the attributes and of "indices", by name, without bounds.
    """

    data: bytes
    attributes: Dict[str, int]
    accessors: Dict[str, Dict[str, Any]]


def encode(points: Union[ArrayLike, Mesh], faces: Optional[ArrayLike] = None, quantization_bits: Optional[int] = None,
           compression_level: int = 1, quantization_range: float = -1,
           quantization_origin: Optional[Sequence[float]] = None, create_metadata: bool = False,
           preserve_order: bool = False, colors: Optional[ArrayLike] = None, tex_coord: Optional[ArrayLike] = None,
           normals: Optional[ArrayLike] = None, *, attributes: Optional[Mapping[str, Union[ArrayLike, Attribute]]] = None,
           normal_bits: int = 10, texcoord_bits: int = 12, bits: Optional[Mapping[str, int]] = None) -> bytes:
    """Encodes a mesh, or points without faces, as one ordinary Draco stream, which any Draco decoder reads.

    The parameters up to `normals` are DracoPy's.

    Args:
        points: (points, 3) floats. Integers of up to 24 bits are kept exactly, whatever `quantization_bits` is. Or a `Mesh`, with
            its faces and attributes. Encoding a decoded mesh again loses nothing: values keep the grid that they were decoded from,
            and exactly stored values stay exact, unless `quantization_bits` or `bits` says otherwise.
        faces: (faces, 3) point indices. Without faces, the stream is a point cloud with all points: a kD-tree, which reorders
            points, or sequential if floats are kept exactly or `compression_level` is 0.
        quantization_bits: bits of each coordinate, 1 to 30; 0 keeps floats exactly, as always if a coordinate is not finite. By
            default 14.
        compression_level: 0 (fastest) to 10 (smallest).
        quantization_range: the edge length of the cube in which points are quantized; -1 means the largest extent, or 1
            if that is 0.
        quantization_origin: the lower corner of the cube, three floats; by default the minima of the coordinates. No point may be
            outside of the cube.
        create_metadata: add the metadata that DracoPy adds: "quantization_bits" (int32) and, if a grid was chosen,
            "quantization_range" (double) and "quantization_origin" (three doubles). The stream states its grid in any case:
            `Attribute.origin`, `range` and `bits`.
        preserve_order: keep the order of points and faces. The stream becomes several times as large. A point cloud is then encoded
            with `compression_level` 0.
        colors: (points, 3) or (points, 4), the attribute COLOR_0.
        tex_coord: (points, 2) floats, the attribute TEXCOORD_0, quantized to `texcoord_bits`.
        normals: (points, 3) floats, the attribute NORMAL. Unit vectors are quantized to `normal_bits`. Others are kept
            exactly, as a generic attribute of the stream, because Draco's normals are unit vectors.
        attributes: further attributes by name: TANGENT, TEXCOORD_1, COLOR_1, JOINTS_0, WEIGHTS_0, or custom names. An array has a
            row of 1 to 16 numbers, or one number, for each point. Integers of 8 and 16 bits are kept as they are. Other integers,
            of up to 24 bits, get the smallest of these types that holds all values, or else float32. Floats become float32 and are
            quantized: texture coordinates to `texcoord_bits`, colours to 8 bits, others to 12. Custom attributes whose values are
            all whole numbers are kept exactly. Integers of COLOR_n, TEXCOORD_n, WEIGHTS_n, TANGENT and NORMAL are normalized; an
            `Attribute` states whether it is. Names without a Draco type are stored in the metadata of the stream, where `decode`
            and DracoPy's get_attribute_by_name find them. Sets are numbered from 0.
        normal_bits, texcoord_bits: 2 to 30, and 1 to 30. 0 keeps floats exactly; normals are then stored like normals that are not
            unit vectors.
        bits: bits of single attributes, by name, in place of the above; 0 keeps floats exactly.

    Returns:
        The stream. Without `preserve_order`, Draco drops points that no face uses and faces that repeat a point, and reorders the
        rest. A point cloud keeps all of its points.

    Raises:
        NotImplementedError: integers of more than 24 bits, or lines.
        InvalidInputError: indices out of range, points outside of the cube, no faces.
        UnsupportedError: this package was built without its encoder.
        ValueError: arrays of another shape, numbers out of range. TypeError: arguments of another type.

    Warns (`UserWarning`) if the given bits lose precision. The interpreter's lock is released, and Ctrl-C stops the work.
    Thread-safe.
    """
    mesh = _mesh_of(points, faces, colors, tex_coord, normals, attributes, bits, quantization_bits, quantization_range,
                    quantization_origin, takes_points=True)
    _expect_sets_from_zero([given[0] for given in mesh.attributes])
    no_faces = np.empty((0, 3), np.uint32)
    stream, position_bits, generic = _native.encode(
        no_faces if mesh.faces is None else mesh.faces, mesh.attributes, mesh.position_bits, _bits(normal_bits, "normal_bits"),
        _bits(texcoord_bits, "texcoord_bits"), _speed(compression_level), flag(preserve_order, "preserve_order"),
        mesh.faces is None)
    entries: Dict[str, bytes] = {}
    if flag(create_metadata, "create_metadata"):
        entries["quantization_bits"] = struct.pack("<i", position_bits)
        if mesh.grid is not None:
            _, origin, extent = mesh.grid
            entries.update(quantization_range=struct.pack("<d", extent), quantization_origin=struct.pack("<3d", *origin))
    return _with_metadata(stream, entries, generic) if entries or generic else stream


def encode_container(points: Union[ArrayLike, Mesh], faces: Optional[ArrayLike] = None, *, patches: int = 0,
                     quantization_bits: Optional[int] = None, compression_level: int = 5, quantization_range: float = -1,
                     quantization_origin: Optional[Sequence[float]] = None, colors: Optional[ArrayLike] = None,
                     tex_coord: Optional[ArrayLike] = None, normals: Optional[ArrayLike] = None,
                     attributes: Optional[Mapping[str, Union[ArrayLike, Attribute]]] = None, normal_bits: int = 10,
                     texcoord_bits: int = 12, bits: Optional[Mapping[str, int]] = None, threads: int = 0) -> Container:
    """Encodes a mesh in patches, for the extension PSPLIT_mesh_draco_patches.

    Args:
        patches: the number of patches, which can be decoded in parallel. 0: one below 20,000 faces, otherwise 2, 4, 8, 16 or a
            multiple of 16 patches of about 30,000 faces.
        threads: the maximum number of threads; 0: one for each processor. The bytes do not depend on it.
        Others: see `encode`. Point clouds have no patches (NotImplementedError). Attributes have 1, 2, 3, 4, 9 or 16 numbers, as glTF's accessors.

    Returns:
        A `Container`, with the bytes of `gltf-psplit encode --always-patches`. Equal points are merged, unused points and
        degenerate faces are dropped, and points are reordered.

    Raises:
        The exceptions of `encode`. The result is decoded and compared with the input before it is returned.
    """
    mesh = _mesh_of(points, faces, colors, tex_coord, normals, attributes, bits, quantization_bits, quantization_range,
                    quantization_origin)
    assert mesh.faces is not None
    for name, values, *_ in mesh.attributes:
        if values.shape[1] not in TYPES:
            raise ValueError(f"{name} has {values.shape[1]} numbers for each point, which no type of glTF has")
    data, requests, point_count, face_count = _native.encode_container(
        mesh.faces, mesh.attributes, mesh.position_bits, _bits(normal_bits, "normal_bits"),
        _bits(texcoord_bits, "texcoord_bits"), _speed(compression_level), integer(patches, "patches", 0, 2**32 - 1),
        thread_count(threads))
    accessors: Dict[str, Dict[str, Any]] = {
        name: {"componentType": kind, "type": TYPES[count], "normalized": normalized, "count": point_count}
        for name, _, kind, count, normalized in requests}
    accessors["indices"] = {"componentType": 5125, "type": "SCALAR", "count": 3 * face_count}
    return Container(data, {name: unique_id for name, unique_id, *_ in requests}, accessors)


# The caller's arrays


class _Mesh(NamedTuple):
    """The input of the C++ module. The positions are the first attribute."""

    faces: Optional[NDArray[Any]]  # None: a point cloud
    attributes: List[_Given]
    position_bits: int
    grid: Optional[_Grid]  # the grid that the caller chose for positions


def _mesh_of(points: Any, faces: Any, colors: Any, tex_coord: Any, normals: Any, attributes: Any, bits: Any, position_bits: Any,
             extent: Any, origin: Any, takes_points: bool = False) -> _Mesh:
    if not hasattr(_native, "encode"):
        raise UnsupportedError("this package was built without its encoder")
    given: Dict[str, Tuple[str, Any]] = {}  # by the name of the attribute: the argument's name, and its value

    def give(name: Any, what: str, value: Any) -> None:
        name = attribute_name(name, "attributes")
        if not 0 < len(name.encode()) < 128:
            raise ValueError(f"attributes has the name {name!r}, which is not 1 to 127 bytes long")
        if len(given) == 127:
            raise ValueError(f"{what} is one attribute too many: 127 are possible")
        if name in given:
            raise ValueError(f"{what} is {given[name][0]} once more: both are {name}")
        given[name] = what, value

    if isinstance(points, Mesh):
        if faces is not None:
            raise ValueError("faces is given, and points is a Mesh, which has faces")
        if getattr(points, "elements", points.faces).shape[1] == 2:
            raise NotImplementedError("points is a primitive of lines, which Draco does not have")
        faces = points.faces if len(points.faces) else None
        for name, attribute in points.attributes.items():
            give(name, f"the mesh's {name}", attribute)
        if "POSITION" not in given:
            raise ValueError("points is a Mesh without POSITION")
    else:
        give("POSITION", "points", points)
    if faces is None and not takes_points:
        raise NotImplementedError("faces is missing: point clouds have no patches; `encode` encodes them")
    for name, what, value in (("NORMAL", "normals", normals), ("TEXCOORD_0", "tex_coord", tex_coord), ("COLOR_0", "colors", colors)):
        if value is not None:
            give(name, what, value)
    for name, value in mapping({} if attributes is None else attributes, "attributes").items():
        give(name, f"attributes[{name!r}]", value)
    own_bits = {name: integer(value, f"bits[{name!r}]", 0, 30) for name, value in mapping({} if bits is None else bits, "bits").items()}
    for name in own_bits:
        if name not in given or name == "POSITION":
            raise ValueError(f"bits has {name!r}, " + ("whose bits are quantization_bits" if name in given else "which is no attribute"))

    what, position = given.pop("POSITION")
    if position_bits is not None:
        position_bits = integer(position_bits, "quantization_bits", 0, 30)
    point_values, grid, described = _positions_of(position, what, position_bits, number(extent, "quantization_range"), origin)
    others = [_given_of(name, *given[name], own_bits.get(name), len(point_values)) for name in _by_number(given)]
    return _Mesh(None if faces is None else _faces_of(faces), [described, *others], 14 if position_bits is None else position_bits, grid)


def _faces_of(faces: Any) -> NDArray[Any]:
    array = rows(faces, "faces", (3,))
    if len(array) > 0xFFFFFFFF // 3:
        raise ValueError("faces has more corners than 32-bit numbers can count")
    if array.size and array.dtype.kind not in "iu":
        raise ValueError(f"faces are {array.dtype}, not integers")
    if array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
        raise ValueError("faces contains invalid indices")
    return np.ascontiguousarray(array, dtype=np.uint32)


def _positions_of(given: Any, what: str, bits: Optional[int], extent: float,
                  origin: Optional[Sequence[float]]) -> Tuple[NDArray[Any], Optional[_Grid], _Given]:
    """The caller's array, the grid that the caller chose for it, and the encoder's input."""
    stated, normalized = None, False
    if isinstance(given, Attribute):
        given, normalized, stated = _values_of(given, what)
    points = rows(given, what, (3,))
    if len(points) > 0xFFFFFFFF:
        raise ValueError(f"{what} has more points than 32-bit numbers can name")
    if normalized and points.dtype.kind in "iu" and points.itemsize <= 2:  # of KHR_mesh_quantization
        return points, None, ("POSITION", np.ascontiguousarray(points), True, None, None, None)
    chosen, grid, exactly = None, None, None
    if points.dtype.kind in "iub":
        grid = _grid_of_integers(points, what)
        stated, exactly = None, 0 if grid is None else None
    elif extent != -1 or origin is not None:
        chosen = grid = _grid_of(points, 14 if bits is None else bits, extent, origin)
    if grid is not None or bits is not None:
        stated = None
    if stated is not None and stated[0] == 0:
        exactly = 0
    return points, chosen, ("POSITION", np.ascontiguousarray(points, dtype=np.float32), False, exactly, grid,
                            None if exactly == 0 else stated)


def _grid_of(points: NDArray[Any], bits: int, extent: float, origin: Optional[Sequence[float]]) -> Optional[_Grid]:
    """The grid that the caller chose: (bits, origin, range). None without bits."""
    if bits == 0:
        return None
    low = points.min(axis=0) if len(points) else np.zeros(3)
    corner = numbers(low if origin is None else origin, "quantization_origin").astype(np.float32)
    if corner.shape != (3,) or not np.isfinite(corner).all():
        raise ValueError("quantization_origin is not three finite numbers")
    if extent == -1:
        # The distance in the encoder's arithmetic, so that the farthest point is on the grid.
        extent = float((points.astype(np.float32) - corner).max()) if len(points) else 0.0
        if not 0 <= extent < np.inf:
            raise InvalidInputError("points are outside of the cube whose corner is quantization_origin")
        extent = extent or 1.0
    if not (np.isfinite(extent) and extent > 0):
        raise ValueError(f"quantization_range is {extent}, not a positive number")
    return bits, [float(x) for x in corner], float(np.float32(extent))


def _grid_of_integers(points: NDArray[Any], what: str) -> Optional[_Grid]:
    """A grid whose places are the integers, so that decoded values are exact. None if only unquantized floats are exact."""
    if points.size == 0:
        return None
    _expect_exact(points, what)
    low, high = points.min(axis=0), points.max(axis=0)
    bits = max(1, int(max(int(h) - int(l) for l, h in zip(low, high))).bit_length())
    if max(abs(int(low.min())), abs(int(high.max()))) + 2**bits > 2**24:
        return None
    return bits, [float(x) for x in low], float(2**bits - 1)


def _expect_exact(integers: NDArray[Any], what: str) -> None:
    low, high = (int(integers.min()), int(integers.max())) if integers.size else (0, 0)
    if max(-low, high) >= 2**24:
        raise NotImplementedError(f"{what} has integers from {low} to {high}: more than 24 bits, which are not exact as floats")


_NORMALIZED = re.compile(r"(COLOR|TEXCOORD|WEIGHTS)_\d+$|TANGENT$|NORMAL$")
# For parameters of `encode`: the allowed numbers of columns, and whether integers become floats.
_SHAPES: Dict[str, Tuple[Tuple[int, ...], bool]] = {"normals": ((3,), True), "tex_coord": ((2,), True), "colors": ((3, 4), False)}


def _given_of(name: str, what: str, given: Any, bits: Optional[int], point_count: int) -> _Given:
    normalized, stated = None, None
    if isinstance(given, Attribute):
        given, normalized, stated = _values_of(given, what)
    if what in _SHAPES:
        columns, are_floats = _SHAPES[what]
        values = rows(given, what, columns)
        values = values.astype(np.float32) if are_floats else values
    else:
        values = numbers(given, what)
        values = values.reshape(-1, 1) if values.ndim == 1 else values
        if values.ndim != 2 or not 1 <= values.shape[1] <= 16:
            raise ValueError(f"{what} has the shape {values.shape}, not ({point_count}, 1 to 16)")
    if len(values) != point_count:
        raise ValueError(f"{what} has {len(values)} rows, and there are {point_count} points")
    if name.startswith("COLOR_") and values.dtype.kind in "iub" and values.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"{what} are {values.dtype}, not uint8, uint16 or floats, so that it is not known what is white")
    values = _storable(values, what)
    if bits is None and stated is not None and stated[0] == 0:
        bits = 0
    if values.dtype.kind != "f":
        if bits:
            raise ValueError(f"bits[{name!r}] is {bits}, but {what} has integers, which are kept exactly")
        stated = None
    elif name == "NORMAL" and bits == 1:
        raise ValueError("bits['NORMAL'] is 1, not 0 or 2 to 30")
    if normalized is None:
        normalized = values.dtype.kind != "f" and _NORMALIZED.match(name) is not None
    return name, np.ascontiguousarray(values), normalized, bits, None, None if bits is not None else stated


def _values_of(attribute: Attribute, what: str) -> Tuple[NDArray[Any], bool, Optional[_Grid]]:
    """The values, whether they are normalized, and the grid that they may be on; with 0 bits if they are stored exactly."""
    if attribute.are_integers:
        raise ValueError(f"{what} has places on a grid: decode without quantized=True")
    if attribute.bits is None:
        return attribute.values, attribute.normalized, None
    origin = [] if attribute.origin is None else attribute.origin.tolist()
    return attribute.values, attribute.normalized, (attribute.bits, origin, attribute.range or 0.0)


def _storable(values: NDArray[Any], what: str) -> NDArray[Any]:
    """Converts values to a type that glTF allows for vertex attributes."""
    if values.dtype.kind == "f":
        return values.astype(np.float32)
    types = [np.dtype(kind) for kind in ("u1", "i1", "u2", "i2")]
    for kind in types:
        if values.dtype == kind:
            return values.astype(kind)  # in native byte order
    low, high = (int(values.min()), int(values.max())) if values.size else (0, 0)
    for kind in types:
        if np.iinfo(kind).min <= low and high <= np.iinfo(kind).max:
            return values.astype(kind)
    _expect_exact(values, what)
    return values.astype(np.float32)


_SET = re.compile(r"(TEXCOORD|COLOR)_(\d+)$")


def _by_number(names: Mapping[str, Any]) -> List[str]:
    """The names in the given order, but with the sets of each kind in ascending order: Draco does not number them."""
    sets: Dict[str, List[str]] = {}
    for name in names:
        found = _SET.match(name)
        if found:
            sets.setdefault(found[1], []).append(name)
    for listed in sets.values():
        listed.sort(key=lambda name: int(name.rpartition("_")[2]), reverse=True)
    return [sets[found[1]].pop() if (found := _SET.match(name)) else name for name in names]


def _expect_sets_from_zero(names: Sequence[str]) -> None:
    seen: Dict[str, int] = {}
    for found in filter(None, map(_SET.match, names)):
        expected = seen.get(found[1], 0)
        if found[2] != str(expected):
            raise ValueError(f"there is {found[0]}, and no {found[1]}_{expected}")
        seen[found[1]] = expected + 1


def _bits(bits: Any, what: str) -> int:
    least = 2 if what == "normal_bits" else 1
    given = integer(bits, what, 0, 30)
    if 0 < given < least:
        raise ValueError(f"{what} is {given}, not 0 or {least} to 30")
    return given


def _speed(compression_level: Any) -> int:
    return 10 - integer(compression_level, "compression_level", 0, 10)


def _with_metadata(stream: bytes, entries: Mapping[str, bytes], names: Mapping[int, str]) -> bytes:
    """Inserts metadata after the stream's header (Draco bitstream specification, "metadata"): entries of the geometry, and names of
    attributes by their unique ids. All counts, lengths and ids are below 128, so that each is one byte."""
    header = struct.Struct("<5s4BH")  # "DRACO", two of the version, kind, method, flags
    *front, flags = header.unpack_from(stream)

    def element(of: Mapping[str, bytes]) -> bytes:
        no_parts = b"\0"
        return bytes([len(of)]) + b"".join(
            bytes([len(name)]) + name.encode() + bytes([len(value)]) + value for name, value in of.items()) + no_parts

    listed = b"".join(bytes([unique_id]) + element({"name": name.encode()})
                      for unique_id, name in names.items())
    return header.pack(*front, flags | 0x8000) + bytes([len(names)]) + listed + element(entries) + stream[header.size:]
