"""Lets meshio read and write Draco files.

    import gltf_psplit.meshio_plugin
    gltf_psplit.meshio_plugin.register()
    mesh = meshio.read("bunny.drc")

Attributes but the positions are point data by their names. Faces are cells "triangle"; the points of a point cloud are cells
"vertex". A mesh with such cells alone, or without cells, is written as a point cloud of all its points. Writing needs the
package's encoder, and takes the parameters of `gltf_psplit.encode`.
"""
from __future__ import annotations

import warnings
from typing import Any, List

import numpy as np

from . import _decode, _encode
from ._errors import Error


def register() -> None:
    """Registers the format "draco" for .drc. ImportError: meshio is missing."""
    import meshio  # type: ignore[import]

    meshio.register_format("draco", [".drc"], read, {"draco": write})


def read(file: Any) -> Any:
    """Reads a Draco file (a path, or a file that is open for bytes) as a `meshio.Mesh`."""
    import meshio

    try:
        mesh = _decode.decode(file.read() if hasattr(file, "read") else file)
    except Error as error:
        raise meshio.ReadError(str(error)) from error
    is_cloud = mesh.coding.startswith("cloud-")
    cells: List[Any] = [("vertex", np.arange(mesh.point_count).reshape(-1, 1)) if is_cloud else ("triangle", mesh.faces)]
    return meshio.Mesh(mesh.points, cells, point_data={name: mesh[name] for name in mesh if name != "POSITION"})


def write(file: Any, mesh: Any, **parameters: Any) -> None:
    """Writes the triangles or the points of a `meshio.Mesh` as a Draco file, with its point data. Warns about cell data, which it
    leaves out."""
    import meshio

    kinds = {cells.type for cells in mesh.cells}
    if not (kinds <= {"triangle"} or kinds == {"vertex"}):
        raise meshio.WriteError(f"gltf_psplit writes triangles or points, and the mesh has cells of {', '.join(sorted(kinds))}")
    faces = [cells.data for cells in mesh.cells if cells.type == "triangle"]
    points = np.asarray(mesh.points)
    if points.shape[1] == 2:  # meshio has meshes in the plane
        points = np.column_stack([points, np.zeros(len(points))])
    if mesh.cell_data:
        warnings.warn(f"Draco has no cell data: {', '.join(sorted(mesh.cell_data))} is left out", stacklevel=2)
    try:
        stream = _encode.encode(points, np.concatenate(faces) if faces else None,
                                **{"attributes": mesh.point_data, **parameters})
    except (TypeError, ValueError) as error:
        raise meshio.WriteError(str(error)) from error
    if hasattr(file, "write"):
        file.write(stream)
        return
    with open(file, "wb") as opened:
        opened.write(stream)
