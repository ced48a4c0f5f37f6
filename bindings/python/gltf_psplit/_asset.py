"""Whole glTF assets."""
from __future__ import annotations

import json
import os
from typing import Any, Dict, List, NamedTuple, Optional

import numpy as np

from . import _native
from ._errors import InvalidInputError, UnsupportedError
from ._gltf import PATCHES
from ._input import BytesLike
from ._mesh import Mesh


class Primitive(Mesh):
    """A part of an asset's mesh with one material. It is a `Mesh`, whose attributes have the names of the asset.

    Attributes:
        elements: array of (elements, 3) uint32 for triangles, (elements, 2) for lines, (elements, 1) for points.
            Strips, fans and loops are lists. `faces` is the same for triangles, and empty for others.
        mode: glTF's mode, as the JSON says: 4 are triangles.
        material: the material's JSON, or None.
        targets: for each morph target a dict of arrays, by name.
    """

    __slots__ = ("elements", "mode", "material", "targets")

    def __init__(self, corners: int, mesh: tuple, targets: List[Dict[str, np.ndarray]], mode: int,
                 material: Optional[Dict[str, Any]]) -> None:
        super().__init__(*mesh)
        # Rows have three columns in any case; lines and points use the first ones.
        self.elements = self.faces if corners == 3 else self.faces[:, :corners]
        if corners != 3:
            self.faces = self.faces[:0]
        self.mode = mode
        self.material = material
        self.targets = targets


class AssetMesh(NamedTuple):
    """A mesh of an asset: its name in the JSON, or None, and its primitives."""

    name: Optional[str]
    primitives: List[Primitive]


class Instance(NamedTuple):
    """A node that draws a mesh.

    Attributes:
        mesh: the index of the mesh.
        matrix: array of (4, 4) float64, which takes the mesh's points, as columns (x, y, z, 1), to the scene.
        node: the index of the node.
    """

    mesh: int
    matrix: np.ndarray
    node: int


class Asset:
    """A glTF asset.

    Attributes:
        json: the JSON of the asset, as it was read: a dict.
        meshes: list of `AssetMesh`. All primitives are decoded.
    """

    def __init__(self, native: "_native.Asset", threads: int, return_exceptions: bool) -> None:
        self._native = native
        self.json: Dict[str, Any] = json.loads(native.json())
        self.meshes: List[AssetMesh] = []
        records = self.json.get("meshes", [])
        for record, primitives in zip(records, native.primitives(threads)):
            mesh = AssetMesh(record.get("name"), [])
            fine = record.get("extensions", {}).get(PATCHES, record)["primitives"]
            for described, decoded in zip(fine, primitives):
                if isinstance(decoded, BaseException):
                    if not return_exceptions:
                        raise decoded
                    mesh.primitives.append(decoded)  # type: ignore[arg-type]
                    continue
                material = described.get("material")
                mesh.primitives.append(Primitive(*decoded, described.get("mode", 4),
                                                 None if material is None else self.json["materials"][material]))
            self.meshes.append(mesh)

    def buffer_view(self, index: int) -> bytes:
        """The bytes of a buffer view, for example of an image. IndexError if there is none."""
        return self._native.buffer_view(index)

    def instances(self, scene: Optional[int] = None) -> List[Instance]:
        """The nodes of a scene that draw meshes, with their places in it.

        Args:
            scene: the index of the scene; by default the asset's, or its first. An asset without scenes: all nodes.

        Raises:
            InvalidInputError: the matrix, rotation, scale or translation of a node is not as glTF has it.
            IndexError: the asset has no such scene.
        """
        nodes = self.json.get("nodes", [])
        scenes = self.json.get("scenes", [])
        if scenes:
            roots = scenes[self.json.get("scene", 0) if scene is None else scene].get("nodes", [])
        else:
            children = {child for node in nodes for child in node.get("children", [])}
            roots = [index for index in range(len(nodes)) if index not in children]
        # `load` refused indices that do not exist, and nodes that are not a forest.
        instances: List[Instance] = []
        waiting = [(index, np.eye(4)) for index in reversed(roots)]
        while waiting:
            index, parent = waiting.pop()
            node = nodes[index]
            try:
                matrix = parent @ matrix_of(node)
            except (TypeError, ValueError) as error:
                raise InvalidInputError(f"node {index} has no valid place: {error}") from error
            if "mesh" in node:
                instances.append(Instance(node["mesh"], matrix, index))
            waiting.extend((child, matrix) for child in reversed(node.get("children", [])))
        return instances

    def __repr__(self) -> str:
        return f"<gltf_psplit.Asset: {len(self.meshes)} meshes, {sum(len(mesh.primitives) for mesh in self.meshes)} primitives>"


def matrix_of(node: Dict[str, Any]) -> np.ndarray:
    """The matrix of a node in its parent's space: (4, 4) float64."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T  # glTF stores columns
    matrix = np.eye(4)
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    matrix[:3, :3] *= np.asarray(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def load(source: BytesLike, *, threads: int = 0, return_exceptions: bool = False) -> Asset:
    """Reads a glTF asset and decodes all of its primitives.

    Args:
        source: the path of a .glb or .gltf, or the bytes of one. Relative URIs in bytes start from the current folder.
        threads: at most so many threads; 0: all of the machine.
        return_exceptions: put the exception of a primitive in its place. Otherwise the first one is raised.

    Returns:
        An `Asset`. Primitives may be in patches, in Draco (of any version), compressed by meshoptimizer, or plain.

    Raises:
        InvalidInputError, UnsupportedError: with `mesh`, `primitive` and `patch`, as far as they are known.
        UnsupportedError: this package was built without its encoder; `decode_primitive` works without.
        OSError: the file cannot be read. Error with the code "io": one of its buffers cannot be read.
    """
    if not hasattr(_native, "Asset"):
        raise UnsupportedError("this package was built without its encoder, which gltf_psplit.load needs; gltf_psplit.decode_primitive "
                               "decodes a primitive of an asset whose JSON was read by others")
    if isinstance(source, (str, os.PathLike)):
        with open(source, "rb"):  # raises what Python's programs expect
            pass
        native = _native.Asset(os.fsencode(source), None)  # type: ignore[arg-type]
    else:
        native = _native.Asset("", source)
    return Asset(native, threads, return_exceptions)
