"""gltf_psplit.encode takes any attribute, and what gltf_psplit.decode returns."""
import base64
import json

import gltf_psplit
import numpy as np
import pytest
from conftest import SAMPLES, expect_libdraco, torus

POINTS, FACES, NORMALS, TEX_COORD = torus(20, 30)
COUNT = len(POINTS)
RANDOM = np.random.default_rng(1)
JOINTS = RANDOM.integers(0, 200, (COUNT, 4))
WEIGHTS = np.tile([0.5, 0.25, 0.25, 0], (COUNT, 1))


def encoded(attributes, **parameters):
    """Decoded again, in the order of the input."""
    return gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, preserve_order=True, attributes=attributes, **parameters))


def test_names_and_types(reference):
    given = {"JOINTS_0": JOINTS, "WEIGHTS_0": WEIGHTS, "TANGENT": np.c_[NORMALS, np.ones(COUNT)], "TEXCOORD_0": TEX_COORD,
             "TEXCOORD_1": TEX_COORD / 2, "COLOR_0": RANDOM.integers(0, 255, (COUNT, 4)).astype(np.uint8),
             "COLOR_1": RANDOM.random((COUNT, 3)), "_ID": np.arange(COUNT), "température": RANDOM.random(COUNT)}
    for order in (True, False):
        stream = gltf_psplit.encode(POINTS, FACES, preserve_order=order, attributes=given)
        mesh = gltf_psplit.decode(stream)
        expect_libdraco(reference, mesh, stream)
        assert set(mesh) == {"POSITION", *given}
        assert {name: str(mesh[name].dtype) for name in ("JOINTS_0", "COLOR_0", "_ID", "WEIGHTS_0", "température")} == {
            "JOINTS_0": "uint8", "COLOR_0": "uint8", "_ID": "uint16", "WEIGHTS_0": "float32", "température": "float32"}
        assert {name: mesh.attributes[name].bits for name in given if mesh.attributes[name].bits} == {
            "WEIGHTS_0": 12, "TANGENT": 12, "TEXCOORD_0": 12, "TEXCOORD_1": 12, "COLOR_1": 8, "température": 12}
        assert [name for name in mesh if mesh.attributes[name].normalized] == ["COLOR_0"]
    mesh = encoded(given)
    for name in ("JOINTS_0", "COLOR_0", "_ID"):
        assert np.array_equal(mesh[name], given[name].reshape(COUNT, -1))
    for name in ("WEIGHTS_0", "TANGENT", "TEXCOORD_1", "COLOR_1", "température"):
        extent = max(1, 2 if name == "TANGENT" else 1)
        assert np.abs(mesh[name] - given[name].reshape(COUNT, -1)).max() <= 0.51 * extent / (2**mesh.attributes[name].bits - 1)
    assert np.allclose(mesh["WEIGHTS_0"].sum(axis=1), 1, atol=1e-6)
    assert mesh.attributes["JOINTS_0"].metadata["name"] == b"JOINTS_0"  # where DracoPy looks for it


@pytest.mark.parametrize("values, kind", [
    (np.arange(COUNT) % 256 - 128, "int8"), (np.arange(COUNT) % 2 == 0, "uint8"), (np.arange(COUNT) * 100, "uint16"),
    (np.arange(COUNT) - 300, "int16"), (np.arange(COUNT) * 20000, "float32"), (np.arange(COUNT, dtype=">u2"), "uint16"),
    (np.arange(COUNT, dtype=np.uint64), "uint16"), (np.arange(COUNT, dtype=np.float64) * 3 - 7, "float32"),
    (np.where(np.arange(COUNT) == 3, np.nan, np.pi).astype(np.float32), "float32")])
def test_values_that_are_exact(values, kind):
    decoded = encoded({"_X": values})["_X"]
    assert decoded.dtype == kind and np.array_equal(decoded[:, 0], values, equal_nan=decoded.dtype.kind == "f")


def test_bits_of_single_attributes():
    given = {"WEIGHTS_0": WEIGHTS, "TEXCOORD_1": TEX_COORD, "_X": RANDOM.random((COUNT, 16)), "_Y": RANDOM.random((COUNT, 2))}
    mesh = encoded(given, normals=NORMALS, tex_coord=TEX_COORD, texcoord_bits=9,
                   bits={"WEIGHTS_0": 8, "TEXCOORD_1": 16, "_X": 0, "NORMAL": 7})
    assert {name: mesh.attributes[name].bits for name in mesh} == {
        "POSITION": 14, "NORMAL": 7, "TEXCOORD_0": 9, "WEIGHTS_0": 8, "TEXCOORD_1": 16, "_X": 0, "_Y": 12}
    assert np.array_equal(mesh["_X"], given["_X"].astype(np.float32))


