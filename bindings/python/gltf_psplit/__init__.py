"""Decodes Draco meshes and point clouds to numpy arrays, several times as fast as libdraco.

    mesh = gltf_psplit.decode("bunny.drc")
    mesh.faces, mesh.points, mesh["NORMAL"]

`decode` decodes one Draco stream, `decode_many` many, `load` a whole glTF asset, `decode_container` and `decode_primitive` single
primitives of one. `encode` writes Draco streams, `encode_container` containers of PSPLIT_mesh_draco_patches.
"""
from ._asset import Asset, AssetMesh, Instance, Primitive, load
from ._decode import decode, decode_container, decode_many, decode_primitive, release_scratch
from ._encode import Container, encode, encode_container
from ._errors import Error, InvalidInputError, OutOfMemoryError, UnsupportedError
from ._mesh import Attribute, Mesh, Metadata
from ._native import version as __version__

__all__ = [
    "Asset", "AssetMesh", "Attribute", "Container", "Error", "Instance", "InvalidInputError", "Mesh", "Metadata",
    "OutOfMemoryError", "Primitive", "UnsupportedError", "decode", "decode_container", "decode_many", "decode_primitive", "encode",
    "encode_container", "load", "release_scratch",
]
