"""gltf_psplit.encode makes streams of libdraco, within the precision that it promises."""
import _thread
import struct
import threading
import time

import gltf_psplit
import numpy as np
import pytest
from conftest import expect_libdraco, torus

POINTS, FACES, NORMALS, TEX_COORD = torus(20, 30)


def distance(mesh, points):
    """The largest distance of a decoded point from the nearest input point."""
    return max(np.abs(points - point).max(axis=1).min() for point in mesh.points[::17])


@pytest.mark.parametrize("level", [0, 1, 7, 10])
@pytest.mark.parametrize("bits", [8, 14, 20])
def test_positions_are_as_exact_as_their_bits(reference, level, bits):
    stream = gltf_psplit.encode(POINTS, FACES, quantization_bits=bits, compression_level=level)
    mesh = gltf_psplit.decode(stream)
    expect_libdraco(reference, mesh, stream)
    assert len(mesh.faces) == len(FACES) and mesh.attributes["POSITION"].bits == bits
    extent = (POINTS.max(axis=0) - POINTS.min(axis=0)).max()
    assert distance(mesh, POINTS) <= 0.51 * extent / (2**bits - 1) + 1e-6


def test_lossless():
    mesh = gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, 0, normals=NORMALS, tex_coord=TEX_COORD, normal_bits=0, texcoord_bits=0))
    rows = {row.tobytes() for row in np.hstack([POINTS, NORMALS, TEX_COORD])}
    # Normals off the octahedron are a generic attribute, as `encode` says, whose name is in the metadata.
    assert {row.tobytes() for row in np.hstack([mesh.points, mesh.normals, mesh.tex_coord])} == rows
    assert mesh.attributes["NORMAL"].metadata["name"] == b"NORMAL"


def test_preserve_order(reference):
    colors = np.arange(4 * len(POINTS), dtype=np.uint16).reshape(-1, 4)
    stream = gltf_psplit.encode(POINTS, FACES, preserve_order=True, colors=colors, quantization_bits=0)
    mesh = gltf_psplit.decode(stream)
    expect_libdraco(reference, mesh, stream)
    assert mesh.coding == "sequential"
    assert np.array_equal(mesh.faces, FACES) and np.array_equal(mesh.points, POINTS) and np.array_equal(mesh.colors, colors)
    assert mesh.colors.dtype == np.uint16


def test_a_chosen_grid():
    stream = gltf_psplit.encode(POINTS, FACES, 12, quantization_range=8.0, quantization_origin=[-4, -4, -4])
    position = gltf_psplit.decode(stream).attributes["POSITION"]
    assert position.origin.tolist() == [-4, -4, -4] and position.range == 8 and position.bits == 12
    # Meshes on one grid fit together: equal points decode to equal bits.
    half = gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES[: len(FACES) // 2], 12, 1, 8.0, (-4, -4, -4)))
    whole = {row.tobytes() for row in gltf_psplit.decode(stream).points}
    assert {row.tobytes() for row in half.points} <= whole


def test_a_range_without_an_origin_and_the_reverse():
    position = gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, quantization_range=16)).attributes["POSITION"]
    assert position.range == 16 and np.array_equal(position.origin, POINTS.min(axis=0))
    position = gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, quantization_origin=(-8, -8, -8))).attributes["POSITION"]
    assert position.origin.tolist() == [-8, -8, -8] and position.range == np.float32((POINTS + 8).max())


def test_metadata_of_the_grid(reference):
    stream = gltf_psplit.encode(POINTS, FACES, 12, 1, 8.0, (-4, -4.5, -4), create_metadata=True)
    mesh = gltf_psplit.decode(stream)
    assert set(mesh.metadata.entries) == {"quantization_bits", "quantization_range", "quantization_origin"}
    assert struct.unpack("<i", mesh.metadata["quantization_bits"]) == (12,)
    assert struct.unpack("<d", mesh.metadata["quantization_range"]) == (8,)
    assert struct.unpack("<3d", mesh.metadata["quantization_origin"]) == (-4, -4.5, -4)
    expect_libdraco(reference, mesh, stream)  # which reads the metadata, too
    plain = gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, 12, 1, 8.0, (-4, -4.5, -4)))
    assert np.array_equal(mesh.points, plain.points) and plain.metadata is None
    fitted = gltf_psplit.decode(gltf_psplit.encode(POINTS, FACES, create_metadata=True))
    assert fitted.metadata.entries == {"quantization_bits": struct.pack("<i", 14)}


