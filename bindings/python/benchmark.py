#!/usr/bin/env python3
"""Measures gltf_psplit.decode beside libdraco in Python, and beside psplit's decoder in C++:

  bindings/python/benchmark.py [--build FOLDER] [--mesh FILE.ply[.gz]] [--rounds N] [--level L]

--build is a build with -DPSPLIT_BUILD_PYTHON=ON and the target draco_reference, whose python/ has both modules. The mesh is
encoded with Debian's draco_encoder. Rows:

  psplit        gltf_psplit.decode
  C++           psplit's decode_geometry, without Python
  DracoPy       libdraco in DracoPy's manner: each value is copied into a std::vector, Cython makes a list of Python's
                numbers of each vector, and numpy an array of each list
  libdraco      the same, but numpy copies the vectors: the best that a binding with vectors can do

DracoPy itself is not in Debian, so bench/draco_reference_module.cpp does what it does. All rows give positions and faces, on
one thread. They take turns, and the least processor time of all rounds counts: other programs only ever add to it. Results
are freed between the measurements.
"""
import argparse
import gzip
import pathlib
import subprocess
import sys
import tempfile
import time

root = pathlib.Path(__file__).resolve().parents[2]
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--build", type=pathlib.Path, default=root / "build" / "release")
parser.add_argument("--mesh", type=pathlib.Path, default=root.parent / "shared/corpus/mesh/dra/dragon_vrip.ply.gz")
parser.add_argument("--rounds", type=int, default=15)
parser.add_argument("--level", type=int, default=7, help="draco_encoder's compression level")
options = parser.parse_args()
sys.path.insert(0, str(options.build / "python"))
import draco_reference
import gltf_psplit
import numpy as np


def encoded(mesh):
    """The stream of draco_encoder with positions of 14 bits."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        content = mesh.read_bytes()
        (folder / "in.ply").write_bytes(gzip.decompress(content) if mesh.suffix == ".gz" else content)
        subprocess.run(["draco_encoder", "-i", folder / "in.ply", "-o", folder / "out.drc", "-qp", "14",
                        "-cl", str(options.level), "--skip", "NORMAL", "--skip", "TEX_COORD", "--skip", "GENERIC"],
                       check=True, capture_output=True)
        return (folder / "out.drc").read_bytes()


def pieces(mesh, face_count, count):
    """Streams of consecutive faces, which are connected: Edgebreaker walks from a face to its neighbour."""
    made = []
    for first in np.linspace(0, len(mesh.faces) - face_count, count).astype(int):
        used, faces = np.unique(mesh.faces[first:first + face_count], return_inverse=True)
        made.append(gltf_psplit.encode(mesh.points[used], faces.reshape(-1, 3), compression_level=options.level))
    return made


def dracopy(stream):
    faces, points = draco_reference.decode_to_lists(stream)
    return np.array(faces).reshape(-1, 3), np.array(points).reshape(-1, 3)


def seconds(call, streams):
    spent = 0.0
    for stream in streams:
        start = time.thread_time()
        result = call(stream)
        spent += time.thread_time() - start
        del result
    return spent


ways = {"psplit": gltf_psplit.decode, "C++": draco_reference.decode_in_cpp, "DracoPy": dracopy,
        "libdraco": draco_reference.decode_to_arrays}


def measure(what, streams):
    for stream in streams[:3]:
        mesh, (faces, points) = gltf_psplit.decode(stream), draco_reference.decode_to_arrays(stream)
        assert np.array_equal(mesh.faces, faces) and mesh.points.tobytes() == points.tobytes()
    least = {way: float("inf") for way in ways}
    for _ in range(options.rounds):
        for way, call in ways.items():
            least[way] = min(least[way], seconds(call, streams))
    print(f"{what}, {sum(map(len, streams)) // len(streams):,} bytes")
    for way, spent in least.items():
        print(f"  {way:9} {spent / len(streams) * 1e3:10.3f} ms  {spent / least['psplit']:6.2f} times psplit")


stream = encoded(options.mesh)
mesh = gltf_psplit.decode(stream)
measure(f"{options.mesh.name.split('.')[0]}: {len(mesh.faces):,} faces, {mesh.point_count:,} points", [stream])
measure("A piece of 2,000 faces, the mean of 100", pieces(mesh, 2000, 100))
