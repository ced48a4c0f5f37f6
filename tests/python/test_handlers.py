"""The handlers for meshio and trimesh."""
import io

import gltf_psplit
import numpy as np
import pytest
from conftest import SAMPLES, torus
from test_asset import EXPECTED, expect_sample, parts_of

POINTS, FACES, NORMALS, TEX_COORD = torus(20, 30)


@pytest.fixture
def meshio():
    module = pytest.importorskip("meshio")
    import gltf_psplit.meshio_plugin
    gltf_psplit.meshio_plugin.register()
    yield module
    module.deregister_format("draco")


def test_meshio_reads_and_writes(meshio, tmp_path):
    mesh = meshio.Mesh(POINTS, [("triangle", FACES)], point_data={"NORMAL": NORMALS, "TEXCOORD_0": TEX_COORD, "temperature": np.arange(len(POINTS))})
    mesh.write(tmp_path / "a.drc", quantization_bits=16)
    read = meshio.read(tmp_path / "a.drc")
    expected = gltf_psplit.decode(tmp_path / "a.drc")
    assert expected.attributes["POSITION"].bits == 16 and len(read.cells_dict["triangle"]) == len(FACES)
    assert np.array_equal(read.points, expected.points) and np.array_equal(read.cells_dict["triangle"], expected.faces)
    assert set(read.point_data) == {"NORMAL", "TEXCOORD_0", "temperature"}
    assert set(read.point_data["temperature"].ravel()) == set(range(len(POINTS)))
    assert np.array_equal(read.point_data["NORMAL"], expected.normals)


def test_meshio_with_open_files(meshio):
    file = io.BytesIO()
    meshio.Mesh(POINTS, [("triangle", FACES)]).write(file, file_format="draco")
    file.seek(0)
    assert len(meshio.read(file, file_format="draco").cells_dict["triangle"]) == len(FACES)


def test_meshio_reads_point_clouds(meshio, corpus):
    read = meshio.read(corpus / "mesh" / "draco" / "pc_color.drc")
    assert list(read.cells_dict) == ["vertex"] and len(read.cells_dict["vertex"]) == len(read.points) > 0
    assert "COLOR_0" in read.point_data


@pytest.mark.parametrize("cells", [[("vertex", np.arange(len(POINTS)).reshape(-1, 1))], []])
def test_meshio_writes_point_clouds(meshio, tmp_path, cells):
    meshio.Mesh(POINTS, cells, point_data={"NORMAL": NORMALS}).write(tmp_path / "a.drc", quantization_bits=0, preserve_order=True)
    read = meshio.read(tmp_path / "a.drc")
    assert np.array_equal(read.points, POINTS) and np.abs(read.point_data["NORMAL"] - NORMALS).max() < 5e-3
    read.write(tmp_path / "b.drc", preserve_order=True, quantization_bits=0)
    assert np.array_equal(meshio.read(tmp_path / "b.drc").cells_dict["vertex"], read.cells_dict["vertex"])


def test_what_meshio_cannot_write(meshio, tmp_path):
    with pytest.raises(meshio.WriteError, match="quad"):
        meshio.Mesh(POINTS, [("quad", [[0, 1, 2, 3]])]).write(tmp_path / "a.drc")
    with pytest.raises(meshio.WriteError, match="triangle, vertex"):
        meshio.Mesh(POINTS, [("triangle", FACES), ("vertex", [[0]])]).write(tmp_path / "a.drc")
    with pytest.warns(UserWarning, match="part"):
        meshio.Mesh(POINTS, [("triangle", FACES)], cell_data={"part": [np.zeros(len(FACES))]}).write(tmp_path / "a.drc")
    with pytest.raises(meshio.WriteError, match="stress"):
        meshio.Mesh(POINTS, [("triangle", FACES)], point_data={"stress": np.zeros((len(POINTS), 20))}).write(tmp_path / "a.drc")
    (tmp_path / "b.drc").write_bytes(b"DRACO and nothing else")
    with pytest.raises(meshio.ReadError), open(tmp_path / "b.drc", "rb") as file:
        meshio.read(file, file_format="draco")


SHAPES = {"SCALAR": (), "VEC2": (2,), "VEC3": (3,), "VEC4": (4,)}
DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


def context_of(name, number=0):
    """What trimesh hands to a handler of the scope "primitive_preprocess"."""
    document, buffer_view = parts_of(SAMPLES / name)
    accessors = [np.zeros((a["count"], *SHAPES[a["type"]]), DTYPES[a["componentType"]]) for a in document["accessors"]]
    primitive = document["meshes"][0]["primitives"][number]
    views = [bytes(buffer_view(index)) for index in range(len(document["bufferViews"]))]
    return {"data": primitive["extensions"]["PSPLIT_mesh_draco_patches"], "primitive": primitive, "accessors": accessors,
            "views": views}


@pytest.mark.parametrize("name", ["patches.glb", "seams.glb", "condensed.glb"])
def test_trimesh_handler(name):
    from gltf_psplit import trimesh_handler
    context = context_of(name)
    before = [array.copy() for array in context["accessors"]]
    assert trimesh_handler.decode_patches(context) == {"decompressed": True}
    arrays, primitive = context["accessors"], context["primitive"]
    expected = gltf_psplit.load(SAMPLES / name).meshes[0].primitives[0]
    expect_sample(expected, EXPECTED[name]["primitives"][0])
    assert np.array_equal(arrays[primitive["indices"]].reshape(-1, 3), expected.faces)
    for attribute, index in primitive["attributes"].items():
        assert np.array_equal(arrays[index], expected[attribute])
    assert all(np.array_equal(a, b) for a, b in zip(arrays, before))  # other primitives may use them


def test_trimesh_itself(tmp_path):
    extensions = pytest.importorskip("trimesh.exchange.gltf.extensions", reason="Debian 12 has no trimesh")
    import trimesh
    from gltf_psplit import trimesh_handler
    trimesh_handler.register()
    assert "PSPLIT_mesh_draco_patches" in extensions._handlers["primitive_preprocess"]
    scene = trimesh.load(SAMPLES / "patches.glb", process=False)
    loaded, = scene.geometry.values()
    expected = gltf_psplit.decode(SAMPLES / "patches.glb")
    assert np.array_equal(loaded.faces, expected.faces) and np.array_equal(loaded.vertices, expected.points)
