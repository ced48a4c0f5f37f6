#!/usr/bin/env python3
"""Installs the package by the command of docs/python.md into fresh environments that see the system's numpy, without an
index: without and with the encoder. Then runs the tests with what was installed:

  run_wheel.py --cmake COMMAND --compiler COMMAND --build FOLDER --encoder-build FOLDER

--build is the folder for the package without the encoder. That for the other may have compiled psplit's libraries already
(tests/package/run_package.py).
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import venv

parser = argparse.ArgumentParser()
for name in ("cmake", "compiler", "build", "encoder-build"):
    parser.add_argument("--" + name, required=True)
options = parser.parse_args()
tests = pathlib.Path(__file__).resolve().parent
package = tests.parents[1] / "bindings/python"

# The installed files, from the record of the wheel.
DESCRIBE = """
import gltf_psplit, importlib.metadata, json
of = importlib.metadata.distribution("gltf-psplit")
print(json.dumps({"module": gltf_psplit.__file__, "version": gltf_psplit.__version__, "of": of.version,
                  "requires": of.requires, "files": {str(file): str(file.locate()) for file in of.files}}))
"""


def run(*command, **environment):
    done = subprocess.run([str(part) for part in command], env={**os.environ, "PYTHONPATH": "", **environment}, capture_output=True,
                          text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nexits with {done.returncode}:\n{done.stdout[-6000:]}{done.stderr[-6000:]}")
    return done.stdout


def expect(what, expected, found):
    if found != expected:
        sys.exit(f"{what}: {found}, not {expected}")


def test_wheel(folder, encoder, build):
    venv.create(folder, system_site_packages=True, with_pip=True)
    python = folder / "bin" / "python"
    run(python, "-m", "pip", "install", "--no-index", package, PATH=f"{pathlib.Path(options.cmake).parent}:{os.environ['PATH']}",
        CXX=options.compiler, PSPLIT_BUILD=build, PSPLIT_ENCODER=encoder,
        CMAKE_ARGS="'-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG'")  # compiles in a third of the time
    found = json.loads(run(python, "-c", DESCRIBE))
    expect("the module is the installed one", True, found["module"].startswith(str(folder)))
    expect("the version of the distribution", found["version"], found["of"])
    expect("what has to be there", [], [file for file in (
        "__init__.py", "py.typed", "_native.pyi", "meshio_plugin.py") if f"gltf_psplit/{file}" not in found["files"]])
    expect("what it needs", "numpy>=1.20", found["requires"][0])
    licence, = (place for file, place in found["files"].items() if file.endswith(".dist-info/LICENSE"))
    expect("the licence is the project's", (package.parents[1] / "LICENSE").read_bytes(), pathlib.Path(licence).read_bytes())
    print(f"PSPLIT_ENCODER={encoder}:", run(python, "-m", "pytest", "-q", "-p", "no:cacheprovider", tests,
                                            PYTHONDONTWRITEBYTECODE="1").splitlines()[-1])


for encoder, build in (("OFF", options.build), ("ON", options.encoder_build)):
    with tempfile.TemporaryDirectory() as name:
        test_wheel(pathlib.Path(name), encoder, build)
