"""Many meshes at once, and the interpreter's lock."""
import concurrent.futures
import multiprocessing
import sys
import threading

import gltf_psplit
import numpy as np
import pytest
from conftest import SAMPLES, torus


def streams(count):
    made = []
    for i in range(count):
        points, faces, *_ = torus(5 + i, 8)
        made.append(gltf_psplit.encode(points, faces))
    return made


def expect_equal(mesh, expected):
    assert np.array_equal(mesh.faces, expected.faces) and np.array_equal(mesh.points, expected.points)


@pytest.mark.parametrize("threads", [0, 1, 2, 7])
def test_decode_many(threads):
    data = streams(20)
    meshes = gltf_psplit.decode_many(data, threads=threads)
    assert len(meshes) == len(data)
    for mesh, stream in zip(meshes, data):
        expect_equal(mesh, gltf_psplit.decode(stream))


def test_decode_many_takes_what_decode_takes(tmp_path):
    stream, = streams(1)
    (tmp_path / "a.drc").write_bytes(stream)
    items = [stream, bytearray(stream), tmp_path / "a.drc", str(tmp_path / "a.drc"), SAMPLES / "patches.glb"]
    meshes = gltf_psplit.decode_many(iter(items))
    for mesh in meshes[:4]:
        expect_equal(mesh, gltf_psplit.decode(stream))
    expect_equal(meshes[4], gltf_psplit.decode(SAMPLES / "patches.glb"))
    assert gltf_psplit.decode_many([]) == []
    assert gltf_psplit.decode_many([stream], quantized=True)[0].points.dtype == np.int32


def test_errors_of_items(tmp_path):
    good, bad = streams(1)[0], streams(1)[0][:50]
    items = [good, bad, b"no", tmp_path / "missing.drc", 5, good]
    results = gltf_psplit.decode_many(items, return_exceptions=True)
    assert [type(result).__name__ for result in results] == \
        ["Mesh", "InvalidInputError", "InvalidInputError", "FileNotFoundError", "TypeError", "Mesh"]
    with pytest.raises(gltf_psplit.InvalidInputError):
        gltf_psplit.decode_many(items)
    with pytest.raises(FileNotFoundError):
        gltf_psplit.decode_many(items[3:])
    with pytest.raises(ValueError, match="negative"):
        gltf_psplit.decode_many([good], threads=-1)


def test_calls_from_many_threads():
    data = streams(8)
    expected = [gltf_psplit.decode(stream) for stream in data]
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for mesh, i in [(pool.submit(gltf_psplit.decode, data[i % 8]), i % 8) for i in range(400)]:
            expect_equal(mesh.result(), expected[i])


@pytest.mark.parametrize("call, holds_it", [
    (gltf_psplit.decode, False), (lambda data: gltf_psplit.decode_many([data, data]), False),
    (lambda data: gltf_psplit.decode(data, out={}), False), (lambda data: sum(range(100000)), True)])
def test_the_lock_is_released(large_stream, call, holds_it):
    """No other thread is let in for 100 seconds, unless the call releases the lock. It has a second to come in."""
    started, finished, seen = threading.Event(), threading.Event(), []

    def work():
        started.set()
        for _ in range(30):
            call(large_stream)
        finished.set()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(100)
    try:
        thread = threading.Thread(target=work)
        thread.start()
        started.wait()
        seen.append(finished.is_set())
        thread.join()
    finally:
        sys.setswitchinterval(interval)
    assert seen == [holds_it]


def test_processes_that_are_forked():
    data = streams(4)
    expected = gltf_psplit.decode_many(data)  # the parent has threads
    with multiprocessing.get_context("fork").Pool(2) as pool:
        for meshes in pool.map_async(gltf_psplit.decode_many, [data] * 4).get(60):
            for mesh, other in zip(meshes, expected):
                expect_equal(mesh, other)


def test_release_scratch(large_stream):
    gltf_psplit.decode(large_stream)
    gltf_psplit.release_scratch()
    assert len(gltf_psplit.decode(large_stream).faces) == 500000
