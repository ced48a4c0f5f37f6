"""gltf_psplit.load reads whole assets; decode_primitive decodes primitives of assets that other libraries read."""
import base64
import copy
import hashlib
import json
import multiprocessing
import pickle
import shutil
import struct

import gltf_psplit
import numpy as np
import pytest
from conftest import SAMPLES

EXPECTED = json.loads((SAMPLES / "expected.json").read_text())


def parts_of(path):
    """(JSON, function that gives the bytes of a buffer view) of a GLB, or of a .gltf with files."""
    data = path.read_bytes()
    if data[:4] == b"glTF":
        length = struct.unpack_from("<I", data, 12)[0]
        document, buffers = json.loads(data[20:20 + length]), [data[28 + length:]]
    else:
        document = json.loads(data)
        buffers = [(path.parent / buffer["uri"]).read_bytes() if "uri" in buffer else b"" for buffer in document["buffers"]]

    def buffer_view(index):
        view = document["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return memoryview(buffers[view["buffer"]])[start:start + view["byteLength"]]

    return document, buffer_view


def expect_sample(primitive, expected, attributes=None):
    assert primitive.point_count == expected["points"]
    assert hashlib.sha256(primitive.faces.tobytes()).hexdigest() == expected["indices_sha256"]
    for name in attributes or expected["attributes_sha256"]:
        assert hashlib.sha256(primitive[name].tobytes()).hexdigest() == expected["attributes_sha256"][name]


@pytest.mark.parametrize("name", EXPECTED)
def test_samples_of_the_extension(name):
    asset = gltf_psplit.load(SAMPLES / name)
    primitives = [primitive for mesh in asset.meshes for primitive in mesh.primitives]
    assert asset.json["meshes"] == parts_of(SAMPLES / name)[0]["meshes"]
    assert len(primitives) == len(EXPECTED[name]["primitives"])
    for primitive, expected in zip(primitives, EXPECTED[name]["primitives"]):
        expect_sample(primitive, expected)
        for target, digest in expected.get("targets_sha256", {}).items():
            _, number, semantic = target.split("/")
            assert hashlib.sha256(primitive.targets[int(number)][semantic].tobytes()).hexdigest() == digest
        assert primitive.coding == "patches" and primitive.mode == 4 and primitive.elements is primitive.faces


@pytest.mark.decoder
@pytest.mark.parametrize("name", EXPECTED)
def test_samples_without_load(name):
    document, buffer_view = parts_of(SAMPLES / name)
    lists = [mesh.get("extensions", {}).get("PSPLIT_mesh_draco_patches", mesh) for mesh in document["meshes"]]
    primitives = [primitive for mesh in lists for primitive in mesh["primitives"]]
    assert len(primitives) == len(EXPECTED[name]["primitives"])
    for primitive, expected in zip(primitives, EXPECTED[name]["primitives"]):
        stored = primitive["extensions"]["PSPLIT_mesh_draco_patches"]["attributes"]
        mesh = gltf_psplit.decode_primitive(document, primitive, buffer_view)
        expect_sample(mesh, expected, stored)
        for target, digest in expected.get("targets_sha256", {}).items():
            assert hashlib.sha256(mesh[target].tobytes()).hexdigest() == digest


def test_an_asset_with_one_primitive_is_a_mesh():
    name = "patches.glb"
    for data in (SAMPLES / name, str(SAMPLES / name), (SAMPLES / name).read_bytes()):
        expect_sample(gltf_psplit.decode(data), EXPECTED[name]["primitives"][0])
    with pytest.raises(gltf_psplit.Error, match="for Draco streams"):
        gltf_psplit.decode(SAMPLES / name, quantized=True)


def gltf(**members):
    return json.dumps({"asset": {"version": "2.0"}, **members}).encode()


def triangles(count):
    """An asset with `count` plain primitives of one triangle."""
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()
    return {
        "buffers": [{"byteLength": len(data),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3,
                       "min": [0, 0, 0], "max": [1, 1, 0]}],
        "meshes": [{"name": f"mesh {i}", "primitives": [{"attributes": {"POSITION": 0}}]} for i in range(count)]}


def test_an_asset_with_more_primitives_says_what_to_call():
    with pytest.raises(gltf_psplit.Error, match="2 primitives; gltf_psplit.load"):
        gltf_psplit.decode(gltf(**triangles(2)))


def test_plain_primitives_and_their_elements():
    members = triangles(3)
    for mesh, mode in zip(members["meshes"], (4, 3, 0)):
        mesh["primitives"][0]["mode"] = mode
    members["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    members["meshes"][0]["primitives"][0]["material"] = 0
    members["materials"] = [{"name": "red"}]
    asset = gltf_psplit.load(gltf(**members))
    face, lines, dots = (mesh.primitives[0] for mesh in asset.meshes)
    assert face.faces.tolist() == [[0, 1, 2]] and face.coding == "plain" and face.material == {"name": "red"}
    target = face.targets[0]["POSITION"]
    assert np.array_equal(target, face.points) and not np.shares_memory(target, face.points)
    assert lines.elements.tolist() == [[0, 1], [1, 2]] and lines.faces.shape == (0, 3) and lines.mode == 3
    assert dots.elements.tolist() == [[0], [1], [2]] and dots.material is None and dots.targets == []
    assert [mesh.name for mesh in asset.meshes] == ["mesh 0", "mesh 1", "mesh 2"]
    assert asset.buffer_view(0) == face.points.tobytes()
    with pytest.raises(IndexError):
        asset.buffer_view(1)


def test_instances():
    asset = gltf_psplit.load(gltf(**triangles(2), scene=1, scenes=[{"nodes": [2]}, {"nodes": [0]}], nodes=[
        {"translation": [1, 2, 3], "children": [1], "mesh": 0},
        {"rotation": [0, 0, 0.5**0.5, 0.5**0.5], "scale": [2, 2, 2], "mesh": 1},
        {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1], "mesh": 0}]))
    first, second = asset.instances()
    assert (first.mesh, first.node, second.mesh, second.node) == (0, 0, 1, 1)
    assert np.allclose(second.matrix @ [1, 0, 0, 1], [1, 4, 3, 1])  # a quarter turn, twice as large, then moved
    other, = asset.instances(scene=0)
    assert other.matrix[:3, 3].tolist() == [5, 6, 7]


def test_errors_of_primitives_have_a_place():
    document, buffer_view = parts_of(SAMPLES / "patches.glb")
    broken = bytearray((SAMPLES / "patches.glb").read_bytes())
    broken[-120:] = bytes(120)
    with pytest.raises(gltf_psplit.InvalidInputError) as error:
        gltf_psplit.load(broken)
    assert (error.value.mesh, error.value.primitive) == (0, 0) and error.value.patch is not None
    asset = gltf_psplit.load(broken, return_exceptions=True)
    assert isinstance(asset.meshes[0].primitives[0], gltf_psplit.InvalidInputError)


@pytest.mark.parametrize("data", [b"glTF", b"{}", b"{", b'{"asset": {"version": "2.0"}, "meshes": 3}', b""])
def test_broken_assets(data):
    with pytest.raises(gltf_psplit.Error):
        gltf_psplit.load(data)


def test_missing_files(tmp_path):
    with pytest.raises(FileNotFoundError):
        gltf_psplit.load(tmp_path / "missing.glb")
    shutil.copy(SAMPLES / "fallback.gltf", tmp_path)
    with pytest.raises(gltf_psplit.Error) as error:
        gltf_psplit.load(tmp_path / "fallback.gltf")
    assert error.value.code == "io"


@pytest.mark.parametrize("change", [
    {"nodes": [{"mesh": 0, "children": [7]}]}, {"nodes": [{"mesh": 3}]}, {"nodes": [{"children": [1]}, {"children": [0]}]},
    {"nodes": 5}, {"scenes": [{"nodes": ["a"]}], "nodes": [{}]}, {"scenes": [{"nodes": [1]}], "nodes": [{}]}, {"scene": 2},
    {"scene": "a", "scenes": [{}]}, {"materials": 3}, {"nodes": [3]}, {"scenes": [3]}])
def test_broken_trees(change):
    """`load` refuses them, or `instances` has nothing to stumble over."""
    try:
        gltf_psplit.load(gltf(**{**triangles(1), **change})).instances()
    except gltf_psplit.InvalidInputError:
        pass


def test_materials_that_do_not_exist():
    members = triangles(1)
    members["meshes"][0]["primitives"][0]["material"] = 3
    with pytest.raises(gltf_psplit.InvalidInputError, match="material"):
        gltf_psplit.load(gltf(**members))


@pytest.mark.parametrize("node", [{"matrix": [1]}, {"rotation": 3}, {"rotation": [1, 2, 3]}, {"translation": "far"}])
def test_nodes_without_a_place(node):
    asset = gltf_psplit.load(gltf(**triangles(1), nodes=[{"mesh": 0, **node}]))
    with pytest.raises(gltf_psplit.InvalidInputError, match="node 0"):
        asset.instances()


def test_threads():
    with pytest.raises(ValueError, match="negative"):
        gltf_psplit.load(SAMPLES / "seams.glb", threads=-1)
    one, many = (gltf_psplit.load(SAMPLES / "seams.glb", threads=count).meshes[0].primitives[0] for count in (1, 3))
    assert np.array_equal(one.points, many.points) and np.array_equal(one.faces, many.faces)


def test_unicode_paths(tmp_path):
    path = tmp_path / "Käfer 甲虫.glb"
    shutil.copy(SAMPLES / "seams.glb", path)
    expect_sample(gltf_psplit.load(path).meshes[0].primitives[0], EXPECTED["seams.glb"]["primitives"][0])


def test_what_decode_primitive_needs():
    document, buffer_view = parts_of(SAMPLES / "patches.glb")
    primitive = document["meshes"][0]["primitives"][0]
    assert gltf_psplit.decode_primitive(document, {"attributes": primitive["attributes"]}, buffer_view) is None
    with pytest.raises(gltf_psplit.InvalidInputError, match="JSON"):
        gltf_psplit.decode_primitive({}, primitive, buffer_view)
    for broken in ({"attributes": 3}, {"extensions": 3}, {"indices": "a"}, {"extensions": {"KHR_draco_mesh_compression": 1}}):
        with pytest.raises(gltf_psplit.InvalidInputError, match="JSON"):
            gltf_psplit.decode_primitive(document, {**primitive, **broken}, buffer_view)


def test_corpus(corpus, reference):
    """Every asset of the corpus in stock Draco: `load` gives the points and faces of libdraco."""
    compared = 0
    for path in sorted([*corpus.glob("gltf/**/*.glb"), *corpus.glob("gltf/**/*.gltf")]):
        asset = None
        for m, p in stock_primitives(path):
            asset = asset or gltf_psplit.load(path)
            primitive = asset.meshes[m].primitives[p]
            extension = asset.json["meshes"][m]["primitives"][p]["extensions"]["KHR_draco_mesh_compression"]
            faces, attributes = reference.decode(asset.buffer_view(extension["bufferView"]))
            assert np.array_equal(primitive.faces, faces), path
            values = {unique_id: values for _, unique_id, values in attributes}
            for name, unique_id in extension["attributes"].items():
                if primitive[name].dtype == values[unique_id].dtype:
                    assert primitive[name].tobytes() == values[unique_id].tobytes(), (path, name)
                    compared += 1
    assert compared > 20


def stock_primitives(path):
    data = path.read_bytes()
    if b"KHR_draco_mesh_compression" not in data:
        return []
    text = data[20:20 + struct.unpack_from("<I", data, 12)[0]] if data[:4] == b"glTF" else data
    meshes = json.loads(text).get("meshes", [])
    return [(m, p) for m, mesh in enumerate(meshes) for p, primitive in enumerate(mesh["primitives"])
            if "KHR_draco_mesh_compression" in primitive.get("extensions", {})]


def expect_same(asset, other):
    assert other.json == asset.json and [mesh.name for mesh in other.meshes] == [mesh.name for mesh in asset.meshes]
    for mesh, copied in zip(asset.meshes, other.meshes):
        for primitive, again in zip(mesh.primitives, copied.primitives):
            assert np.array_equal(again.faces, primitive.faces) and again.mode == primitive.mode
            assert list(again) == list(primitive) and all(np.array_equal(again[name], primitive[name]) for name in again)
            assert len(again.targets) == len(primitive.targets) and again.material == primitive.material
    for index in range(len(asset.json["bufferViews"])):
        assert other.buffer_view(index) == asset.buffer_view(index)
    with pytest.raises(IndexError):
        other.buffer_view(len(asset.json["bufferViews"]))
    assert [place.node for place in other.instances()] == [place.node for place in asset.instances()]


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda asset: pickle.loads(pickle.dumps(asset)),
                                   lambda asset: pickle.loads(pickle.dumps(copy.copy(asset)))])
def test_copies(again):
    for name in ("seams.glb", "fallback.gltf"):
        asset = gltf_psplit.load(SAMPLES / name)
        expect_same(asset, again(asset))


def test_copies_with_errors():
    broken = bytearray((SAMPLES / "patches.glb").read_bytes())
    broken[-120:] = bytes(120)
    asset = pickle.loads(pickle.dumps(gltf_psplit.load(broken, return_exceptions=True)))
    assert isinstance(asset.meshes[0].primitives[0], gltf_psplit.InvalidInputError)


def test_assets_pass_between_processes():
    """Also where processes begin anew, as on Windows and macOS."""
    paths = [SAMPLES / "seams.glb", SAMPLES / "patches.glb"]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        for path, asset in zip(paths, pool.map_async(gltf_psplit.load, paths).get(120)):
            expect_same(gltf_psplit.load(path), asset)
