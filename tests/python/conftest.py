"""What the tests of the Python package share. ctest runs them with the build's package and with draco_reference, which is
libdraco as a module. For an installed wheel, only tests without the reference run.

With a package that has no encoder, only the tests with the marker "decoder" run.

    PSPLIT_CORPUS  the folder of test assets; tests that need it are skipped without
"""
import os
import pathlib
import subprocess

import gltf_psplit
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SAMPLES = ROOT / "gltf_ext" / "PSPLIT_mesh_draco_patches" / "samples"


def pytest_configure(config):
    config.addinivalue_line("markers", "decoder: needs no encoder")


def pytest_collection_modifyitems(items):
    if hasattr(gltf_psplit._native, "encode"):
        return
    for item in items:
        if item.get_closest_marker("decoder") is None:
            item.add_marker(pytest.mark.skip(reason="the package has no encoder"))


def torus(rows, columns):
    """(points, faces, normals, texture coordinates) of a torus with a seam of texture coordinates."""
    u, v = np.meshgrid(np.arange(columns + 1) / columns, np.arange(rows + 1) / rows)
    a, b = 2 * np.pi * u, 2 * np.pi * v
    normals = np.stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)], -1).reshape(-1, 3)
    points = np.stack([2 * np.cos(a), 2 * np.sin(a), np.zeros_like(a)], -1).reshape(-1, 3) + normals
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1)
    faces = np.concatenate([np.stack([corner, corner + 1, corner + columns + 1], -1),
                            np.stack([corner + 1, corner + columns + 2, corner + columns + 1], -1)])
    return (points.astype(np.float32), faces.astype(np.uint32), normals.astype(np.float32),
            np.stack([u, v], -1).reshape(-1, 2).astype(np.float32))


def write_ply(path, points, faces=None, colors=None):
    columns = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
    if colors is not None:
        columns += [("red", "u1"), ("green", "u1"), ("blue", "u1")]
    rows = np.zeros(len(points), columns)
    for name, column in zip("xyz", points.T):
        rows[name] = column
    if colors is not None:
        for name, column in zip(("red", "green", "blue"), colors.T):
            rows[name] = column
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    header += [f"property {'float' if kind == '<f4' else 'uchar'} {name}" for name, kind in columns]
    body = rows.tobytes()
    if faces is not None:
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        lists = np.zeros(len(faces), [("n", "u1"), ("f", "<i4", 3)])
        lists["n"], lists["f"] = 3, faces
        body += lists.tobytes()
    path.write_bytes("\n".join(header + ["end_header", ""]).encode() + body)


def encode_with_draco(folder, *options, points, faces=None, colors=None):
    """The stream that Debian's draco_encoder makes."""
    write_ply(folder / "in.ply", points, faces, colors)
    command = ["draco_encoder", "-i", folder / "in.ply", "-o", folder / "out.drc", *options]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except FileNotFoundError:
        pytest.skip("draco_encoder is not installed")
    return (folder / "out.drc").read_bytes()


@pytest.fixture(scope="session")
def reference():
    return pytest.importorskip("draco_reference", reason="libdraco as a module is only in the build folder")


@pytest.fixture(scope="session")
def corpus():
    folder = pathlib.Path(os.environ.get("PSPLIT_CORPUS") or ROOT.parent / "shared" / "corpus")
    if not folder.is_dir():
        pytest.skip(f"no corpus in {folder}")
    return folder


@pytest.fixture(scope="session")
def stream():
    """A Draco stream with positions, normals, texture coordinates and colours."""
    points, faces, normals, tex_coord = torus(30, 40)
    colors = (np.abs(normals) * 255).astype(np.uint8)
    return gltf_psplit.encode(points, faces, normals=normals, tex_coord=tex_coord, colors=colors)


@pytest.fixture(scope="session")
def container():
    points, faces, normals, _ = torus(60, 80)
    return gltf_psplit.encode_container(points, faces, patches=5, normals=normals)


@pytest.fixture(scope="session")
def large_stream():
    """A stream that takes tens of milliseconds to decode."""
    points, faces, *_ = torus(500, 500)
    return gltf_psplit.encode(points, faces)


def expect_libdraco(reference, mesh, stream, quantized=False):
    """All arrays of a mesh equal libdraco's, in type, order and bits."""
    faces, attributes = reference.decode(stream, quantized)
    assert mesh.faces.dtype == np.uint32 and np.array_equal(mesh.faces, faces)
    assert len(attributes) == len(mesh.attributes)
    for attribute, (semantic, unique_id, values) in zip(mesh.attributes.values(), attributes):
        if stream[5:7] >= b"\x01\x03":  # older ones have none
            assert attribute.unique_id == unique_id
        if semantic < 4:  # generic ones may have names of their own
            assert attribute.name.lstrip("_").startswith(("POSITION", "NORMAL", "COLOR", "TEXCOORD")[semantic])
        assert attribute.values.shape == values.shape
        if not quantized:
            assert attribute.values.dtype == values.dtype
            assert attribute.values.tobytes() == values.tobytes()
        else:
            assert np.array_equal(attribute.values, values)
