#!/usr/bin/env python3
"""What CMake's options choose, as its messages say:  options_test.py SOURCE CMAKE

Configures with a toolkit of CUDA and without a GPU, with one, and with a GPU's answer that is made here; and in another project.
Nothing is compiled."""
import os, pathlib, re, shutil, subprocess, sys, tempfile

source, cmake = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]


def configure(project, build, *options, gpu=None):
    """CMake's messages. gpu: what nvidia-smi says of GPUs; None: it fails, as without a driver."""
    bin = build.parent / "bin"
    bin.mkdir(exist_ok=True)
    (bin / "nvidia-smi").write_text("#!/bin/sh\n" + ("exit 9\n" if gpu is None else f"printf '{gpu}'\n"))
    (bin / "nvidia-smi").chmod(0o755)
    shutil.rmtree(build, ignore_errors=True)
    done = subprocess.run([cmake, "-G", "Ninja", "-S", project, "-B", build, *options], capture_output=True, text=True,
                          env=os.environ | {"PATH": f"{bin}:{os.environ['PATH']}"})
    if done.returncode != 0:
        sys.exit(f"{options}: {done.stdout}{done.stderr}")
    return done.stdout


def expect(said, pattern):
    if not re.search(pattern, said):
        sys.exit(f"{said}\n\ndoes not say {pattern!r}")


decoder = ("-DPSPLIT_BUILD_ENCODER=OFF", "-DPSPLIT_BUILD_TESTS=OFF")
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    build = folder / "build"
    expect(configure(source, build, *decoder, "-DPSPLIT_CUDA=OFF"), "CUDA decoder: OFF, because PSPLIT_CUDA is OFF; -DPSPLIT_CUDA=AUTO")
    said = configure(source, build, *decoder)
    has_toolkit = "no CUDA toolkit 12 or newer" not in said
    if has_toolkit:
        expect(said, "CUDA decoder: OFF, because this machine has a CUDA toolkit, but no GPU; -DPSPLIT_CUDA=ON")
        expect(configure(source, build, *decoder, gpu="8.9\\n9.0\\n8.9\\n"), "CUDA decoder: ON\n")
        # One object file for each kind of GPU, and no other.
        commands = (build / "compile_commands.json").read_text() + (build / "build.ninja").read_text()
        kinds = set(re.findall(r"compute_(\d+)", commands))
        if kinds != {"89", "90"}:
            sys.exit(f"GPUs of 8.9 and 9.0 get code for {sorted(kinds)}")
        expect(configure(source, build, *decoder, "-DPSPLIT_CUDA=AUTO", "-DCMAKE_CUDA_ARCHITECTURES=90-virtual"), "CUDA decoder: ON\n")
    else:
        print("skipped: choosing GPUs, because there is no CUDA toolkit")
    # Another project gets the library for C, which is built only for who links it.
    project = folder / "project"
    project.mkdir()
    (project / "CMakeLists.txt").write_text(f"""cmake_minimum_required(VERSION 3.22)
project(user LANGUAGES CXX)
add_subdirectory({source} psplit)
if(NOT TARGET psplit::c)
  message(FATAL_ERROR "add_subdirectory gives no psplit::c")
endif()
foreach(target psplit_unity psplit_blender gltf-psplit)
  if(TARGET ${{target}})
    message(FATAL_ERROR "add_subdirectory gives ${{target}}")
  endif()
endforeach()
""")
    configure(project, build)
    all = subprocess.run(["ninja", "-C", build, "-t", "inputs", "all"], capture_output=True, text=True, check=True).stdout
    if "bindings" in all or "libpsplit.so" in all or "libpsplit_decoder.a" not in all:
        sys.exit(f"a project that does not link psplit::c builds it: {all}")
    # Uninstalling removes what the manifest lists, and folders of ours that are then empty.
    prefix = folder / "prefix"
    files = [prefix / file for file in ("lib/libpsplit.so.0.1", "include/psplit/a b.h", "lib/cmake/psplit/psplit-config.cmake",
                                        "lib/psplit/libextern_draco.so")]
    for file in [*files, prefix / "lib/psplit/of-the-user", prefix / "lib/libother.so"]:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    (prefix / "lib/libpsplit.so").symlink_to("libpsplit.so.0.1")
    manifest = folder / "install_manifest.txt"
    uninstall = [cmake, "-D", f"MANIFEST={manifest}", "-P", source / "cmake/uninstall.cmake"]
    if subprocess.run(uninstall, capture_output=True).returncode == 0:
        sys.exit("what was never installed is removed")
    manifest.write_text("\n".join(str(file) for file in [*files, prefix / "lib/libpsplit.so", prefix / "gone"]))
    expect(subprocess.run(uninstall, capture_output=True, text=True, check=True).stdout, "5 files were removed")
    left = sorted(file.relative_to(prefix).as_posix() for file in prefix.rglob("*"))
    if left != ["include", "lib", "lib/cmake", "lib/libother.so", "lib/psplit", "lib/psplit/of-the-user"]:
        sys.exit(f"these stay: {left}")
print("6 configurations" if has_toolkit else "3 configurations")
