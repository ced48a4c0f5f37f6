#!/usr/bin/env python3
"""Instructions of the command grow no faster than what an asset has: primitives, meshes, buffers, faces of an edge.

    linear_time_test.py GLTF_PSPLIT

valgrind counts the instructions, so the machine's speed and load do not matter. An asset of three sizes, n, 2n and 4n: the
step from 2n to 4n may take 2.5 times as many instructions as the step from n to 2n. A quadratic part would take 4 times as
many. Without valgrind the test is skipped (exit code 77)."""
import json
import math
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile

MOST_GROWTH = 2.5


class Asset:
    def __init__(self, is_glb=True):
        self.is_glb = is_glb
        self.buffers = [bytearray()]
        self.json = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
                     "scene": 0, "scenes": [{"nodes": []}]}

    def accessor(self, rows, layout, component_type, name, bounds=False):
        if not self.is_glb and self.buffers[-1]:
            self.buffers.append(bytearray())
        data = self.buffers[-1]
        data.extend(bytes(-len(data) % 4))
        view = {"buffer": len(self.buffers) - 1, "byteOffset": len(data)}
        for row in rows:
            data.extend(struct.pack(layout, *row))
        view["byteLength"] = len(data) - view["byteOffset"]
        self.json["bufferViews"].append(view)
        accessor = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component_type,
                    "count": len(rows), "type": name}
        if bounds:
            accessor |= {"min": list(map(min, zip(*rows))), "max": list(map(max, zip(*rows)))}
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def primitive(self, points, faces):
        return {"attributes": {"POSITION": self.accessor(points, "<3f", 5126, "VEC3", True)},
                "indices": self.accessor([(i,) for face in faces for i in face], "<I", 5125, "SCALAR")}

    def mesh(self, primitives):
        self.json["meshes"].append({"primitives": primitives})
        self.json["nodes"].append({"mesh": len(self.json["meshes"]) - 1})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def write(self, folder, name):
        if not self.is_glb:
            self.json["buffers"] = []
            for i, data in enumerate(self.buffers):
                (folder / f"{name}.{i}.bin").write_bytes(data)
                self.json["buffers"].append({"uri": f"{name}.{i}.bin", "byteLength": len(data)})
            path = folder / f"{name}.gltf"
            path.write_text(json.dumps(self.json))
            return path
        data = bytes(self.buffers[0]) + bytes(-len(self.buffers[0]) % 4)
        self.json["buffers"] = [{"byteLength": len(data)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        path = folder / f"{name}.glb"
        path.write_bytes(b"glTF" + struct.pack("<III", 2, 28 + len(text) + len(data), len(text)) + b"JSON" + text
                         + struct.pack("<I", len(data)) + b"BIN\0" + data)
        return path


def box(i):
    points = [(x + i, y, z + i / 8) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]


def one_mesh(count):
    asset = Asset()
    asset.mesh([asset.primitive(*box(i)) for i in range(count)])
    return asset


def many_meshes(count, is_glb=True):
    asset = Asset(is_glb)
    for i in range(count):
        asset.mesh([asset.primitive(*box(i))])
    return asset


def many_buffers(count):
    return many_meshes(count, False)


def ring(count):
    angles = [2 * math.pi * i / count for i in range(count)]
    return [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)] + [(math.cos(a), math.sin(a), 0.5) for a in angles]


def one_primitive(points, faces):
    asset = Asset()
    asset.mesh([asset.primitive(points, faces)])
    return asset


def edge_of_many_faces(count):
    return one_primitive(ring(count), [(0, 1, i + 2) for i in range(count)])


def vertex_of_many_faces(count):
    return one_primitive(ring(count), [(0, i + 2, (i + 1) % count + 2) for i in range(count)])


def sheets_around_a_vertex(count):
    rim = 100
    order = [i % rim for i in range(count)]
    random.Random(1).shuffle(order)
    return one_primitive(ring(rim), [(0, i + 2, (i + 1) % rim + 2) for i in order])


ENCODE = ["encode", "-f", "-j", "1", "IN", "OUT"]
# The measured commands: assets, the smallest size, and the command lines. OUT of the first is ENCODED for the others.
CASES = [
    (one_mesh, 40, [ENCODE, ["decode", "-f", "ENCODED", "OUT"], ["validate", "ENCODED"], ["inspect", "ENCODED"],
                    ["diff", "IN", "ENCODED"], ENCODE + ["--fallback", "coarse", "--always-patches"]]),
    (many_meshes, 40, [ENCODE, ENCODE + ["--condense"], ["expand", "-f", "ENCODED", "OUT"]]),
    (many_buffers, 40, [ENCODE, ["decode", "-f", "ENCODED", "OUT"]]),
    (edge_of_many_faces, 2000, [ENCODE]),
    (vertex_of_many_faces, 2000, [ENCODE]),
    (sheets_around_a_vertex, 2000, [ENCODE]),
]


def instructions(command):
    run = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command], capture_output=True,
                         text=True, errors="replace")
    found = re.search(r"Collected : (\d+)", run.stderr)
    if run.returncode or not found:
        sys.exit(f"{' '.join(command)}: exit code {run.returncode}\n{run.stdout}{run.stderr}")
    return int(found[1])


def main():
    command = sys.argv[1]
    if shutil.which("valgrind") is None:
        print("skipped: valgrind is not installed")
        return 77
    failures = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for make, smallest, lines in CASES:
            counts = [[] for _ in lines]
            for size in (smallest, 2 * smallest, 4 * smallest):
                source = make(size).write(folder, f"{make.__name__}{size}")
                names = {"IN": source, "ENCODED": folder / "encoded.glb"}
                for k, line in enumerate(lines):
                    names["OUT"] = folder / ("other.glb" if k else "encoded.glb")
                    counts[k].append(instructions([command, *(str(names.get(word, word)) for word in line)]))
            for line, (least, twice, most) in zip(lines, counts):
                growth = (most - twice) / max(twice - least, 1)
                print(f"{make.__name__}, {smallest} to {4 * smallest}: {' '.join(line)}: "
                      f"{least:,}, {twice:,}, {most:,} instructions; growth {growth:.2f}")
                if growth > MOST_GROWTH:
                    print(f"FAILED: more than {MOST_GROWTH}")
                    failures += 1
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
