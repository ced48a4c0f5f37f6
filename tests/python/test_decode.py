"""gltf_psplit.decode gives libdraco's values, in numpy arrays."""
import copy
import gc
import mmap
import os
import pathlib
import pickle

import gltf_psplit
import numpy as np
import pytest
from conftest import encode_with_draco, expect_libdraco, torus
from gltf_psplit import _errors

POINTS, FACES, NORMALS, TEX_COORD = torus(20, 30)


def test_result_is_that_of_libdraco(reference, stream):
    mesh = gltf_psplit.decode(stream)
    assert list(mesh) == ["POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"]
    assert mesh.coding == "edgebreaker" and len(mesh.faces) > 0
    expect_libdraco(reference, mesh, stream)


@pytest.mark.parametrize("level", [0, 1, 5, 7, 10])
def test_streams_of_draco_encoder(reference, tmp_path, level):
    stream = encode_with_draco(tmp_path, "-cl", str(level), points=POINTS, faces=FACES)
    mesh = gltf_psplit.decode(stream)
    assert len(mesh.faces) == len(FACES)
    expect_libdraco(reference, mesh, stream)


@pytest.mark.parametrize("options", [["-cl", "0"], ["-cl", "7"], ["-cl", "10", "-qp", "14"], ["-cl", "0", "-qp", "0"]])
def test_point_clouds(reference, tmp_path, options):
    colors = np.arange(POINTS.size, dtype=np.uint8).reshape(-1, 3)
    stream = encode_with_draco(tmp_path, "-point_cloud", *options, points=POINTS, colors=colors)
    mesh = gltf_psplit.decode(stream)
    assert mesh.coding.startswith("cloud-")
    assert mesh.faces.shape == (0, 3) and mesh.points.shape == POINTS.shape and mesh.colors.shape == colors.shape
    expect_libdraco(reference, mesh, stream)


def test_quantized_values_are_places_on_the_grid(reference, stream):
    mesh, values = gltf_psplit.decode(stream, quantized=True), gltf_psplit.decode(stream)
    for name in ("POSITION", "TEXCOORD_0"):
        attribute = mesh.attributes[name]
        assert attribute.are_integers and attribute.values.dtype == np.int32 and attribute.origin.dtype == np.float32
        assert attribute.values.min() >= 0 and attribute.values.max() < 2**attribute.bits
        step = np.float32(attribute.range) / np.float32(2**attribute.bits - 1)
        assert np.array_equal(attribute.values.astype(np.float32) * step + attribute.origin, values[name])
    normal = mesh.attributes["NORMAL"]
    assert normal.values.shape == (mesh.point_count, 2) and normal.bits == 10 and normal.origin is None
    assert np.array_equal(mesh.colors, values.colors) and mesh.colors.dtype == np.int32
    expect_libdraco(reference, mesh, stream, quantized=True)


def test_corpus(reference, corpus):
    decoded = 0
    for path in sorted(corpus.rglob("*.drc")):
        try:
            mesh = gltf_psplit.decode(path)
        except gltf_psplit.UnsupportedError as error:
            assert "bitstream" in str(error)  # a point cloud
            continue
        expect_libdraco(reference, mesh, path.read_bytes())
        decoded += 1
    assert decoded > 3