def test_points_outside_of_the_grid_are_refused():
    with pytest.raises(gltf_psplit.InvalidInputError, match="outside"):
        gltf_psplit.encode(POINTS, FACES, quantization_range=1.0, quantization_origin=[0, 0, 0])


def test_a_cube_that_has_a_corner_alone():
    points = np.ones((4, 3), np.float32)
    with pytest.raises(gltf_psplit.InvalidInputError, match="outside of the cube whose corner is quantization_origin"):
        gltf_psplit.encode(points, quantization_origin=[2, 2, 2])
    with pytest.raises(gltf_psplit.InvalidInputError, match="outside"):
        gltf_psplit.encode(np.float32([[1, 2, np.nan]]), quantization_origin=[0, 0, 0])
    position = gltf_psplit.decode(gltf_psplit.encode(points, quantization_origin=[1, 1, 1])).attributes["POSITION"]
    assert position.range == 1 and np.array_equal(position.values, points)


@pytest.mark.parametrize("kind", [np.int8, np.int32, np.uint16, np.int64])
def test_integer_points_are_exact(kind):
    points = np.array([[0, 0, 0], [100, 3, 0], [0, 77, 5], [1, 2, 99]], kind)
    faces = [[0, 1, 2], [0, 1, 3], [1, 2, 3]]
    mesh = gltf_psplit.decode(gltf_psplit.encode(points, faces, quantization_bits=2))
    assert {tuple(row) for row in mesh.points.tolist()} == {tuple(map(float, row)) for row in points}


@pytest.mark.parametrize("bits", [None, 8])
def test_integers_of_24_bits_are_exact_and_of_more_are_refused(bits):
    most = 2**24 - 1
    points = np.array([[-most, 0, 7], [most, most - 1, 2**23 + 1], [0, 1, 2**23]])
    for faces in (None, [[0, 1, 2]]):
        mesh = gltf_psplit.decode(gltf_psplit.encode(points, faces, bits, attributes={"_X": points}))
        assert sorted(mesh.points.tolist()) == sorted(points.tolist()) == sorted(mesh["_X"].tolist())
        with pytest.raises(NotImplementedError, match="points has integers from 0 to 16777216: more than 24 bits"):
            gltf_psplit.encode(np.array([[0, 0, 0], [most + 1, 0, 0], [0, 1, 0]]), faces)
        with pytest.raises(NotImplementedError, match="_X.* has integers from 0 to 16777216: more than 24 bits"):
            gltf_psplit.encode(points, faces, attributes={"_X": [0, 1, most + 1]})


def test_lists_and_flat_lists():
    points, faces = [0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2]
    flat = gltf_psplit.encode(points, faces)
    assert flat == gltf_psplit.encode(np.reshape(points, (3, 3)).tolist(), [faces])
    assert len(gltf_psplit.decode(flat).faces) == 1


def test_point_clouds():
    random = np.random.default_rng(1)
    points = random.normal(size=(300, 3)).astype(np.float32)
    colors = random.integers(0, 256, (300, 4), dtype=np.uint8)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    for level, order, bits, coding in ((1, False, 11, "cloud-kd-tree"), (10, False, 14, "cloud-kd-tree"), (0, False, 11, "cloud-sequential"),
                                       (5, True, 11, "cloud-sequential"), (5, False, 0, "cloud-sequential")):
        stream = gltf_psplit.encode(points, quantization_bits=bits, compression_level=level, preserve_order=order, colors=colors, normals=normals,
                                    attributes={"_HEAT": random.random(300, dtype=np.float32)})
        mesh = gltf_psplit.decode(stream)
        assert mesh.coding == coding and len(mesh["POSITION"]) == 300 and {"NORMAL", "_HEAT"} < set(mesh)
        # The colours say which point is which.
        decoded = {row.tobytes(): i for i, row in enumerate(mesh["COLOR_0"])}
        at = [decoded[row.tobytes()] for row in colors]
        assert sorted(at) == list(range(300)) and (coding == "cloud-kd-tree" or at == list(range(300)))
        assert np.abs(mesh["POSITION"][at] - points).max() <= (4e-3 if bits else 0)
        assert np.abs(mesh["NORMAL"][at] - normals).max() < 5e-3
    with pytest.raises(NotImplementedError, match="no patches"):
        gltf_psplit.encode_container(points)
    with pytest.raises(gltf_psplit.InvalidInputError, match="no points"):
        gltf_psplit.encode(np.empty((0, 3), np.float32))


