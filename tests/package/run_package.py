#!/usr/bin/env python3
"""Installs psplit, static and shared, and builds and runs gltf_ext/examples as a project that finds it:

  run_package.py --source FOLDER --build FOLDER --psplit COMMAND --cmake COMMAND --compiler COMMAND --shared ON|OFF

--build is a finished build, of static or shared libraries as --shared says; the other kind is built here, without
what needs libdraco. The project has a folder src of its own, from which no header of ours may be taken.
"""
import argparse, pathlib, re, subprocess, sys, tempfile

parser = argparse.ArgumentParser()
for name in ("source", "build", "psplit", "cmake", "compiler", "shared"):
    parser.add_argument("--" + name, required=True)
options = parser.parse_args()
source = pathlib.Path(options.source)


def run(*command, code=0):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != code:
        sys.exit(f"{' '.join(map(str, command))}\nexits with {done.returncode}:\n{done.stdout[-6000:]}{done.stderr[-6000:]}")
    return done.stdout + done.stderr


def expect(what, pattern, said):
    if not re.search(pattern, said):
        sys.exit(f"{what} says {said!r}, not {pattern!r}")


def configure(folder, build, *definitions):
    run(options.cmake, "-G", "Ninja", "-S", folder, "-B", build, "-DCMAKE_BUILD_TYPE=Release",
        f"-DCMAKE_CXX_COMPILER={options.compiler}", *definitions)


def check(kind, prefix, folder, asset):
    """Builds the examples against what is installed, and runs them."""
    project = folder / "project"
    own = project / "src" / "mesh"
    own.mkdir(parents=True)
    for name in ("status.h", "parallel.h", "mesh/mesh.h"):
        (project / "src" / name).write_text(f'#error "the user\'s own {name} was taken for ours"\n')
    for file in (source / "gltf_ext" / "examples").iterdir():
        (project / file.name).write_text(file.read_text())
    configure(project, folder / "examples", f"-DCMAKE_PREFIX_PATH={prefix}",
              f"-DCMAKE_CXX_FLAGS=-I{project} -Wall -Wextra -Wconversion -Wshadow -Werror")
    run(options.cmake, "--build", folder / "examples")
    examples = folder / "examples"
    model = run(examples / "print_model", asset)
    expect("print_model", r"^2\d{4} triangles, \d+ POSITION from \(", model)
    patch = run(examples / "one_patch", asset, 3)
    expect("one_patch", r"^patch 3 of 5: \d+ triangles, \d+ points, largest index \d+, from \(", patch)
    points, largest = map(int, re.search(r"(\d+) points, largest index (\d+)", patch).groups())
    if largest + 1 != points:
        sys.exit(f"one_patch: {patch}")
    run(examples / "one_patch", asset, 5, code=3)
    run(examples / "print_model", source / "README.md", code=3)
    # The device's first point is the host's.
    gpu = subprocess.run([examples / "load_to_gpu", asset], capture_output=True, text=True)
    if gpu.returncode == 5:
        expect("load_to_gpu", "no CUDA device to decode on: ", gpu.stderr)
        device = gpu.stderr.strip().rsplit(": ", 1)[-1]
    else:
        point = re.escape(re.search(r"from \(.*\)", model).group())
        expect("load_to_gpu", r"2\d{4} triangles, \d+ points on the device " + point, gpu.stdout)
        device = "on the device too"
    print(f"{kind}: {model.strip()}; {patch.strip()}; GPU: {device}")


with tempfile.TemporaryDirectory(prefix="psplit-package-") as name:
    folder = pathlib.Path(name)
    asset = folder / "asset.glb"
    run(options.psplit, "generate", "-q", folder / "plain.glb", "--shape", "blob", "--faces", 20000, "--seed", 1)
    run(options.psplit, "encode", "-q", "--patches", 5, folder / "plain.glb", asset)
    for shared in ("OFF", "ON"):
        kind = "shared" if shared == "ON" else "static"
        build = options.build
        if shared != options.shared:
            build = folder / f"{kind}-build"
            configure(source, build, "-DPSPLIT_BUILD_ENCODER=OFF", "-DPSPLIT_CUDA=OFF", "-DBUILD_SHARED_LIBS=" + shared)
            run(options.cmake, "--build", build)
        run(options.cmake, "--install", build, "--prefix", folder / kind)
        libraries = sorted(path.name for path in (folder / kind).rglob("libpsplit_*"))
        if not any(library.endswith(".so" if shared == "ON" else ".a") for library in libraries):
            sys.exit(f"{kind}: installed {libraries}")
        check(kind, folder / kind, folder / f"{kind}-project", asset)
