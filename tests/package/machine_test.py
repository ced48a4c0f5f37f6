#!/usr/bin/env python3
"""On every machine results have the same bits, or CMake refuses it:  machine_test.py --source FOLDER --cmake COMMAND
--commands compile_commands.json

Configures for machines that psplit does not support, by options of the compilers that are installed, and expects the sentence
that says why. Then checks that every source of a finished build is compiled without fused multiply-adds."""
import argparse, json, pathlib, platform, re, shlex, shutil, subprocess, sys, tempfile

parser = argparse.ArgumentParser()
for name in ("source", "cmake", "commands"):
    parser.add_argument("--" + name, required=True)
options = parser.parse_args()
is_x86 = platform.machine() == "x86_64" and sys.platform != "darwin"  # where g++ is clang
# What a machine is called, its compiler, its flags, and what CMake says; None: it configures.
kMachines = [
    ("x87", "g++" if is_x86 else None, ["-DCMAKE_CXX_FLAGS=-m32 -mfpmath=387"], "floats have more digits .*-msse2"),
    ("32-bit x86 with SSE2", "g++" if is_x86 else None, ["-DCMAKE_CXX_FLAGS=-m32 -msse2 -mfpmath=sse"], None),
    ("-ffast-math", "g++", ["-DCMAKE_CXX_FLAGS=-ffast-math"], "-ffast-math lets the compiler change results"),
    ("64-bit PowerPC", "clang++", ["-DCMAKE_CXX_COMPILER_TARGET=powerpc64-linux-gnu"], "it is big-endian"),
]


def configure(compiler, definitions):
    """What CMake says, in one line. Nothing is linked, so the machine's libraries need not be there."""
    with tempfile.TemporaryDirectory() as build:
        done = subprocess.run([options.cmake, "-G", "Ninja", "-S", options.source, "-B", build,
                               f"-DCMAKE_CXX_COMPILER={compiler}", "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY",
                               "-DPSPLIT_BUILD_ENCODER=OFF", "-DPSPLIT_BUILD_TESTS=OFF", "-DPSPLIT_CUDA=OFF",
                               "-DPSPLIT_THREADS=STD", *definitions], capture_output=True, text=True)
    return done.returncode, " ".join((done.stdout + done.stderr).split())


def compiles_for_powerpc():  # Apple's clang does not
    return shutil.which("clang++") and "ppc64" in subprocess.run(["clang++", "--print-targets"], capture_output=True, text=True).stdout


for name, compiler, definitions, sentence in kMachines:
    if compiler is None or shutil.which(compiler) is None or (compiler == "clang++" and not compiles_for_powerpc()):
        print(f"skipped: {name}, which needs {compiler or 'g++ for x86'}")
        continue
    code, said = configure(compiler, definitions)
    if sentence is None and code != 0:
        sys.exit(f"{name} is refused: {said[-2000:]}")
    if sentence and (code == 0 or not re.search("psplit does not build for this machine: .*" + sentence, said)):
        sys.exit(f"{name} is not refused because of '{sentence}': {said[-2000:]}")

counted = 0
for entry in json.loads(pathlib.Path(options.commands).read_text()):
    file = pathlib.Path(entry["file"])
    words = shlex.split(entry["command"])
    # Sources in C are tests and examples, which calculate nothing. GoogleTest may be a part of the build.
    if file.suffix == ".c" or not any(folder in words for folder in (f"-I{options.source}", f"-I{options.source}/.")):
        continue
    if file.name == "fused.cpp":
        continue  # it is compiled with each
    kind, want = (r"--?fmad[= ]?", "--fmad=false") if file.suffix == ".cu" else ("-ffp-contract|-ffast-math|-Ofast", "-ffp-contract=off")
    chosen = [word for word in words if re.match(kind, word)]
    if not chosen or chosen[-1] != want:
        sys.exit(f"{file} is compiled with {chosen}, not {want}")
    counted += 1
if counted < 10:
    sys.exit(f"only {counted} sources were seen in {options.commands}")
print(f"{counted} sources are compiled without fused multiply-adds")
