#!/usr/bin/env python3
"""Measures gltf_psplit beside DracoPy 2.x, beside libdraco in Python, and beside psplit's decoder in C++, and writes
docs/measured/python.md:

  bindings/python/benchmark.py [--build FOLDER] [--mesh FILE.ply[.gz]] [--rounds N] [--level L] [-o FILE]

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
sys.path.insert(0, str(root / "scripts"))
from benchmarks.findings import python_findings
from benchmarks.pages import page, table, write
from benchmarks.ratios import spread_of

kOurs = {"decode": "`gltf_psplit.decode`", "encode": "`gltf_psplit.encode`"}
kPieceFaces, kPieces = 2000, 100

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--build", type=pathlib.Path, default=root / "build" / "release")
parser.add_argument("--mesh", type=pathlib.Path, default=root.parent / "shared/corpus/mesh/dra/dragon_vrip.ply.gz")
parser.add_argument("--rounds", type=int, default=15)
parser.add_argument("--level", type=int, default=7, help="draco_encoder's compression level")
parser.add_argument("-o", "--output", type=pathlib.Path, default=root / "docs/measured/python.md", help="- is stdout")
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


def measure(ways, inputs):
    """The least milliseconds of each way for one input, the mean of the inputs."""
    print(f"{' '.join(ways)}: {len(inputs)} meshes", file=sys.stderr, flush=True)
    rounds = [{way: seconds(call, inputs) for way, call in ways.items()} for _ in range(options.rounds)]
    spreads.extend(spread_of([spent[way] for spent in rounds]) for way in ways)
    return {way: 1e3 * min(spent[way] for spent in rounds) / len(inputs) for way in ways}


def measure_decoding(streams):
    ways = {kOurs["decode"]: gltf_psplit.decode, "psplit in C++": draco_reference.decode_in_cpp}
    if DracoPy is not None:
        ways["`DracoPy.decode`"] = dracopy
    ways["libdraco with numpy"] = draco_reference.decode_to_arrays
    for stream in streams[:3]:
        mesh = gltf_psplit.decode(stream)
        for faces, points in [way(stream) for way in list(ways.values())[2:]]:
            assert np.array_equal(mesh.faces, faces) and mesh.points.tobytes() == points.tobytes()
    return measure(ways, streams)


def encoders():
    ways = {kOurs["encode"]: lambda mesh: gltf_psplit.encode(mesh.points, mesh.faces)}
    if DracoPy is not None:
        ways["`DracoPy.encode`"] = lambda mesh: DracoPy.encode(mesh.points, mesh.faces)
    return ways


def version_of(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "of an unknown version"


def rows_of(whole, piece, ours):
    """Milliseconds, and their ratios to ours, for the mesh and for a piece."""
    return [[way, f"{whole[way]:.1f}", f"{whole[way] / whole[ours]:.2f}", f"{piece[way]:.3f}", f"{piece[way] / piece[ours]:.2f}"] for way in whole]


spreads = []
stream = encoded(options.mesh)
mesh = gltf_psplit.decode(stream)
name = options.mesh.name.split(".")[0]
streams = pieces(mesh, kPieceFaces, kPieces)
decoding = rows_of(measure_decoding([stream]), measure_decoding(streams), kOurs["decode"])
sizes = {way: len(call(mesh)) for way, call in encoders().items()}
encoding = rows_of(measure(encoders(), [mesh]), measure(encoders(), list(map(gltf_psplit.decode, streams))), kOurs["encode"])
beside = "without DracoPy" if DracoPy is None else f"beside DracoPy {version_of('DracoPy')} with the libdraco that it brings"
sections = [f"`gltf_psplit` {gltf_psplit.__version__}, {beside}, beside libdraco whose values numpy copies from vectors, and beside the decoder in",
            "C++. All rows give positions and faces, which were compared. The mesh is encoded by `draco_encoder` at compression level",
            f"{options.level} with 14 bits; a piece has {kPieceFaces:,} of its faces, which lie together, and the means of {kPieces} pieces count. Encoders have their",
            f"defaults. Python {sys.version.split()[0]}, numpy {np.__version__}. Processor time, the least of {options.rounds} rounds in turn.", "",
            *table(["", f"{name}, {len(mesh.faces):,} faces: ms", "of gltf_psplit's", f"a piece of {kPieceFaces:,} faces: ms", "of gltf_psplit's"],
                   decoding + encoding)]
write(page("The Python package", python_findings(name, decoding, encoding, sizes), sections, spreads), options.output)
