"""Lets trimesh load glTF assets in PSPLIT_mesh_draco_patches and KHR_draco_mesh_compression.

    import gltf_psplit.trimesh_handler
    gltf_psplit.trimesh_handler.register()
    scene = trimesh.load("dragon.glb")

It needs a trimesh that has handlers of the scope "primitive_preprocess" (`trimesh.exchange.gltf.extensions`). trimesh
reports an error of a handler as a warning of its logger, and the primitive has zeros.
"""
from __future__ import annotations

from typing import Any, Dict

from . import _decode
from ._gltf import PATCHES, STOCK

_COMPONENT_TYPES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def register() -> None:
    """Registers the handlers of both extensions, in place of trimesh's own.

    ImportError: trimesh is missing, or has no handlers of extensions.
    """
    from trimesh.exchange.gltf.extensions import register_handler  # type: ignore[import]

    register_handler(PATCHES, scope="primitive_preprocess")(decode_patches)
    register_handler(STOCK, scope="primitive_preprocess")(decode_stock)


def decode_patches(context: Dict[str, Any]) -> Dict[str, Any]:
    """The handler of PSPLIT_mesh_draco_patches."""
    return _decode_primitive(context, PATCHES)


def decode_stock(context: Dict[str, Any]) -> Dict[str, Any]:
    """The handler of KHR_draco_mesh_compression."""
    return _decode_primitive(context, STOCK)


def _decode_primitive(context: Dict[str, Any], extension: str) -> Dict[str, Any]:
    data, primitive, arrays = context["data"], context["primitive"], context["accessors"]
    names = primitive["attributes"]
    # For an accessor without data, trimesh has an array of zeros in the accessor's type.
    accessors = {name: _accessor_of(arrays[names[name]]) for name in data["attributes"]}
    if "indices" in primitive:
        accessors["indices"] = _accessor_of(arrays[primitive["indices"]])
    mesh = _decode.decode_container(context["views"][data["bufferView"]], data["attributes"], accessors, extension=extension)
    # Uses new indices, because other primitives may share the accessors but decode to other points.
    for name in mesh:
        arrays.append(mesh[name])
        names[name] = len(arrays) - 1
    arrays.append(mesh.faces.reshape(-1))
    primitive["indices"] = len(arrays) - 1
    return {"decompressed": True}


def _accessor_of(array: Any) -> Dict[str, Any]:
    columns = array.shape[1] if array.ndim > 1 else 1
    return {"componentType": _COMPONENT_TYPES[array.dtype.str[1:]], "type": _TYPES[columns], "count": len(array)}
