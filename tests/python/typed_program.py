"""What type checkers say of programs (test_types.py): each line with the comment `wrong` is an error, and no other line is.
No test imports it."""
import mmap
import pathlib
from typing import List, Optional, Union

import gltf_psplit
import numpy as np
from numpy.typing import NDArray


def bytes_and_paths(path: pathlib.Path, mapped: mmap.mmap, array: NDArray[np.uint8]) -> None:
    for data in (b"", bytearray(), memoryview(b"")):
        gltf_psplit.decode(data)
    gltf_psplit.decode(path)
    gltf_psplit.decode("bunny.drc")
    gltf_psplit.decode(mapped)
    gltf_psplit.decode(array)
    gltf_psplit.decode(3)  # wrong
    gltf_psplit.decode(None)  # wrong
    gltf_psplit.decode([1, 2])  # wrong
    gltf_psplit.load(3.5)  # wrong
    gltf_psplit.decode(b"", quantised=True)  # wrong
    gltf_psplit.decode(b"", threads="all")  # wrong
    gltf_psplit.decode(b"", out={"POSITION": [1, 2]})  # wrong
    gltf_psplit.decode(b"", out={"POSITION": array, 3: array})
    gltf_psplit.decode_many(path)  # wrong
    gltf_psplit.decode_many([b"", path])


def meshes(mesh: gltf_psplit.Mesh) -> None:
    faces: NDArray[np.uint32] = mesh.faces
    floats: NDArray[np.float32] = mesh.faces  # wrong
    origin: Optional[NDArray[np.float32]] = mesh.attributes["POSITION"].origin
    normals: NDArray[np.float32] = mesh.normals  # wrong
    there: NDArray[np.float32] = mesh.get("NORMAL", np.zeros(3, np.float32))
    mesh.points.shape[0] + mesh.point_count
    mesh.triangles  # wrong
    print(faces, floats, origin, normals, there)


def many(data: List[bytes]) -> None:
    gltf_psplit.decode_many(data)[0].faces
    both: List[Union[gltf_psplit.Mesh, Exception]] = gltf_psplit.decode_many(data, return_exceptions=True)
    gltf_psplit.decode_many(data, return_exceptions=True)[0].faces  # wrong
    print(both)


def assets(path: str) -> None:
    gltf_psplit.load(path).meshes[0].primitives[0].material
    gltf_psplit.load(path, return_exceptions=True).meshes[0].primitives[0].material  # wrong
    place: NDArray[np.float64] = gltf_psplit.load(path).instances()[0].matrix
    gltf_psplit.load(path).buffer_view("image")  # wrong
    print(place)


def encoded(mesh: gltf_psplit.Mesh, points: NDArray[np.float64]) -> None:
    stream: bytes = gltf_psplit.encode(points, [[0, 1, 2]], 11, normals=points, attributes={"_X": [1.0, 2.0]}, bits={"_X": 0})
    gltf_psplit.encode(mesh, attributes=mesh.attributes)
    gltf_psplit.encode(points, bits=8)  # wrong
    gltf_psplit.encode(points, attributes=[points])  # wrong
    gltf_psplit.decode_container(*gltf_psplit.encode_container(points, [[0, 1, 2]]))
    print(stream)
