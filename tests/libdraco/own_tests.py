#!/usr/bin/env python3
"""Runs libdraco's own tests of its decoder over psplit:  own_tests.py LIBRARY FOLDER

Takes the source of Debian's libdraco, compiles its tests that decode whole meshes and point clouds, and runs them with the
installed libdraco alone and with LIBRARY, libpsplit_draco.so, loaded before it. Each test that passes alone must pass with LIBRARY. FOLDER keeps the
source and the compiled tests. Exits with 77, for skipped, where the source cannot be had."""
import os, pathlib, re, subprocess, sys

library, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
kTests = ["compression/decode_test", "compression/encode_test", "compression/mesh/mesh_edgebreaker_encoding_test",
          "compression/mesh/mesh_encoder_test", "compression/point_cloud/point_cloud_kd_tree_encoding_test",
          "compression/point_cloud/point_cloud_sequential_encoding_test", "core/draco_test_utils"]


def skip(why):
    print("skipped:", why)
    sys.exit(77)


def fetch():
    """The folder of the source whose version is installed, by apt with lists of its own."""
    found = sorted(folder.glob("draco-*/src/draco"))
    if found:
        return found[0].parents[1]
    installed = subprocess.run(["dpkg-query", "-W", "-f=${Version}", "libdraco-dev"], capture_output=True, text=True)
    if installed.returncode != 0:
        skip("libdraco-dev is not Debian's")
    lists = folder / "lists"
    (lists / "partial").mkdir(parents=True, exist_ok=True)
    sources = folder / "sources"
    sources.mkdir(exist_ok=True)
    for entry in [*pathlib.Path("/etc/apt/sources.list.d").glob("*.sources"), *pathlib.Path("/etc/apt/sources.list.d").glob("*.list"),
                  pathlib.Path("/etc/apt/sources.list")]:
        if entry.exists():
            text = re.sub(r"^(Types: *)deb *$", r"\1deb-src", entry.read_text(), flags=re.M)
            (sources / entry.name).write_text(re.sub(r"^deb ", "deb-src ", text, flags=re.M))
    apt = ["apt-get", "-qq", "-o", f"Dir::Etc::SourceParts={sources}", "-o", "Dir::Etc::SourceList=/dev/null", "-o",
           f"Dir::State::Lists={lists}", "-o", f"Dir::Cache={folder / 'cache'}"]
    (folder / "cache").mkdir(exist_ok=True)
    for command in (["update"], ["source", f"draco={installed.stdout}"]):
        done = subprocess.run(apt + command, cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            skip("apt has no source of libdraco: " + " ".join(done.stderr.split())[:300])
    return next(folder.glob("draco-*/src/draco")).parents[1]


def compile_tests(source):
    program = folder / "draco_tests"
    if program.exists():
        return program
    (folder / "testing").mkdir(exist_ok=True)
    (folder / "testing/draco_test_config.h").write_text(
        f'#define DRACO_TEST_DATA_DIR "{source}/testdata"\n#define DRACO_TEST_TEMP_DIR "{folder}"\n')
    command = [os.environ.get("CXX", "g++"), "-std=c++17", "-O0", "-w", f"-I{folder}", "-isystem", "/usr/include/eigen3", "-idirafter",
               source / "src", *[source / f"src/draco/{test}.cc" for test in kTests], "-ldraco", "-lgtest", "-lgtest_main", "-lpthread",
               "-o", program]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        print(done.stderr[-3000:])
        sys.exit(1)
    return program


def run(program, **environment):
    """The names of the tests that pass, and how often psplit and libdraco decoded."""
    done = subprocess.run([program], cwd=folder, env=dict(os.environ, **environment), capture_output=True, text=True, errors="replace")
    text = done.stdout + done.stderr
    passed = set(re.findall(r"^\[       OK \] (\S+)", text, re.M))
    return passed, len(re.findall(r"^psplit_draco: .* psplit$", text, re.M)), len(re.findall(r"^psplit_draco: .* libdraco$", text, re.M))


folder.mkdir(parents=True, exist_ok=True)
program = compile_tests(fetch())
alone, _, _ = run(program)
ours, by_psplit, by_libdraco = run(program, LD_PRELOAD=str(library), PSPLIT_DRACO="verbose")
print(f"{len(alone)} tests pass with libdraco, {len(ours)} with psplit before it; psplit decoded {by_psplit} streams, libdraco {by_libdraco}")
for name in sorted(alone - ours):
    print("FAILED ", name)
sys.exit(0 if alone and alone <= ours and by_psplit > by_libdraco else 1)