@pytest.mark.parametrize("level", [0, 1])
@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int16])
def test_integer_normals_of_point_clouds(reference, kind, level):
    random = np.random.default_rng(2)
    points, normals = random.integers(0, 99, (50, 3)), random.integers(0, 128, (50, 3)).astype(kind)
    stream = gltf_psplit.encode(points, compression_level=level, attributes={"NORMAL": normals})
    mesh = gltf_psplit.decode(stream)
    expect_libdraco(reference, mesh, stream)
    assert list(mesh) == ["POSITION", "NORMAL"] and mesh.normals.dtype == kind
    expected = np.hstack([points, normals]).tolist()
    assert sorted(np.hstack([mesh.points, mesh.normals]).astype(int).tolist()) == sorted(expected)


def test_more_faces_than_can_be_counted():
    faces = np.broadcast_to(np.uint32([[0, 1, 2]]), (2**32 // 3 + 1, 3))  # in three numbers of memory
    with pytest.raises(ValueError, match="more corners"):
        gltf_psplit.encode(POINTS, faces)


def test_points_that_no_grid_can_hold_are_exact():
    points = POINTS.astype(np.float32)
    points[7, 1] = np.nan
    position = gltf_psplit.decode(gltf_psplit.encode(points, FACES)).attributes["POSITION"]
    assert position.bits == 0
    assert sorted(map(bytes, position.values)) == sorted(map(bytes, points))


def test_patches_by_the_number_of_faces():
    points, faces, *_ = torus(150, 100)  # 30,000 faces
    assert gltf_psplit.encode_container(points, faces).data == gltf_psplit.encode_container(points, faces, patches=2).data


@pytest.mark.parametrize("change", [
    {"points": POINTS[:, :2]}, {"faces": FACES[:, :2]}, {"faces": FACES.astype(float)}, {"faces": -FACES.astype(int)},
    {"faces": FACES + 10**6}, {"normals": NORMALS[1:]}, {"tex_coord": NORMALS}, {"colors": NORMALS[:, :2]},
    {"quantization_bits": 31}, {"quantization_bits": -1}, {"compression_level": 11}, {"compression_level": -1},
    {"quantization_range": 0.0}, {"quantization_origin": [0, 0]}, {"quantization_origin": [0, 0, float("nan")]},
    {"normal_bits": 1}, {"faces": FACES[:0]},
    {"points": POINTS[:0], "faces": FACES[:0]}])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_wrong_arguments(change):
    with pytest.raises(ValueError):
        gltf_psplit.encode(**{"points": POINTS, "faces": FACES, **change})


def test_container(reference, container):
    mesh = gltf_psplit.decode_container(*container)
    assert mesh.coding == "patches" and len(mesh.faces) == 60 * 80 * 2
    assert mesh.point_count == container.accessors["POSITION"]["count"]
    same = gltf_psplit.decode_container(*container, threads=1)
    for name in mesh:
        assert np.array_equal(mesh[name], same[name])
    # One patch has the values of the whole: the grid is the same, and so are the bits.
    points, faces, normals, _ = torus(60, 80)
    whole = gltf_psplit.decode_container(*gltf_psplit.encode_container(points, faces, patches=1, normals=normals))
    assert {row.tobytes() for row in whole.points} == {row.tobytes() for row in mesh.points}
    assert gltf_psplit.encode_container(points, faces, patches=5, normals=normals, threads=1).data == container.data


def test_container_into_given_arrays(container):
    expected = gltf_psplit.decode_container(*container)
    out = {"faces": np.empty_like(expected.faces), "NORMAL": np.empty_like(expected.normals)}
    mesh = gltf_psplit.decode_container(*container, out=out)
    assert mesh.faces is out["faces"] and mesh.normals is out["NORMAL"]
    assert np.array_equal(mesh.faces, expected.faces) and np.array_equal(mesh.normals, expected.normals)
    assert np.array_equal(mesh.points, expected.points)
    wide = np.full((expected.point_count, 7), -1, np.float32)
    gltf_psplit.decode_container(*container, out={"NORMAL": wide[:, :3], "POSITION": wide[:, 4:]})
    assert np.array_equal(wide[:, :3], expected.normals) and np.array_equal(wide[:, 4:], expected.points)
    assert (wide[:, 3] == -1).all()
    with pytest.raises(gltf_psplit.Error, match="shape"):
        gltf_psplit.decode_container(*container, out={"faces": np.empty((1, 3), np.uint32)})


def test_attributes_that_are_not_wanted_may_be_left_out(container):
    mesh = gltf_psplit.decode_container(container.data, {"POSITION": 0}, container.accessors)
    assert list(mesh) == ["POSITION"]


def test_more_patches_than_faces(container):
    points, faces, *_ = torus(3, 3)
    assert len(gltf_psplit.decode_container(*gltf_psplit.encode_container(points, faces, patches=1000)).faces) == len(faces)
    with pytest.raises(ValueError, match="patches"):
        gltf_psplit.encode_container(points, faces, patches=-1)
    with pytest.raises(ValueError, match="negative"):
        gltf_psplit.encode_container(points, faces, patches=2, threads=-1)
    with pytest.raises(ValueError, match="negative"):
        gltf_psplit.decode_container(*container, threads=-1)


def test_a_bare_container_says_what_to_call(container):
    with pytest.raises(gltf_psplit.Error, match="decode_container"):
        gltf_psplit.decode(container.data)


def test_errors_of_containers_name_the_patch(container):
    broken = bytearray(container.data)
    broken[-200:] = bytes(200)
    with pytest.raises(gltf_psplit.InvalidInputError) as error:
        gltf_psplit.decode_container(broken, container.attributes, container.accessors)
    assert error.value.patch is not None and "patch" in str(error.value)


@pytest.mark.parametrize("accessors", [{}, {"POSITION": {"componentType": 5126, "type": "VEC9"}},
                                       {"POSITION": {"componentType": 7, "type": "VEC3"}}, {"POSITION": {"type": "VEC3"}},
                                       {"POSITION": {"componentType": 5126, "type": "VEC3", "count": 3}}])
def test_accessors_that_do_not_fit(container, accessors):
    with pytest.raises(gltf_psplit.Error):
        gltf_psplit.decode_container(container.data, {"POSITION": 0}, accessors)


def test_attributes_that_do_not_exist(container):
    with pytest.raises(gltf_psplit.Error):
        gltf_psplit.decode_container(container.data, {"POSITION": 9}, container.accessors)
    for unique_id, kind in ((-1, ValueError), (2**32, ValueError), ("0", TypeError), (None, TypeError), (0.0, TypeError)):
        with pytest.raises(kind, match=r"attributes\['POSITION'\]"):
            gltf_psplit.decode_container(container.data, {"POSITION": unique_id}, container.accessors)


def test_numbers_of_numpy_describe_attributes(container):
    accessors = {name: {key: np.int64(value) if isinstance(value, int) else value for key, value in accessor.items()}
                 for name, accessor in container.accessors.items()}
    mesh = gltf_psplit.decode_container(container.data, {name: np.uint32(of) for name, of in container.attributes.items()}, accessors)
    assert np.array_equal(mesh.points, gltf_psplit.decode_container(*container).points)


def test_every_truncation_of_a_container(container):
    for length in list(range(0, 200)) + list(range(200, len(container.data), 97)):
        with pytest.raises(gltf_psplit.Error):
            gltf_psplit.decode_container(container.data[:length], container.attributes, container.accessors)


def test_decode_container_decodes_streams_of_gltf(stream):
    expected = gltf_psplit.decode(stream)
    accessors = {"POSITION": {"componentType": 5126, "type": "VEC3", "count": expected.point_count}}
    mesh = gltf_psplit.decode_container(stream, {"POSITION": 0}, accessors, extension="KHR_draco_mesh_compression")
    assert np.array_equal(mesh.points, expected.points) and np.array_equal(mesh.faces, expected.faces)
    with pytest.raises(gltf_psplit.Error, match="extension|none of"):
        gltf_psplit.decode_container(stream, {"POSITION": 0}, accessors, extension="EXT_other")


def test_ctrl_c_stops_encoding():
    points, faces, *_ = torus(1000, 750)

    def seconds():
        """The processor's time, which other processes hardly change."""
        start = time.process_time()
        gltf_psplit.encode_container(points, faces, threads=1)
        return time.process_time() - start

    def seconds_until_interrupted(delay):
        start = time.process_time()
        with pytest.raises(KeyboardInterrupt):
            threading.Timer(delay, _thread.interrupt_main).start()
            seconds()
        return time.process_time() - start

    # It stops after a sixth of the whole. An interrupt that waits for the end takes the whole each time.
    whole = seconds()
    assert any(seconds_until_interrupted(whole / 20) < 0.6 * whole for _ in range(5))
