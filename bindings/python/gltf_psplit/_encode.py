"""Arrays to Draco streams and containers."""
from __future__ import annotations

import struct
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from . import _native
from ._errors import UnsupportedError
from ._gltf import COMPONENTS


class Container(NamedTuple):
    """A mesh in patches, with the JSON that decodes it: `decode_container(*container)`.

    Attributes:
        data: the container, for the extension's buffer view.
        attributes: the extension's `attributes`: unique ids by name.
        accessors: the accessors of the attributes and of "indices", by name, without bounds.
    """

    data: bytes
    attributes: Dict[str, int]
    accessors: Dict[str, Dict[str, Any]]


def encode(points: Any, faces: Any = None, quantization_bits: int = 14, compression_level: int = 1,
           quantization_range: float = -1, quantization_origin: Optional[Sequence[float]] = None,
           create_metadata: bool = False, preserve_order: bool = False, colors: Any = None, tex_coord: Any = None,
           normals: Any = None, *, normal_bits: int = 10, texcoord_bits: int = 12) -> bytes:
    """Encodes a mesh as one ordinary Draco stream, which any Draco decoder reads.

    The parameters are those of DracoPy.

    Args:
        points: (points, 3) floats. Integers of less than 24 bits are kept exactly; `quantization_bits` is not used
            for them.
        faces: (faces, 3) numbers of points.
        quantization_bits: of a coordinate, 1 to 30; 0 keeps floats exactly. So are points that are not all finite.
        compression_level: 0 (fastest) to 10 (smallest).
        quantization_range: the edge of the cube in which points are quantized; -1 takes the largest extent.
        quantization_origin: the corner of the cube, three floats; by default the least coordinates. No point may be
            outside of the cube.
        create_metadata: add the metadata that DracoPy adds: "quantization_bits" (int32) and, if a grid was chosen,
            "quantization_range" (double) and "quantization_origin" (three doubles). The stream has its grid in any case:
            `Attribute.origin`, `range` and `bits`.
        preserve_order: keep the order of points and faces. The stream is several times as large.
        colors: (points, 3) or (points, 4) of uint8 or uint16, kept exactly.
        tex_coord: (points, 2) floats, quantized to `texcoord_bits`.
        normals: (points, 3) floats. Unit vectors are quantized to `normal_bits`. Others are kept exactly, as the
            generic attribute "_GENERIC_0" of the stream, because Draco's normals are unit vectors.
        normal_bits, texcoord_bits: 2 to 30, and 1 to 30. 0 keeps floats exactly; normals then are as others above.

    Returns:
        The stream. Without `preserve_order`, Draco drops points that no face uses and faces that repeat a point, and
        has an order of its own.

    Raises:
        NotImplementedError: point clouds (faces=None), integer points of 24 bits or more.
        InvalidInputError: indices out of range, points outside of the cube, no faces.
        UnsupportedError: this package was built without its encoder.
        ValueError: arrays of another shape, numbers out of range.

    Warns (`UserWarning`) of what the given bits lose. The interpreter's lock is released, and Ctrl-C stops the work.
    Thread-safe.
    """
    mesh = _arrays_of(points, faces, colors, tex_coord, normals)
    grid = _grid_of(points, quantization_bits, quantization_range, quantization_origin)
    stream, bits = _native.encode(*mesh, *_bits(grid, normal_bits, texcoord_bits), *grid[1:], _speed(compression_level),
                                  bool(preserve_order))
    if not create_metadata:
        return stream
    _, origin, extent = grid
    entries = {"quantization_bits": struct.pack("<i", bits)}
    if origin:
        entries.update(quantization_range=struct.pack("<d", extent), quantization_origin=struct.pack("<3d", *origin))
    return _with_metadata(stream, entries)


def encode_container(points: Any, faces: Any, *, patches: int = 0, quantization_bits: int = 14, compression_level: int = 5,
                     quantization_range: float = -1, quantization_origin: Optional[Sequence[float]] = None,
                     colors: Any = None, tex_coord: Any = None, normals: Any = None, normal_bits: int = 10,
                     texcoord_bits: int = 12, threads: int = 0) -> Container:
    """Encodes a mesh in patches, for the extension PSPLIT_mesh_draco_patches.

    Args:
        patches: the number of patches, which decode at once. 0: 2, 4, 8, 16 or a multiple of 16 patches of about 30,000
            faces, from 20,000 faces on, and otherwise one.
        threads: at most so many threads; 0: all of the machine. The bytes do not depend on it.
        Others: see `encode`.

    Returns:
        A `Container`, with the bytes of `gltf-psplit encode --always-patches`. Equal points were merged, what draws
        nothing was dropped, and points have another order.

    Raises:
        What `encode` raises. The result is decoded and compared with the input before it is returned.
    """
    mesh = _arrays_of(points, faces, colors, tex_coord, normals)
    if patches < 0:
        raise ValueError("patches is negative")
    grid = _grid_of(points, quantization_bits, quantization_range, quantization_origin)
    data, requests, point_count, face_count = _native.encode_container(
        *mesh, *_bits(grid, normal_bits, texcoord_bits), *grid[1:], _speed(compression_level), patches, threads)
    names = {count: name for name, count in COMPONENTS.items() if not name.startswith("MAT")}
    accessors: Dict[str, Dict[str, Any]] = {
        name: {"componentType": kind, "type": names[count], "normalized": normalized, "count": point_count}
        for name, _, kind, count, normalized in requests}
    accessors["indices"] = {"componentType": 5125, "type": "SCALAR", "count": 3 * face_count}
    return Container(data, {name: unique_id for name, unique_id, *_ in requests}, accessors)