def test_sets_keep_their_numbers():
    first, second = TEX_COORD, TEX_COORD[::-1]
    mesh = encoded({"TEXCOORD_1": second, "_X": np.zeros(COUNT), "TEXCOORD_0": first}, texcoord_bits=0)
    assert np.array_equal(mesh["TEXCOORD_0"], first) and np.array_equal(mesh["TEXCOORD_1"], second)
    with pytest.raises(ValueError, match="TEXCOORD_1, and no TEXCOORD_0"):
        encoded({"TEXCOORD_1": second})


@pytest.mark.parametrize("attributes, kind, message", [
    ({"_X": np.zeros(COUNT + 1)}, ValueError, r"attributes\['_X'\] has 652 rows, and there are 651 points"),
    ({"_X": np.zeros((COUNT, 17))}, ValueError, r"attributes\['_X'\] has the shape \(651, 17\)"),
    ({"_X": np.zeros((COUNT, 2, 2))}, ValueError, r"attributes\['_X'\] has the shape"),
    ({"_X": ["a"] * COUNT}, TypeError, r"attributes\['_X'\] has the type <U1"),
    ({"_X": [[1], [1, 2]]}, ValueError, r"attributes\['_X'\] is not an array"),
    ({"_X": np.arange(COUNT) * 10**6}, NotImplementedError, r"attributes\['_X'\] has integers from 0 to 650000000"),
    ({3: np.zeros(COUNT)}, TypeError, "attributes has the key 3"), ({"": np.zeros(COUNT)}, ValueError, "attributes has the name ''"),
    ({"x" * 128: np.zeros(COUNT)}, ValueError, "not 1 to 127 bytes"), ({"\ud800": np.zeros(COUNT)}, ValueError, "not valid Unicode"),
    ({"POSITION": POINTS}, ValueError, r"attributes\['POSITION'\] is points once more"),
    ({"NORMAL": NORMALS}, ValueError, r"attributes\['NORMAL'\] is normals once more"),
    ({"COLOR_0": np.zeros((COUNT, 3), int)}, ValueError, r"attributes\['COLOR_0'\] are int64, not uint8"),
    ([("_X", np.zeros(COUNT))], TypeError, "attributes is a list, not a mapping")])
def test_errors_name_the_argument(attributes, kind, message):
    with pytest.raises(kind, match=message):
        encoded(attributes, normals=NORMALS)


@pytest.mark.parametrize("bits, message", [
    ({"_Y": 3}, "bits has '_Y', which is no attribute"), ({"_X": 31}, r"bits\['_X'\] is 31, not 0 to 30"),
    ({"POSITION": 3}, "bits has 'POSITION', whose bits are quantization_bits"), ({"NORMAL": 1}, r"bits\['NORMAL'\] is 1, not 0 or 2"),
    ({"_I": 8}, r"attributes\['_I'\] has integers, which are kept exactly"), (0, "bits is a int, not a mapping")])
def test_errors_of_bits(bits, message):
    with pytest.raises((TypeError, ValueError), match=message):
        encoded({"_X": np.zeros(COUNT), "_I": np.zeros(COUNT, np.uint8)}, normals=NORMALS, bits=bits)


