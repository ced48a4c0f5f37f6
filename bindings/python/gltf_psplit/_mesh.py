"""Decoded meshes."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, Iterator, KeysView, List, Optional, Tuple, TypeVar, Union, overload

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Default = TypeVar("Default")


class Metadata:
    """Metadata of a Draco stream: entries of bytes, under names that the writer chose.

    Attributes:
        entries: the bytes of each entry. The program that wrote them defines their type.
    """

    __slots__ = ("entries", "_parts")

    def __init__(self, entries: Dict[str, bytes], parts: Dict[str, Tuple[Any, Any]]) -> None:
        self.entries = entries
        self._parts = parts

    @property
    def parts(self) -> Dict[str, "Metadata"]:
        """The nested metadata, by name."""
        return {name: Metadata(*part) for name, part in self._parts.items()}

    def __getitem__(self, name: str) -> bytes:
        return self.entries[name]

    def __contains__(self, name: object) -> bool:
        return name in self.entries

    def __repr__(self) -> str:
        return f"gltf_psplit.Metadata({sorted(self.entries)}, parts={sorted(self._parts)})"


class Attribute:
    """One attribute of a mesh, with its description in the data.

    Attributes:
        name: glTF's name: "POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0". Other attributes have the name in the stream's
            metadata, such as "JOINTS_0", or "_GENERIC_0" and so on.
        unique_id: Draco's unique id; None for attributes of an asset.
        values: array of (points, components), one row for each point, in the type of the data. Writable.
        normalized: whether integers stand for fractions, as in glTF.
        bits: bits of a component on its grid, or of a normal on its octahedron; 0 if values are stored exactly. None if
            unknown.
        origin, range: the grid of quantized values: origin + i * range / (2**bits - 1), with i from 0 to 2**bits - 1.
            `origin` is an array of (components,) float32. Both are None for other attributes.
        are_integers: whether `values` are the integers of the stream (int32; see `decode`).
        metadata: the attribute's `Metadata`, or None.
    """

    __slots__ = ("name", "unique_id", "values", "normalized", "bits", "origin", "range", "are_integers", "metadata")

    def __init__(self, name: str, unique_id: Optional[int], values: NDArray[Any], normalized: bool = False,
                 bits: Optional[int] = None, origin: Optional[NDArray[np.float32]] = None, range: Optional[float] = None,
                 are_integers: bool = False, metadata: Optional[Metadata] = None) -> None:
        self.name = name
        self.unique_id = unique_id
        self.values = values
        self.normalized = normalized
        self.bits = bits
        self.origin = origin
        self.range = range
        self.are_integers = are_integers
        self.metadata = metadata

    def __repr__(self) -> str:
        return f"<gltf_psplit.Attribute {self.name}: {self.values.dtype} {self.values.shape}>"


class Mesh:
    """A mesh or a point cloud in arrays.

    `mesh["POSITION"]` and `mesh.by_id(0)` are arrays of attributes; `mesh.attributes["POSITION"]` describes the
    attribute. A point is a vertex of glTF: all attributes have one row for each point. Arrays own their memory, and stay
    valid without the mesh.

    Attributes:
        faces: array of (faces, 3) uint32, point indices. A point cloud has no rows.
        point_count: the number of points.
        attributes: dict of the attributes by name, in the order of the data.
        coding: how the mesh was stored: "sequential", "edgebreaker", "edgebreaker-valence", "cloud-sequential",
            "cloud-kd-tree", "patches", "draco" (a stream in a glTF asset), or "plain".
        metadata: the stream's `Metadata`, or None.
    """

    __slots__ = ("faces", "point_count", "attributes", "coding", "metadata")

    def __init__(self, coding: str, point_count: int, faces: NDArray[np.uint32], attributes: List[Tuple[Any, ...]],
                 metadata: Optional[Tuple[Any, Any]] = None) -> None:
        self.coding = coding
        self.point_count = point_count
        self.faces = faces
        self.attributes: Dict[str, Attribute] = {given[0]: Attribute(*given) for given in attributes}
        self.metadata: Optional[Metadata] = None
        if metadata is not None:
            of_geometry, of_attributes = metadata
            self.metadata = Metadata(*of_geometry)
            for attribute in self.attributes.values():
                if attribute.unique_id in of_attributes:
                    attribute.metadata = Metadata(*of_attributes[attribute.unique_id])

    def by_id(self, unique_id: int) -> NDArray[Any]:
        """The array of the attribute with this Draco unique id. KeyError if it does not exist."""
        for attribute in self.attributes.values():
            if attribute.unique_id == unique_id:
                return attribute.values
        raise KeyError(unique_id)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.attributes[name].values

    @overload
    def get(self, name: str) -> Optional[NDArray[Any]]: ...

    @overload
    def get(self, name: str, default: Default) -> Union[NDArray[Any], Default]: ...

    def get(self, name: str, default: Any = None) -> Any:
        """The array of an attribute, or `default`."""
        attribute = self.attributes.get(name)
        return default if attribute is None else attribute.values

    def __contains__(self, name: object) -> bool:
        return name in self.attributes

    def __iter__(self) -> Iterator[str]:
        return iter(self.attributes)

    def __len__(self) -> int:
        return len(self.attributes)

    def keys(self) -> KeysView[str]:
        """The names of the attributes; with `mesh[name]`, this makes `dict(mesh)` a dict of arrays."""
        return self.attributes.keys()

    @property
    def points(self) -> NDArray[Any]:
        """The positions: (points, 3), in most streams float32. KeyError without positions."""
        return self["POSITION"]

    @property
    def normals(self) -> Optional[NDArray[Any]]:
        """The normals, or None."""
        return self.get("NORMAL")

    @property
    def tex_coord(self) -> Optional[NDArray[Any]]:
        """The first texture coordinates, or None."""
        return self.get("TEXCOORD_0")

    @property
    def colors(self) -> Optional[NDArray[Any]]:
        """The first colours, or None."""
        return self.get("COLOR_0")

    def __repr__(self) -> str:
        kind = type(self).__name__
        return f"<gltf_psplit.{kind}: {len(self.faces)} faces, {self.point_count} points, {', '.join(self.attributes)}>"
