#!/usr/bin/env python3
"""Builds the wheel without a network, without and with the encoder. Installs each into a fresh environment that sees the
system's numpy, and runs the tests with it:

  run_wheel.py --cmake COMMAND --compiler COMMAND --build FOLDER --encoder-build FOLDER

--build is the folder for the wheel without the encoder. That for the other may have compiled psplit's libraries already
(tests/package/run_package.py).
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import venv
import zipfile

parser = argparse.ArgumentParser()
for name in ("cmake", "compiler", "build", "encoder-build"):
    parser.add_argument("--" + name, required=True)
options = parser.parse_args()
tests = pathlib.Path(__file__).resolve().parent
package = tests.parents[1] / "bindings/python"


def run(*command, **environment):
    done = subprocess.run([str(part) for part in command], env={**os.environ, **environment}, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nexits with {done.returncode}:\n{done.stdout[-6000:]}{done.stderr[-6000:]}")
    return done.stdout


def test_wheel(folder, encoder, build):
    run(sys.executable, "-m", "pip", "wheel", package, "--no-build-isolation", "--no-index", "--no-deps", "-w", folder,
        PATH=f"{pathlib.Path(options.cmake).parent}:{os.environ['PATH']}", CXX=options.compiler, PSPLIT_BUILD=build,
        PSPLIT_ENCODER=encoder, CMAKE_ARGS="'-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG'")  # compiles in a third of the time
    wheel, = folder.glob("psplit-*.whl")
    files = zipfile.ZipFile(wheel).namelist()
    for needed in ("psplit/__init__.py", "psplit/py.typed", "psplit/_native.pyi", "psplit/meshio_plugin.py"):
        if needed not in files:
            sys.exit(f"{wheel.name} has no {needed}")
    licence, = (file for file in files if file.endswith("/LICENSE"))
    if zipfile.ZipFile(wheel).read(licence) != (package.parents[1] / "LICENSE").read_bytes():
        sys.exit(f"{wheel.name}: {licence} is not the project's")
    venv.create(folder / "venv", system_site_packages=True, with_pip=False)
    python = folder / "venv" / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "--no-index", "--no-deps", wheel, PYTHONPATH="")
    # The package is the installed one. Its version is that of the project.
    where = run(python, "-c", "import psplit; print(psplit.__file__, psplit.__version__)", PYTHONPATH="").split()
    if not where[0].startswith(str(folder)) or f"psplit-{where[1]}-" not in wheel.name:
        sys.exit(f"{wheel.name} was installed, and {' '.join(where)} was found")
    print(f"PSPLIT_ENCODER={encoder}:", run(python, "-m", "pytest", "-q", "-p", "no:cacheprovider", tests, PYTHONPATH="",
                                            PYTHONDONTWRITEBYTECODE="1").splitlines()[-1])


for encoder, build in (("OFF", options.build), ("ON", options.encoder_build)):
    with tempfile.TemporaryDirectory() as name:
        test_wheel(pathlib.Path(name), encoder, build)