def test_a_decoded_mesh_can_be_encoded():
    given = {"JOINTS_0": JOINTS, "WEIGHTS_0": WEIGHTS, "_X": RANDOM.random((COUNT, 3)), "_EXACT": np.float32(RANDOM.random(COUNT))}
    stream = gltf_psplit.encode(POINTS, FACES, 11, preserve_order=True, normals=NORMALS, tex_coord=TEX_COORD, normal_bits=8,
                                attributes=given, bits={"_X": 9, "_EXACT": 0})
    mesh = gltf_psplit.decode(stream)
    assert gltf_psplit.encode(mesh, preserve_order=True) == stream
    # Where other bits are asked for, they are taken.
    coarse = gltf_psplit.decode(gltf_psplit.encode(mesh, quantization_bits=8, bits={"_EXACT": 5}, preserve_order=True))
    assert {name: coarse.attributes[name].bits for name in coarse} == {
        "POSITION": 8, "NORMAL": 8, "TEXCOORD_0": 12, "JOINTS_0": 0, "WEIGHTS_0": 12, "_X": 9, "_EXACT": 5}
    # Values that were moved off their grid get another.
    mesh.points[:] *= np.pi
    moved = gltf_psplit.decode(gltf_psplit.encode(mesh, preserve_order=True)).attributes["POSITION"]
    assert moved.bits == 14 and np.abs(moved.values - mesh.points).max() <= 0.51 * moved.range / (2**14 - 1)
    # One attribute may be handed on, with its grid.
    alone = encoded({"_X": mesh.attributes["_X"]})
    assert alone.attributes["_X"].bits == 9 and np.array_equal(alone["_X"], mesh["_X"])


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_decoded_meshes_are_encoded_without_loss():
    """Of any grid: the last place of some is decoded as a value beyond the grid."""
    points, faces, normals, tex_coord = torus(6, 8)
    for seed in range(40):
        random = np.random.default_rng(seed)
        count, bits = len(points), random.integers(2, 17, 5)
        weights = random.random((count, 4)) + 1e-3
        stream = gltf_psplit.encode(
            random.random((count, 3)) * random.random() * 100 - 20, faces, bits[0], preserve_order=True, normals=normals,
            tex_coord=random.random((count, 2)) - 0.5, normal_bits=bits[1], texcoord_bits=bits[2],
            attributes={"WEIGHTS_0": weights / weights.sum(axis=1, keepdims=True), "_X": random.random((count, 5)) * 1e6,
                        "_CONSTANT": np.full(count, np.pi), "_JOINTS": random.integers(-300, 300, (count, 4))},
            bits={"WEIGHTS_0": bits[3], "_X": bits[4]})
        assert gltf_psplit.encode(gltf_psplit.decode(stream), preserve_order=True) == stream, seed


def test_meshes_of_the_corpus_can_be_encoded_again(corpus):
    seen = 0
    for path in sorted(corpus.rglob("*.drc")):
        try:
            mesh = gltf_psplit.decode(path)
        except gltf_psplit.UnsupportedError:
            continue
        if mesh.coding.startswith("cloud-"):
            again = gltf_psplit.decode(gltf_psplit.encode(mesh, preserve_order=True))
            assert again.coding == "cloud-sequential" and set(again) == set(mesh)
            assert all(again[name].tobytes() == mesh[name].tobytes() for name in mesh), path
            continue
        again = gltf_psplit.decode(gltf_psplit.encode(mesh, preserve_order=True))
        assert np.array_equal(again.faces, mesh.faces) and set(again) == set(mesh)
        for name in mesh:
            assert again[name].dtype == mesh[name].dtype and again[name].tobytes() == mesh[name].tobytes(), (path, name)
        seen += 1
    assert seen > 3


def test_primitives_of_assets_can_be_encoded():
    for name in ("patches.glb", "seams.glb"):
        primitive = gltf_psplit.load(SAMPLES / name).meshes[0].primitives[0]
        again = gltf_psplit.decode(gltf_psplit.encode(primitive, quantization_bits=0, preserve_order=True))
        assert set(again) == set(primitive) and np.array_equal(again.points, primitive.points)


def test_primitives_of_points_can_be_encoded():
    points = b"".join(np.float32(row).tobytes() for row in ([0, 0, 0], [1, 0, 0], [0, 1, 0]))
    asset = {"asset": {"version": "2.0"}, "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
             "bufferViews": [{"buffer": 0, "byteLength": 36}], "meshes": [{"primitives": [
                 {"attributes": {"POSITION": 0}, "mode": mode} for mode in (0, 1)]}],
             "buffers": [{"byteLength": 36, "uri": "data:;base64," + base64.b64encode(points).decode()}]}
    asset["accessors"][0].update(min=[0, 0, 0], max=[1, 1, 0])
    asset["accessors"].append({**asset["accessors"][0], "count": 2, "max": [1, 0, 0]})
    asset["meshes"][0]["primitives"][1]["attributes"]["POSITION"] = 1
    dots, lines = gltf_psplit.load(json.dumps(asset).encode()).meshes[0].primitives
    assert dots.coding == "plain"
    again = gltf_psplit.decode(gltf_psplit.encode(dots, quantization_bits=0))
    assert again.coding == "cloud-sequential" and np.array_equal(again.points, dots.points)
    with pytest.raises(NotImplementedError, match="lines"):
        gltf_psplit.encode(lines)
    with pytest.raises(NotImplementedError, match="no patches"):
        gltf_psplit.encode_container(dots)


def test_a_mesh_of_points_by_hand():
    mesh = gltf_psplit.Mesh("by hand", COUNT, np.empty((0, 3), np.uint32), [("POSITION", None, POINTS), ("NORMAL", None, NORMALS)])
    again = gltf_psplit.decode(gltf_psplit.encode(mesh, preserve_order=True))
    assert again.coding == "cloud-sequential" and list(again) == ["POSITION", "NORMAL"]
    assert np.abs(again.points - POINTS).max() < 1e-3


