#!/usr/bin/env python3
"""Measures gltf_psplit beside DracoPy 2.x, beside libdraco in Python, and beside psplit's decoder in C++:

  bindings/python/benchmark.py [--build FOLDER] [--mesh FILE.ply[.gz]] [--rounds N] [--level L]

--build is a build with -DPSPLIT_BUILD_PYTHON=ON and the target draco_reference, whose python/ has both modules. The mesh is
encoded with Debian's draco_encoder. Rows:

  gltf_psplit   gltf_psplit.decode, or encode
  C++           psplit's decode_geometry, without Python
  DracoPy       DracoPy.decode, faces and points, or encode; if it can be imported
  libdraco      libdraco's decoder, whose values numpy copies from vectors: the best that a binding with vectors can do

All rows give positions and faces. They take turns, and the least processor time of all rounds counts: other programs only
ever add to it. Results are freed between the measurements. DracoPy's are compared with gltf_psplit's first.
"""

import argparse
import gzip
import importlib.metadata
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

try:
    import DracoPy
except ImportError:
    DracoPy = None


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
    mesh = DracoPy.decode(stream)
    return mesh.faces, mesh.points


def seconds(call, inputs):
    spent = 0.0
    for given in inputs:
        start = time.process_time()
        result = call(given)
        spent += time.process_time() - start
        del result
    return spent


def measure(what, ways, inputs):
    least = {way: float("inf") for way in ways}
    for _ in range(options.rounds):
        for way, call in ways.items():
            least[way] = min(least[way], seconds(call, inputs))
    print(what)
    for way, spent in least.items():
        print(f"  {way:12} {spent / len(inputs) * 1e3:10.3f} ms  {spent / least['gltf_psplit']:6.2f} times gltf_psplit")


def measure_decoding(what, streams):
    ways = {"gltf_psplit": gltf_psplit.decode, "C++": draco_reference.decode_in_cpp}
    if DracoPy is not None:
        ways["DracoPy"] = dracopy
    ways["libdraco"] = draco_reference.decode_to_arrays
    for stream in streams[:3]:
        mesh = gltf_psplit.decode(stream)
        for faces, points in [way(stream) for name, way in ways.items() if name in ("DracoPy", "libdraco")]:
            assert np.array_equal(mesh.faces, faces) and mesh.points.tobytes() == points.tobytes()
    measure(f"{what}, {sum(map(len, streams)) // len(streams):,} bytes: decode", ways, streams)


def measure_encoding(what, meshes):
    ways = {"gltf_psplit": lambda mesh: gltf_psplit.encode(mesh.points, mesh.faces)}
    if DracoPy is not None:
        ways["DracoPy"] = lambda mesh: DracoPy.encode(mesh.points, mesh.faces)
    sizes = {way: sum(len(call(mesh)) for mesh in meshes) for way, call in ways.items()}
    measure(f"{what}: encode, to {' and '.join(f'{size:,}' for size in sizes.values())} bytes", ways, meshes)


def version_of(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "of an unknown version"


print(f"gltf_psplit {gltf_psplit.__version__}, "
      + ("no DracoPy" if DracoPy is None else f"DracoPy {version_of('DracoPy')}")
      + f", numpy {np.__version__}, Python {sys.version.split()[0]}, processor time, the least of {options.rounds} rounds")
stream = encoded(options.mesh)
mesh = gltf_psplit.decode(stream)
name = f"{options.mesh.name.split('.')[0]}, {len(mesh.faces):,} faces"
streams = pieces(mesh, 2000, 100)
measure_decoding(name, [stream])
measure_decoding("A piece of 2,000 faces, the mean of 100", streams)
measure_encoding(name, [mesh])
measure_encoding("A piece of 2,000 faces, the mean of 100", [gltf_psplit.decode(piece) for piece in streams])
