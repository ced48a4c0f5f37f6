"""Decodes Draco streams and containers to meshes."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Iterable, List, Mapping, NamedTuple, Optional, Union, overload

from . import _native
from ._asset import load
from ._errors import Error, InvalidInputError
from ._gltf import COMPONENT_TYPES, COMPONENTS, PATCHES, STOCK
from ._input import (
    Source, attribute_name, bytes_of, flag, integer, is_container, is_draco, is_gltf, mapping, optional_dict, thread_count)
from ._mesh import Mesh

if TYPE_CHECKING:
    from typing_extensions import Literal

    from _typeshed import ReadableBuffer
    from numpy.typing import NDArray

    from ._native import _Request


def decode(data: Source, *, quantized: bool = False, threads: int = 0,
           out: Optional[Mapping[Union[str, int], NDArray[Any]]] = None) -> Mesh:
    """Decodes one mesh or point cloud.

    Args:
        data: a Draco stream (the content of a .drc file) of a mesh or a point cloud, or a glTF asset (.glb, .gltf) with
            one primitive. As bytes, bytearray, memoryview, mmap, a contiguous array, or as the path of a file
            (str, os.PathLike). Bytes must not change during the call.
        quantized: return the integers of the stream instead of values: for quantized attributes, places on the grid
            (`Attribute.origin`, `range`, `bits`), int32 of (points, components); for normals, coordinates on the octahedron, int32
            of (points, 2). Only for Draco streams.
        threads: the maximum number of threads; 0: one for each processor. One Draco stream takes one thread, the patches of an
            asset take several. `decode_many` decodes many streams at once.
        out: arrays to fill, by the name or the unique id of an attribute, and "faces". They must have the exact shape
            and dtype of the result. Rows of attributes may lie apart, as in an interleaved vertex buffer; the bytes between them
            are not touched. Faces must be contiguous. No two rows or arrays may share memory. Attributes that are not in `out` get
            new arrays. Only for Draco streams. After an error the contents of the arrays are unspecified.

    Returns:
        A `Mesh`, with faces (faces, 3) uint32 and arrays of (points, components) in the stream's types. They equal libdraco's
        results to the bit, in the same order. Nothing is copied.

    Raises:
        InvalidInputError: the data are malformed.
        UnsupportedError: a Draco bitstream before 2.2 without libdraco, or another one that psplit does not support.
        Error: arrays in `out` that do not fit (code "usage"); a container, which `decode_container` decodes; an asset that does
            not have exactly one primitive, which `load` reads.
        TypeError: `data` is neither bytes-like nor a path, or another argument has the wrong type.
        OSError: the file cannot be read.

    The interpreter's lock is released. Thread-safe.
    """
    content = bytes_of(data, "data")
    quantized, threads, arrays = flag(quantized, "quantized"), thread_count(threads), optional_dict(out, "out")
    if is_draco(content):
        return Mesh(*_native.decode(content, quantized, arrays))
    if is_container(content):
        raise Error("this is a container of PSPLIT_mesh_draco_patches, whose attributes are in the JSON of its asset: "
                    "gltf_psplit.load decodes an asset, gltf_psplit.decode_container a container with that JSON", code="usage")
    if not is_gltf(content):
        raise InvalidInputError("neither a Draco stream nor glTF")
    if quantized or out is not None:
        raise Error("quantized and out are for Draco streams, and this is glTF", code="usage")
    primitives = [primitive for mesh in load(data, threads=threads).meshes for primitive in mesh.primitives]
    if len(primitives) != 1:
        raise Error(f"the asset has {len(primitives)} primitives; gltf_psplit.load gives all of them", code="usage")
    return primitives[0]


@overload
def decode_many(data: Iterable[Source], *, quantized: bool = False, threads: int = 0,
                return_exceptions: Literal[False] = False) -> List[Mesh]: ...


@overload
def decode_many(data: Iterable[Source], *, quantized: bool = False, threads: int = 0,
                return_exceptions: Literal[True]) -> List[Union[Mesh, Exception]]: ...


def decode_many(data: Iterable[Source], *, quantized: bool = False, threads: int = 0,
                return_exceptions: bool = False) -> List[Any]:
    """Decodes many meshes at once, on all threads.

    Args:
        data: any number of items that `decode` accepts. Files given by path are read one after the other.
        quantized: see `decode`.
        threads: the maximum number of threads; 0: one for each processor.
        return_exceptions: put the exception of an item in the item's place, as asyncio.gather does. Otherwise the first one is
            raised once all items are decoded.

    Returns:
        A list with a `Mesh` for each item, in order.

    Raises:
        The exceptions of `decode`.
    """
    quantized, threads, returns = flag(quantized, "quantized"), thread_count(threads), flag(return_exceptions, "return_exceptions")
    if isinstance(data, (str, bytes)) or not isinstance(data, Iterable):
        raise TypeError(f"data is a {type(data).__name__}, not a list of what gltf_psplit.decode takes")
    results: List[Any] = []
    streams, places = [], []
    for item in data:
        results.append(None)
        try:
            content = bytes_of(item, f"data[{len(results) - 1}]")
            if is_draco(content):
                streams.append(content)
                places.append(len(results) - 1)
            else:
                results[-1] = decode(item if content is not item else content, quantized=quantized, threads=threads)
        except (Error, OSError, TypeError) as error:
            results[-1] = error
    for place, result in zip(places, _native.decode_many(streams, quantized, threads)):
        results[place] = result if isinstance(result, BaseException) else Mesh(*result)
    if not returns:
        for result in results:
            if isinstance(result, BaseException):
                raise result
    return results


def decode_container(data: Source, attributes: Mapping[str, int], accessors: Mapping[str, Mapping[str, Any]], *,
                     extension: str = PATCHES, threads: int = 0,
                     out: Optional[Mapping[Union[str, int], NDArray[Any]]] = None) -> Mesh:
    """Decodes the bytes of a compressed primitive whose JSON the caller has.

    Args:
        data: the bytes of the extension's buffer view, or the path of a file with these bytes.
        attributes: the extension's `attributes`: unique ids by name. Unwanted attributes may be left out.
        accessors: the accessors of the primitive by attribute name, in glTF's form: `componentType`, `type`, and optionally
            `normalized` and `count`; also the accessor of "indices", whose count is checked.
        extension: "PSPLIT_mesh_draco_patches", or "KHR_draco_mesh_compression" for a Draco stream.
        threads: the maximum number of threads; 0: one for each processor.
        out: see `decode`.

    Returns:
        A `Mesh`, whose arrays have the types of the accessors.

    Raises:
        The exceptions of `decode`. `Error.patch` is the index of the patch with the error. ValueError: an id or a count out of
        range.
    """
    if extension not in (PATCHES, STOCK):
        raise Error(f"{extension!r} is none of {PATCHES} and {STOCK}", code="usage")
    described = _described(mapping(attributes, "attributes"), mapping(accessors, "accessors"))
    return _decoded(data, described, extension, threads, out)


class _Described(NamedTuple):
    """The description of a primitive in its JSON."""

    requests: List[_Request]
    point_count: int
    index_count: int


def _described(attributes: Mapping[str, int], accessors: Mapping[str, Mapping[str, Any]]) -> _Described:
    requests = [_request_of(name, unique_id, accessors) for name, unique_id in attributes.items()]
    point_count = max((_count_of(accessors, name) for name in attributes), default=0)
    return _Described(requests, point_count, _count_of(accessors, "indices") if "indices" in accessors else 0)


def _decoded(data: Source, described: _Described, extension: str, threads: int,
             out: Optional[Mapping[Union[str, int], NDArray[Any]]] = None) -> Mesh:
    return Mesh(*_native.decode_primitive(bytes_of(data, "data"), described.requests, extension == STOCK, described.point_count,
                                          described.index_count, thread_count(threads), optional_dict(out, "out")))


def _request_of(name: Any, unique_id: Any, accessors: Mapping[str, Mapping[str, Any]]) -> _Request:
    name = attribute_name(name, "attributes")
    accessor = _accessor_of(accessors, name)
    unique_id = integer(unique_id, f"attributes[{name!r}]", 0, 0xFFFFFFFF)
    component_type, kind = accessor.get("componentType"), accessor.get("type")
    if component_type is not None:
        component_type = integer(component_type, f"accessors[{name!r}]['componentType']", 0, 0xFFFFFFFF)
    if kind is not None and not isinstance(kind, str):
        raise TypeError(f"accessors[{name!r}]['type'] is a {type(kind).__name__}, not a string")
    if component_type is None or component_type not in COMPONENT_TYPES or kind is None or kind not in COMPONENTS:
        raise Error(f"the accessor of {name} has the componentType {component_type!r} and the type {kind!r}", code="usage")
    return name, unique_id, component_type, COMPONENTS[kind], bool(accessor.get("normalized", False))


def _accessor_of(accessors: Mapping[str, Mapping[str, Any]], name: str) -> Mapping[str, Any]:
    if name not in accessors:
        raise Error(f"no accessor for {name}", code="usage")
    return mapping(accessors[name], f"accessors[{name!r}]")


def _count_of(accessors: Mapping[str, Mapping[str, Any]], name: str) -> int:
    """The count of an accessor; 0 if it has none."""
    return integer(_accessor_of(accessors, name).get("count", 0), f"accessors[{name!r}]['count']", 0, 0xFFFFFFFF)


def decode_primitive(gltf: Mapping[str, Any], primitive: Mapping[str, Any], buffer_view: Callable[[int], ReadableBuffer], *,
                     threads: int = 0) -> Optional[Mesh]:
    """Decodes a primitive for a program that has the JSON of its asset and reads the buffers itself.

    It needs no libdraco. `load` is simpler where it is available.

    Args:
        gltf: the JSON of the asset.
        primitive: one of `gltf["meshes"][i]["primitives"]`; if the mesh has the extension PSPLIT_mesh_draco_patches, one of the
            extension's primitives.
        buffer_view: returns the bytes of a buffer view, given its index.
        threads: the maximum number of threads; 0: one for each processor.

    Returns:
        A `Mesh` with the attributes that the extension stores, and morph targets by names like "targets/0/POSITION", or None
        if the primitive is not compressed.

    Raises:
        What `decode_container` raises; InvalidInputError if the JSON lacks something.
    """
    gltf, primitive, threads = mapping(gltf, "gltf"), mapping(primitive, "primitive"), thread_count(threads)
    if not callable(buffer_view):
        raise TypeError(f"buffer_view is a {type(buffer_view).__name__}, not a function")
    try:
        extensions = primitive.get("extensions", {})
        extension = next((name for name in (PATCHES, STOCK) if name in extensions), None)
        if extension is None:
            return None
        stored = extensions[extension]
        attributes, view = dict(stored["attributes"]), stored["bufferView"]
        indices = {name: primitive["attributes"][name] for name in attributes}
        for semantic, ids in stored.get("targets", {}).items() if extension == PATCHES else ():
            targets = primitive.get("targets", [])
            if len(ids) != len(targets):
                raise InvalidInputError(f"the extension has {len(ids)} ids of {semantic} for {len(targets)} morph targets")
            for number, unique_id in enumerate(ids):
                if unique_id != -1:
                    attributes[f"targets/{number}/{semantic}"] = unique_id
                    indices[f"targets/{number}/{semantic}"] = targets[number][semantic]
        if "indices" in primitive:
            indices["indices"] = primitive["indices"]
        described = _described(attributes, {name: gltf["accessors"][index] for name, index in indices.items()})
    except Error:
        raise
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise InvalidInputError(f"the JSON of the primitive is not as glTF has it: {error!r}") from error
    data = bytes_of(buffer_view(view), f"what buffer_view({view!r}) returned")
    return _decoded(data, described, extension, threads)


def release_scratch() -> None:
    """Frees the memory that threads keep from one call to the next. Thread-safe."""
    _native.release_scratch()