def test_older_bitstreams():
    """A sequential mesh of bitstream 2.1, which libdraco decodes where it is built in."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]], np.float32)
    stream = b"DRACO" + bytes([2, 1, 1, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 1, 0, 1, 2, 1, 1, 0, 9, 3, 0, 5, 0]) + positions.tobytes()
    try:
        mesh = gltf_psplit.decode(stream)
    except gltf_psplit.UnsupportedError as error:
        assert "a build with the encoder and libdraco decodes older ones" in str(error)
        pytest.skip("the package has no libdraco")
    assert np.array_equal(mesh.points, positions) and mesh.faces.tolist() == [[0, 1, 2]] and mesh.coding == "sequential"
    assert mesh.attributes["POSITION"].unique_id == 5 and len(gltf_psplit.decode_many([stream])[0].faces) == 1
    faces, points = np.zeros((1, 3), np.uint32), np.zeros((3, 3), np.float32)
    given = gltf_psplit.decode(stream, out={"faces": faces, "POSITION": points})
    assert given.points is points and np.array_equal(points, positions) and faces.tolist() == [[0, 1, 2]]
    wide = np.full((3, 5), -1, np.float32)
    gltf_psplit.decode(stream, out={5: wide[:, 1:4]})
    assert np.array_equal(wide[:, 1:4], positions) and (wide[:, [0, 4]] == -1).all()
    with pytest.raises(gltf_psplit.InvalidInputError):
        gltf_psplit.decode(stream[:-1])


def test_description_of_attributes(stream):
    mesh = gltf_psplit.decode(stream)
    position, color = mesh.attributes["POSITION"], mesh.attributes["COLOR_0"]
    assert (position.bits, color.bits) == (14, 0)
    assert position.origin.shape == (3,) and position.range > 0 and color.origin is None
    assert color.values.dtype == np.uint8 and color.normalized and not position.normalized
    assert np.array_equal(mesh.by_id(position.unique_id), mesh.points)
    with pytest.raises(KeyError):
        mesh.by_id(77)
    with pytest.raises(KeyError):
        mesh["TANGENT"]
    assert mesh.get("TANGENT") is None and "NORMAL" in mesh and len(mesh) == 4
    assert set(dict(mesh)) == set(mesh.attributes)
    assert mesh.normals is mesh["NORMAL"] and mesh.tex_coord is mesh["TEXCOORD_0"] and mesh.colors is mesh["COLOR_0"]


def test_metadata(tmp_path):
    (tmp_path / "in.obj").write_text("o part\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\no other\nf 1 3 4\n")
    out = tmp_path / "out.drc"
    status = os.system(f"draco_encoder --metadata -i {tmp_path}/in.obj -o {out} >/dev/null")
    if status != 0:
        pytest.skip("draco_encoder is not installed")
    mesh = gltf_psplit.decode(out)
    described = [attribute for attribute in mesh.attributes.values() if attribute.metadata is not None]
    assert [attribute.metadata["name"] for attribute in described] == [b"sub_obj"]
    assert set(described[0].metadata.entries) == {"name", "part", "other"}
    assert described[0].metadata.parts == {} and "name" in described[0].metadata


# Where the bytes are.


@pytest.mark.parametrize("kind", [bytes, bytearray, memoryview, lambda b: np.frombuffer(b, np.uint8),
                                  lambda b: np.frombuffer(b + bytes(-len(b) % 4), np.uint32)])
def test_kinds_of_bytes(stream, kind):
    assert np.array_equal(gltf_psplit.decode(kind(stream)).points, gltf_psplit.decode(stream).points)


def test_mapped_file(stream, tmp_path):
    (tmp_path / "a.drc").write_bytes(stream)
    with open(tmp_path / "a.drc", "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
        mesh = gltf_psplit.decode(mapped)
    assert np.array_equal(mesh.points, gltf_psplit.decode(stream).points)


@pytest.mark.parametrize("name", ["a.drc", "Käfer 甲虫 🪲.drc", "no_extension"])
def test_paths(stream, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(stream)
    for named in (path, str(path)):
        assert np.array_equal(gltf_psplit.decode(named).faces, gltf_psplit.decode(stream).faces)


def test_bytes_may_change_afterwards(stream):
    data = bytearray(stream)
    mesh = gltf_psplit.decode(data)
    before = mesh.points.copy()
    data[:] = bytes(len(data))
    data.clear()  # a buffer that is still held could not be resized
    assert np.array_equal(mesh.points, before)


# Whose memory it is.


def test_arrays_outlive_the_mesh(stream):
    mesh = gltf_psplit.decode(stream)
    points, faces, expected = mesh.points, mesh.faces[5:], (mesh.points.copy(), mesh.faces[5:].copy())
    del mesh
    gc.collect()
    rest = [gltf_psplit.decode(stream) for _ in range(20)]  # takes memory that was given back
    assert np.array_equal(points, expected[0]) and np.array_equal(faces, expected[1])
    assert all(not np.shares_memory(points, other.points) for other in rest)


def test_arrays_are_writable_and_apart(stream):
    mesh = gltf_psplit.decode(stream)
    for array in [mesh.faces, *dict(mesh).values()]:
        assert array.flags.writeable and array.flags.c_contiguous and array.flags.aligned
    before = gltf_psplit.decode(stream)
    mesh.points[:] = 7
    assert np.array_equal(before.normals, mesh.normals) and (mesh.points == 7).all()
    assert not (before.points == 7).all()


def test_memory_is_given_back(large_stream):
    def resident():
        return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    if not pathlib.Path("/proc/self/statm").exists():
        pytest.skip("no /proc")
    for _ in range(3):
        gltf_psplit.decode(large_stream)
    before = resident()
    for _ in range(30):
        gltf_psplit.decode(large_stream)
    result_bytes = 500 * 500 * (2 * 12 + 12)
    assert resident() - before < 10 * result_bytes


def test_meshes_can_be_copied_and_sent(stream):
    mesh = gltf_psplit.decode(stream)
    for copied in (copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh))):
        assert np.array_equal(copied.points, mesh.points) and np.array_equal(copied.faces, mesh.faces)
        assert copied.attributes["POSITION"].bits == 14


# out


def test_out(stream):
    expected = gltf_psplit.decode(stream)
    normal_id = expected.attributes["NORMAL"].unique_id
    out = {"faces": np.empty_like(expected.faces), "POSITION": np.empty_like(expected.points),
           normal_id: np.empty_like(expected.normals)}
    mesh = gltf_psplit.decode(stream, out=out)
    assert mesh.faces is out["faces"] and mesh.points is out["POSITION"] and mesh.normals is out[normal_id]
    for name in expected:
        assert np.array_equal(mesh[name], expected[name])
    assert np.array_equal(mesh.faces, expected.faces)


def test_out_of_a_part_of_an_array(stream):
    expected = gltf_psplit.decode(stream)
    whole = np.zeros((expected.point_count + 10, 3), np.float32)
    mesh = gltf_psplit.decode(stream, out={"POSITION": whole[5:-5]})
    assert np.array_equal(whole[5:-5], expected.points) and not whole[:5].any() and not whole[-5:].any()
    assert np.shares_memory(mesh.points, whole)


def vertex_buffer(mesh, **more):
    """An interleaved buffer with a field for each attribute, and bytes that belong to none."""
    fields = [(name, mesh[name].dtype, mesh[name].shape[1]) for name in mesh]
    return np.full(mesh.point_count, 0xAB, [("before", "u1", 5), *fields, ("after", "u1", 3)], **more)


@pytest.mark.parametrize("quantized", [False, True])
def test_out_of_an_interleaved_buffer(stream, quantized):
    expected = gltf_psplit.decode(stream, quantized=quantized)
    buffer = vertex_buffer(expected)
    mesh = gltf_psplit.decode(stream, quantized=quantized, out={name: buffer[name] for name in expected})
    for name in expected:
        assert np.array_equal(buffer[name], expected[name]) and np.shares_memory(mesh[name], buffer)
    assert (buffer["before"] == 0xAB).all() and (buffer["after"] == 0xAB).all()


def test_out_of_columns_of_a_larger_array(large_stream):
    expected = gltf_psplit.decode(large_stream)
    wide = np.full((2 * expected.point_count, 8), -1, np.float32)
    mesh = gltf_psplit.decode(large_stream, out={"POSITION": wide[::2, 4:7]})
    assert np.array_equal(wide[::2, 4:7], expected.points) and np.shares_memory(mesh.points, wide)
    wide[::2, 4:7] = -1
    assert (wide == -1).all()


def test_out_of_arrays_that_share_memory(stream):
    expected = gltf_psplit.decode(stream)
    wide = np.empty((expected.point_count, 5), np.float32)
    with pytest.raises(gltf_psplit.Error, match=r"out\['POSITION'\] and out\['NORMAL'\] share memory"):
        gltf_psplit.decode(stream, out={"POSITION": wide[:, :3], "NORMAL": wide[:, 2:]})
    one_row = np.lib.stride_tricks.as_strided(wide, expected.points.shape, (8, 4))
    with pytest.raises(gltf_psplit.Error, match=r"out\['POSITION'\] has rows that share memory"):
        gltf_psplit.decode(stream, out={"POSITION": one_row})


def test_faces_have_no_gaps(stream):
    expected = gltf_psplit.decode(stream)
    wide = np.empty((len(expected.faces), 4), np.uint32)
    with pytest.raises(gltf_psplit.Error, match="faces have gaps"):
        gltf_psplit.decode(stream, out={"faces": wide[:, :3]})


@pytest.mark.parametrize("out", [
    {"POSITION": np.empty((3, 3), np.float32)}, {"POSITION": np.empty((1271, 3), np.float64)},
    {"POSITION": np.empty(3 * 1271, np.float32)}, {"TANGENT": np.empty((1271, 4), np.float32)},
    {"faces": np.empty((1, 3), np.uint32)}, {99: np.empty((1271, 3), np.float32)}])
def test_out_that_does_not_fit(stream, out):
    with pytest.raises(gltf_psplit.Error, match="out") as error:
        gltf_psplit.decode(stream, out=out)
    assert error.value.code == "usage"


@pytest.mark.parametrize("make, fault", [
    (lambda a: np.asfortranarray(a), "side by side"), (lambda a: a.astype(">f4"), "byte order"), (lambda a: a[::-1], "negative"),
    (lambda a: a[:, ::-1], "negative")])
def test_out_that_cannot_be_written(stream, make, fault):
    with pytest.raises(gltf_psplit.Error, match=r"out\['POSITION'\] .*" + fault) as error:
        gltf_psplit.decode(stream, out={"POSITION": make(gltf_psplit.decode(stream).points)})
    assert error.value.code == "usage"


def test_out_that_is_read_only_or_no_array(stream):
    array = gltf_psplit.decode(stream).points
    array.flags.writeable = False
    with pytest.raises(ValueError, match="writable"):
        gltf_psplit.decode(stream, out={"POSITION": array})
    with pytest.raises(TypeError, match="neither a name"):
        gltf_psplit.decode(stream, out={1.5: gltf_psplit.decode(stream).points})
    with pytest.raises(TypeError, match="POSITION"):
        gltf_psplit.decode(stream, out={"POSITION": [1, 2, 3]})


# The faults.


def test_every_truncation(stream):
    for length in range(len(stream)):
        if length > 300 and length % 37 != 0 and length < len(stream) - 20:
            continue
        with pytest.raises(gltf_psplit.InvalidInputError):
            gltf_psplit.decode(stream[:length])


def test_changed_bytes_are_refused_or_decoded(stream):
    random = np.random.default_rng(1)
    refused = 0
    for _ in range(2000):
        data = bytearray(stream)
        for place in random.integers(0, len(data), 3):
            data[place] = random.integers(0, 256)
        try:
            mesh = gltf_psplit.decode(data)
            assert len(mesh.faces) == 0 or mesh.faces.max() < mesh.point_count
        except gltf_psplit.Error as error:
            assert error.code in ("invalid_input", "unsupported")
            refused += 1
    assert 0 < refused


@pytest.mark.parametrize("data", [b"", b"D", b"DRACO", b"ply\n", bytes(100), b"\x1f\x8b"])
def test_what_is_no_draco(data):
    with pytest.raises(gltf_psplit.InvalidInputError):
        gltf_psplit.decode(data)


def test_newer_bitstreams_are_unsupported(stream):
    data = bytearray(stream)
    data[5] = 3  # 3.2
    with pytest.raises(gltf_psplit.UnsupportedError, match="3.2") as error:
        gltf_psplit.decode(data)
    assert error.value.code == "unsupported" and error.value.patch is None
    assert isinstance(error.value, gltf_psplit.Error) and isinstance(error.value, ValueError)


@pytest.mark.parametrize("data", [None, 3, [1, 2], object()])
def test_what_is_not_bytes(data):
    with pytest.raises(TypeError):
        gltf_psplit.decode(data)


def test_bytes_with_gaps(stream):
    spread = np.repeat(np.frombuffer(stream, np.uint8), 2)
    with pytest.raises(TypeError, match="contiguous"):
        gltf_psplit.decode(spread[::2])


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        gltf_psplit.decode(tmp_path / "missing.drc")


def test_errors_pass_between_processes():
    with pytest.raises(gltf_psplit.Error) as error:
        gltf_psplit.decode(b"DRACO\x02\x01 and more bytes")
    again = pickle.loads(pickle.dumps(error.value))
    assert type(again) is type(error.value) and str(again) == str(error.value) and again.code == error.value.code


def test_a_lack_of_memory_is_a_memory_error():
    error = _errors.error_of("out_of_memory", "out of memory", None, 3, None)
    assert isinstance(error, MemoryError) and isinstance(error, gltf_psplit.OutOfMemoryError)
    assert pickle.loads(pickle.dumps(error)).code == "out_of_memory" and error.mesh == 3