def _with_metadata(stream: bytes, entries: Dict[str, bytes]) -> bytes:
    """The stream with metadata of the geometry behind its header (Draco bitstream specification, "metadata"). Names and
    values are shorter than 128 bytes, so that each length is one byte."""
    header = struct.Struct("<5s4BH")  # "DRACO", two of the version, kind, method, flags
    *front, flags = header.unpack_from(stream)
    no_attributes, no_parts = b"\0", b"\0"
    listed = b"".join(bytes([len(name)]) + name.encode() + bytes([len(value)]) + value for name, value in entries.items())
    return (header.pack(*front, flags | 0x8000) + no_attributes + bytes([len(entries)]) + listed + no_parts
            + stream[header.size:])


def _arrays_of(points: Any, faces: Any, colors: Any, tex_coord: Any,
               normals: Any) -> Tuple[np.ndarray, List[Tuple[str, np.ndarray, bool]]]:
    if not hasattr(_native, "encode"):
        raise UnsupportedError("this package was built without its encoder")
    if faces is None:
        raise NotImplementedError("psplit encodes meshes; it decodes point clouds, but does not encode them")
    faces = _array(faces, "faces", (3,))
    if faces.size and not np.issubdtype(faces.dtype, np.integer):
        raise ValueError(f"faces are {faces.dtype}, not integers")
    if faces.size and (faces.min() < 0 or faces.max() > 0xFFFFFFFF):
        raise ValueError("faces has numbers that are no points")
    points = _array(points, "points", (3,))
    given = [("POSITION", points.astype(np.float32), False)]
    if normals is not None:
        given.append(("NORMAL", _array(normals, "normals", (3,)).astype(np.float32), False))
    if tex_coord is not None:
        given.append(("TEXCOORD_0", _array(tex_coord, "tex_coord", (2,)).astype(np.float32), False))
    if colors is not None:
        colors = _array(colors, "colors", (3, 4))
        if colors.dtype not in (np.uint8, np.uint16):
            raise ValueError(f"colors are {colors.dtype}, not uint8 or uint16")
        given.append(("COLOR_0", colors, True))
    for name, values, _ in given:
        if len(values) != len(points):
            raise ValueError(f"{name} has {len(values)} rows, and there are {len(points)} points")
    if len(points) > 0xFFFFFFFF:
        raise ValueError("more points than 32-bit numbers can name")
    return (np.ascontiguousarray(faces, dtype=np.uint32),
            [(name, np.ascontiguousarray(values), normalized) for name, values, normalized in given])


def _array(values: Any, name: str, columns: Tuple[int, ...]) -> np.ndarray:
    array = np.asarray(values)
    if array.ndim == 1 and array.size % columns[0] == 0:  # DracoPy takes flat lists, too
        array = array.reshape(-1, columns[0])
    if array.ndim != 2 or array.shape[1] not in columns:
        wanted = " or ".join(f"(n, {count})" for count in columns)
        raise ValueError(f"{name} has the shape {array.shape}, not {wanted}")
    return array


def _grid_of(points: Any, bits: int, extent: float, origin: Optional[Sequence[float]]) -> Tuple[int, List[float], float]:
    """(bits, origin, range); the encoder fits a grid to the points if the origin is empty."""
    if not 0 <= bits <= 30:
        raise ValueError(f"quantization_bits is {bits}, not 0 to 30")
    points = _array(points, "points", (3,))
    if np.issubdtype(points.dtype, np.integer):
        return _grid_of_integers(points)
    if bits == 0 or (extent == -1 and origin is None):
        return bits, [], 0.0
    low = points.min(axis=0) if len(points) else np.zeros(3)
    corner = np.asarray(low if origin is None else origin, dtype=np.float32)
    if corner.shape != (3,) or not np.isfinite(corner).all():
        raise ValueError("quantization_origin is not three finite numbers")
    if extent == -1:
        # The distance in the encoder's arithmetic, so that the farthest point is on the grid.
        extent = float((points.astype(np.float32) - corner).max()) if len(points) else 0.0
    if not (np.isfinite(extent) and extent > 0):
        raise ValueError(f"quantization_range is {extent}, not a positive number")
    return bits, [float(x) for x in corner], float(np.float32(extent))


def _grid_of_integers(points: np.ndarray) -> Tuple[int, List[float], float]:
    """A grid whose places are the integers, so that decoded values are exact."""
    if points.size == 0:
        return 0, [], 0.0
    low, high = points.min(axis=0), points.max(axis=0)
    bits = max(1, int(max(int(h) - int(l) for l, h in zip(low, high))).bit_length())
    if max(abs(int(low.min())), abs(int(high.max()))) + 2**bits > 2**24:
        raise NotImplementedError("integer points of 24 bits or more are not exact as floats")
    return bits, [float(x) for x in low], float(2**bits - 1)


def _bits(grid: Tuple[int, List[float], float], normal_bits: int, texcoord_bits: int) -> Tuple[int, int, int]:
    if not (normal_bits == 0 or 2 <= normal_bits <= 30) or not 0 <= texcoord_bits <= 30:
        raise ValueError("normal_bits is 0 or 2 to 30, texcoord_bits 0 to 30")
    return grid[0], normal_bits, texcoord_bits


def _speed(compression_level: int) -> int:
    if not 0 <= compression_level <= 10:
        raise ValueError(f"compression_level is {compression_level}, not 0 to 10")
    return 10 - compression_level
