#!/usr/bin/env python3
"""How far decoded values are from their input, over a corpus, and the bytes of the outputs:

  measure_errors.py --psplit COMMAND --same-mesh COMMAND --corpus FOLDER [--only TEXT]

Encodes each well-formed file with the default options. An error counts in half steps of the grid that the drawn values of
the mesh call for: 1 is the most that a grid as fine as its bits allows.
"""
import argparse, collections, concurrent.futures, pathlib, subprocess, tempfile

parser = argparse.ArgumentParser()
parser.add_argument("--psplit", type=pathlib.Path, required=True)
parser.add_argument("--same-mesh", type=pathlib.Path, required=True)
parser.add_argument("--corpus", type=pathlib.Path, required=True)
parser.add_argument("--only", default="", help="only files whose paths contain this")
options = parser.parse_args()
kKinds = {".gltf", ".glb", ".ply", ".obj", ".stl", ".off"}


def measure(file):
    """(bytes of the output, [(semantic, count, worst, mean)]), or None if the file is refused."""
    with tempfile.TemporaryDirectory(prefix="psplit-errors-") as name:
        encoded, decoded = pathlib.Path(name) / "encoded.glb", pathlib.Path(name) / "decoded.glb"
        for command in (["encode", "-q", "-j", "1", file, encoded], ["decode", "-q", "-j", "1", encoded, decoded]):
            if subprocess.run([options.psplit, *command], capture_output=True).returncode != 0:
                return None
        done = subprocess.run([options.same_mesh, "--errors", file, decoded], capture_output=True, text=True)
        if done.returncode != 0:
            print(f"{file}: {done.stdout}", flush=True)
        rows = [line.split(" ") for line in done.stdout.splitlines()] if done.returncode == 0 else []
        return encoded.stat().st_size, [(row[0], int(row[1]), float(row[2]), float(row[3])) for row in rows]


files = sorted(file for file in options.corpus.rglob("*") if file.suffix in kKinds and options.only in str(file)
               and "malformed" not in file.relative_to(options.corpus).parts)
assets, size = 0, 0
worst, total, count = collections.Counter(), collections.Counter(), collections.Counter()
attributes, beyond = collections.Counter(), collections.Counter()
with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
    for file, measured in zip(files, pool.map(measure, files)):
        if measured is None:
            continue
        assets, size = assets + 1, size + measured[0]
        for semantic, values, most, mean in measured[1]:
            if most > 1.01:
                print(f"{file.relative_to(options.corpus)}: {semantic} is off by {most:.3f} half steps")
            kind = semantic.rstrip("0123456789").rstrip("_")
            for key in (kind, "all"):
                attributes[key] += 1
                beyond[key] += most > 1.01
                if most < float("inf"):  # otherwise all values are equal, and came back as others
                    worst[key] = max(worst[key], most)
                    total[key] += values * mean
                    count[key] += values
print(f"{assets} assets, {size:,} bytes\n")
print("| attribute | of primitives | values | worst | mean | with errors above 1.01 |\n|---|--:|--:|--:|--:|--:|")
for key in sorted(count, key=lambda key: (key == "all", key)):
    print(f"| {key} | {attributes[key]} | {count[key]:,} | {worst[key]:.3f} | {total[key] / count[key]:.3f} | {beyond[key]} |")
