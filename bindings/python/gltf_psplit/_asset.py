"""Whole glTF assets."""
from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Generic, List, NamedTuple, Optional, Tuple, TypeVar, Union, overload

import numpy as np

from . import _native
from ._errors import Error, InvalidInputError, UnsupportedError
from ._gltf import PATCHES
from ._input import Source, bytes_of, flag, integer, thread_count
from ._mesh import Mesh

if TYPE_CHECKING:
    from typing_extensions import Literal

    from numpy.typing import NDArray


class Primitive(Mesh):
    """A part of an asset's mesh with one material. It is a `Mesh` whose attributes have the asset's names.

    Attributes:
        elements: array of (elements, 3) uint32 for triangles, (elements, 2) for lines, (elements, 1) for points.
            Strips, fans and loops are converted to lists. `faces` equals it for triangles, and is empty otherwise.
        mode: glTF's mode, as in the JSON: 4 means triangles.
        material: the material's JSON, or None.
        targets: for each morph target a dict of arrays, by name.
    """

    __slots__ = ("elements", "mode", "material", "targets")

    def __init__(self, corners: int, mesh: Tuple[Any, ...], targets: List[Dict[str, NDArray[Any]]], mode: int,
                 material: Optional[Dict[str, Any]]) -> None:
        super().__init__(*mesh)
        # Rows always have three columns; lines and points use only the first ones.
        self.elements = self.faces if corners == 3 else self.faces[:, :corners]
        if corners != 3:
            self.faces = self.faces[:0]
        self.mode = mode
        self.material = material
        self.targets = targets


# A primitive, or, with return_exceptions (`load`), possibly the exception in its place.
Loaded = TypeVar("Loaded", Primitive, Union[Primitive, Error])


@dataclass
class AssetMesh(Generic[Loaded]):
    """A mesh of an asset: its name in the JSON, or None, and its primitives."""

    name: Optional[str]
    primitives: List[Loaded]


class Instance(NamedTuple):
    """A node that draws a mesh.

    Attributes:
        mesh: the index of the mesh.
        matrix: array of (4, 4) float64, which maps the mesh's points, as columns (x, y, z, 1), to the scene.
        node: the index of the node.
    """

    mesh: int
    matrix: NDArray[np.float64]
    node: int


class Asset(Generic[Loaded]):
    """A glTF asset. It can be copied and pickled; the copy has the bytes of all buffer views.

    Attributes:
        json: the JSON of the asset as a dict, unchanged.
        meshes: list of `AssetMesh`. All primitives are decoded.
    """

    def __init__(self, native: _native.Asset, threads: int, return_exceptions: bool) -> None:
        self._views: Union[_native.Asset, List[Union[bytes, Error]]] = native
        self.json: Dict[str, Any] = json.loads(native.json())
        self.meshes: List[AssetMesh[Loaded]] = []
        records = self.json.get("meshes", [])
        for record, primitives in zip(records, native.primitives(threads)):
            mesh: AssetMesh[Any] = AssetMesh(record.get("name"), [])
            fine = record.get("extensions", {}).get(PATCHES, record)["primitives"]
            for described, decoded in zip(fine, primitives):
                if isinstance(decoded, Exception):
                    if not return_exceptions:
                        raise decoded
                    mesh.primitives.append(decoded)
                    continue
                material = described.get("material")
                mesh.primitives.append(Primitive(*decoded, described.get("mode", 4),
                                                 None if material is None else self.json["materials"][material]))
            self.meshes.append(mesh)

    def buffer_view(self, index: int) -> bytes:
        """The bytes of a buffer view, for example of an image. IndexError if it does not exist."""
        views = self._views
        count = len(views) if isinstance(views, list) else views.buffer_view_count()
        try:
            index = integer(index, "index", 0, count - 1)
        except ValueError:
            raise IndexError(f"index is {index}, and the asset has {count} buffer views") from None
        view = views[index] if isinstance(views, list) else views.buffer_view(index)
        if isinstance(view, Error):
            raise view
        return view

    def __getstate__(self) -> Dict[str, Any]:
        """The pickled state: buffer views as bytes, or as the errors of reading them."""

        def view(index: int) -> Union[bytes, Error]:
            try:
                return self.buffer_view(index)
            except Error as error:
                return error

        views = self._views
        count = len(views) if isinstance(views, list) else views.buffer_view_count()
        return {**self.__dict__, "_views": [view(index) for index in range(count)]}

    def instances(self, scene: Optional[int] = None) -> List[Instance]:
        """The nodes of a scene that draw meshes, with their transforms.

        Args:
            scene: the index of the scene; by default the asset's default scene, or its first one. In an asset without scenes, all
                nodes.

        Raises:
            InvalidInputError: the matrix, rotation, scale or translation of a node is invalid.
            IndexError: the asset has no such scene.
        """
        nodes = self.json.get("nodes", [])
        scenes = self.json.get("scenes", [])
        if scene is not None and not 0 <= integer(scene, "scene", -2**63, 2**63) < len(scenes):
            raise IndexError(f"scene is {scene}, and the asset has {len(scenes)} scenes")
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


def matrix_of(node: Dict[str, Any]) -> NDArray[np.float64]:
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


@overload
def load(source: Source, *, threads: int = 0, return_exceptions: Literal[False] = False) -> Asset[Primitive]: ...


@overload
def load(source: Source, *, threads: int = 0, return_exceptions: Literal[True]) -> Asset[Union[Primitive, Error]]: ...


def load(source: Source, *, threads: int = 0, return_exceptions: bool = False) -> Any:
    """Reads a glTF asset and decodes all of its primitives.

    Args:
        source: the path of a .glb or .gltf file, or its bytes. Relative URIs in bytes are resolved from the current folder.
        threads: the maximum number of threads; 0: one for each processor.
        return_exceptions: put the exception of a primitive in the primitive's place. Otherwise the first one is raised.

    Returns:
        An `Asset`. Primitives may be in patches, in Draco (of any version), compressed by meshoptimizer, or plain.

    Raises:
        InvalidInputError, UnsupportedError: with `mesh`, `primitive` and `patch`, if they are known.
        UnsupportedError: this package was built without its encoder; `decode_primitive` works without.
        OSError: the file cannot be read. Error with the code "io": one of its buffers cannot be read.
    """
    if not hasattr(_native, "Asset"):
        raise UnsupportedError("this package was built without its encoder, which gltf_psplit.load needs; gltf_psplit.decode_primitive "
                               "decodes a primitive of an asset whose JSON was read by others")
    threads, return_exceptions = thread_count(threads), flag(return_exceptions, "return_exceptions")
    if isinstance(source, (str, os.PathLike)):
        with open(source, "rb"):  # raises Python's own OSError
            pass
        native = _native.Asset(os.fsencode(source), None)
    else:
        native = _native.Asset("", bytes_of(source, "source"))
    return Asset(native, threads, return_exceptions)
