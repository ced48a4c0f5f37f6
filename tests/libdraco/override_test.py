#!/usr/bin/env python3
"""Programs that use a shared libdraco, with libpsplit_draco.so loaded before it:  override_test.py LIBRARY CORPUS

Their output must be the same, byte for byte, and psplit must have decoded it. Prints the lines of each check, and exits 1
after a failure. Programs that are not installed, and a corpus that is absent, are said to be skipped."""
import os, pathlib, shutil, subprocess, sys, tempfile

library, corpus = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2])
failures = 0


def run(command, mode):
    """What a program prints, and who decoded its streams. mode: None runs it without the library."""
    environment = dict(os.environ)
    if mode is not None:
        # A sanitizer's runtime would have to come first.
        environment.update(LD_PRELOAD=library, PSPLIT_DRACO=mode)
    done = subprocess.run(command, env=environment, capture_output=True, text=True, errors="replace")
    lines = [line for line in done.stderr.splitlines() if line.startswith("psplit_draco: ")]
    return done.returncode, [line.rsplit(" ", 1)[1] for line in lines]


def expect(condition, what):
    global failures
    failures += not condition
    print(f"{'ok' if condition else 'FAILED'}  {what}")


def compare(name, command_for, folder, decoder="psplit"):
    """Runs command_for(output) with and without the library. `decoder` is who is to decode all of its streams."""
    outputs = []
    for mode in (None, "verbose", "off"):
        output = folder / (mode or "alone") / f"output{name.rsplit(' ', 1)[1]}"  # some programs write their output's name
        output.parent.mkdir(exist_ok=True)
        output.unlink(missing_ok=True)
        code, seen = run(command_for(output), mode)
        expect(code == 0 and output.exists(), f"{name}: {mode or 'alone'} exits {code}")
        if mode == "verbose":
            expect(set(seen) == {decoder}, f"{name}: decoded by {sorted(set(seen))}")
        outputs.append(output.read_bytes() if output.exists() else None)
    expect(outputs[0] is not None and outputs.count(outputs[0]) == 3, f"{name}: the same bytes")


def grid_obj(columns, rows):
    """A wavy grid with normals and texture coordinates that have a seam."""
    lines = []
    for y in range(rows):
        for x in range(columns):
            lines.append(f"v {x} {y} {((x * 7 + y * 13) % 11) / 10}")
            lines.append(f"vt {x / columns} {y / rows}")
            lines.append("vn 0 0 1")
    lines.append("vt 0.5 0.25")
    for y in range(rows - 1):
        for x in range(columns - 1):
            a, b, c, d = (1 + y * columns + x + i for i in (0, 1, columns, columns + 1))
            seam = columns * rows + 1 if x == columns // 2 else a
            lines.append(f"f {a}/{seam}/{a} {b}/{b}/{b} {d}/{d}/{d}")
            lines.append(f"f {a}/{a}/{a} {d}/{d}/{d} {c}/{c}/{c}")
    return "\n".join(lines) + "\n"


def with_draco_tools(folder):
    for tool in ("draco_encoder", "draco_decoder"):
        if shutil.which(tool) is None:
            return print(f"skipped: {tool} is not installed")
    source = folder / "grid.obj"
    source.write_text(grid_obj(40, 30))
    kinds = {"level 0": ["-cl", "0"], "level 7": ["-cl", "7"], "level 10": ["-cl", "10"], "exact": ["-qp", "0", "-qt", "0"],
             "cloud": ["-point_cloud", "-cl", "7"], "sequential cloud": ["-point_cloud", "-cl", "0"]}
    for kind, options in kinds.items():
        stream = folder / f"{kind}.drc"
        subprocess.run(["draco_encoder", "-i", source, "-o", stream, *options], check=True, capture_output=True)
        for suffix in ([".ply"] if "cloud" in kind else [".obj", ".ply"]):
            compare(f"draco_decoder, {kind}, {suffix}", lambda output: ["draco_decoder", "-i", stream, "-o", output], folder)
    for stream in sorted(corpus.glob("**/*.drc")):
        is_current = tuple(stream.read_bytes()[5:7]) in ((2, 2), (2, 3))
        compare(f"draco_decoder, {stream.name}, .ply", lambda output: ["draco_decoder", "-i", stream, "-o", output], folder,
                "psplit" if is_current else "libdraco")


def with_assimp(folder):
    if shutil.which("assimp") is None:
        return print("skipped: assimp is not installed")
    assets = sorted(corpus.glob("**/*draco*.gl*"))
    if not assets:
        return print("skipped: no corpus with Draco assets")
    for asset in assets:
        # Its importer refuses some assets by itself; then there is nothing to compare.
        if run(["assimp", "export", asset, folder / "try.obj"], None)[0] == 0:
            compare(f"assimp, {asset.name}, .obj", lambda output: ["assimp", "export", asset, output], folder)


with tempfile.TemporaryDirectory() as name:
    with_draco_tools(pathlib.Path(name))
    with_assimp(pathlib.Path(name))
print(f"{failures} failed")
sys.exit(failures > 0)
