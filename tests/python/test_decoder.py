"""The package without its encoder: it decodes, and says what it lacks."""
import gltf_psplit
import numpy as np
import pytest
from conftest import SAMPLES, expect_libdraco
from test_asset import parts_of

pytestmark = pytest.mark.decoder


def a_stream():
    """The first patch of a sample, which is an ordinary Draco stream."""
    document, buffer_view = parts_of(SAMPLES / "patches.glb")
    view = document["meshes"][0]["primitives"][0]["extensions"]["PSPLIT_mesh_draco_patches"]["bufferView"]
    data = bytes(buffer_view(view))
    starts = [place for place in range(len(data)) if data.startswith(b"DRACO", place)]
    return data[starts[0]:starts[1]]


def test_streams():
    mesh, other = gltf_psplit.decode_many([a_stream(), a_stream()])
    assert len(mesh.faces) > 0 and np.array_equal(mesh.points, other.points)
    with pytest.raises(gltf_psplit.InvalidInputError):
        gltf_psplit.decode(a_stream()[:-1])


def test_streams_are_those_of_libdraco(reference):
    expect_libdraco(reference, gltf_psplit.decode(a_stream()), a_stream())


def test_what_is_missing_is_named():
    if hasattr(gltf_psplit._native, "encode"):
        pytest.skip("the package has the encoder")
    for call in (lambda: gltf_psplit.encode([[0, 0, 0]] * 3, [[0, 1, 2]]), lambda: gltf_psplit.load(SAMPLES / "patches.glb"),
                 lambda: gltf_psplit.decode(SAMPLES / "patches.glb"),
                 lambda: gltf_psplit.encode_container([[0, 0, 0]] * 3, [[0, 1, 2]], patches=1)):
        with pytest.raises(gltf_psplit.UnsupportedError, match="without its encoder"):
            call()