def test_positions_of_a_mesh():
    exact = gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, 0))
    grid = gltf_psplit.decode(gltf_psplit.encode(exact, quantization_range=8.0, quantization_origin=[-4, -4, -4])).attributes["POSITION"]
    assert grid.bits == 14 and grid.range == 8 and grid.origin.tolist() == [-4, -4, -4]
    # Integers of glTF that stand for fractions.
    exact.attributes["POSITION"].values = np.abs(exact.points * 10000).astype(np.uint16)
    exact.attributes["POSITION"].normalized = True
    position = gltf_psplit.decode(gltf_psplit.encode(exact, preserve_order=True)).attributes["POSITION"]
    assert position.normalized and position.values.dtype == np.uint16 and np.array_equal(position.values, exact.points)


def test_what_is_no_mesh_to_encode(stream):
    mesh = gltf_psplit.decode(stream)
    with pytest.raises(ValueError, match="faces is given, and points is a Mesh"):
        gltf_psplit.encode(mesh, mesh.faces)
    with pytest.raises(ValueError, match="normals is the mesh's NORMAL once more"):
        gltf_psplit.encode(mesh, normals=mesh.normals)
    with pytest.raises(ValueError, match="the mesh's POSITION has places on a grid"):
        gltf_psplit.encode(gltf_psplit.decode(stream, quantized=True))


def test_containers_have_any_attribute():
    given = {"JOINTS_0": JOINTS, "WEIGHTS_0": WEIGHTS, "_MATRIX": RANDOM.random((COUNT, 9)), "TEXCOORD_1": TEX_COORD}
    container = gltf_psplit.encode_container(POINTS, FACES, patches=3, attributes=given)
    mesh = gltf_psplit.decode_container(*container)
    assert list(container.attributes) == ["POSITION", *given]
    assert {name: of["type"] for name, of in container.accessors.items()} == {
        "POSITION": "VEC3", "JOINTS_0": "VEC4", "WEIGHTS_0": "VEC4", "_MATRIX": "MAT3", "TEXCOORD_1": "VEC2", "indices": "SCALAR"}
    assert {tuple(row) for row in mesh["JOINTS_0"].tolist()} == {tuple(row) for row in JOINTS.tolist()}
    assert gltf_psplit.encode_container(gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, 0)), patches=2).data
    with pytest.raises(ValueError, match="_X has 5 numbers"):
        gltf_psplit.encode_container(POINTS, FACES, attributes={"_X": np.zeros((COUNT, 5))})


def test_names_of_a_stranger():
    """Two attributes with one name, and names that are no text, are named by their places."""
    data = np.random.default_rng(2).random(COUNT)
    stream = gltf_psplit.encode(POINTS, FACES, attributes={"_AA": data, "_BB": data, "faces": data})
    assert list(gltf_psplit.decode(stream)) == ["POSITION", "_AA", "_BB", "_GENERIC_2"]
    assert list(gltf_psplit.decode(stream.replace(b"_BB", b"_AA"))) == ["POSITION", "_AA", "_GENERIC_1", "_GENERIC_2"]
    assert list(gltf_psplit.decode(stream.replace(b"_AA", b"\xff\xfe_", 1))) == ["POSITION", "_GENERIC_0", "_BB", "_GENERIC_2"]


def test_names_are_those_of_dracopy():
    dracopy = pytest.importorskip("DracoPy")
    weights, joints = WEIGHTS.astype(np.float32), JOINTS.astype(np.uint8)
    theirs = dracopy.encode(POINTS, FACES, preserve_order=True, generic_attributes={"joints": joints, "weights": weights})
    mesh = gltf_psplit.decode(theirs)
    assert np.array_equal(mesh["joints"], joints) and np.array_equal(mesh["weights"], weights)
    ours = dracopy.decode(gltf_psplit.encode(POINTS, FACES, preserve_order=True, attributes={"joints": joints, "weights": weights},
                                             bits={"weights": 0}))
    assert np.array_equal(ours.get_attribute_by_name("joints")["data"], joints)
    assert np.array_equal(ours.get_attribute_by_name("weights")["data"], weights)
    # What it wrote can be encoded again.
    again = gltf_psplit.decode(gltf_psplit.encode(mesh, preserve_order=True))
    assert all(np.array_equal(again[name], mesh[name]) for name in mesh) and set(again) == set(mesh)
