"""Builds the module in C++ with the project's CMakeLists.txt. pyproject.toml has the rest.

Environment:
    PSPLIT_ENCODER   ON, OFF, or AUTO (the default): the encoder is built if its packages are found, without libdraco
                     and meshoptimizer if one of these is not;
                     CMAKE_ARGS=-DPSPLIT_WITH_DRACO=OFF builds it without libdraco
    PSPLIT_LICENCES  a file with the licences of linked libraries, which becomes a part of the wheel
    PSPLIT_BUILD     the folder to build in; by default build/wheel-* of the checkout, where a second build is quick
    CMAKE_ARGS       more arguments for CMake
    CMAKE_BUILD_PARALLEL_LEVEL, CMAKE_GENERATOR, CMAKE_CXX_COMPILER_LAUNCHER: as CMake takes them
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.sdist import sdist

project = pathlib.Path(__file__).resolve().parent.parent.parent
version = re.search(r"project\(psplit VERSION (\S+)", (project / "CMakeLists.txt").read_text()).group(1)


class BuildWithCMake(build_ext):
    def build_extension(self, extension):
        module = pathlib.Path(self.get_ext_fullpath(extension.name))
        build = pathlib.Path(os.environ.get("PSPLIT_BUILD") or project / "build" / f"wheel-{sys.implementation.cache_tag}")
        wanted = os.environ.get("PSPLIT_ENCODER", "AUTO").upper()
        if wanted not in ("ON", "OFF", "AUTO"):
            sys.exit(f"PSPLIT_ENCODER is {wanted}; it takes ON, OFF or AUTO")
        if wanted != "AUTO":
            self.configure(build, wanted)
        elif not self.configure(build, "ON", may_fail=True):
            print("psplit: CMake fails (above); trying without libdraco and meshoptimizer", flush=True)
            if not self.configure(build, "ON", "OFF", may_fail=True):
                print("psplit: CMake fails (above); the package will only decode", flush=True)
                self.configure(build, "OFF")
        subprocess.run(["cmake", "--build", str(build), "--config", "Release", "--target", "psplit_python"], check=True)
        module.parent.mkdir(parents=True, exist_ok=True)
        built = list((build / "python" / "psplit").rglob(module.name))
        if not built:
            sys.exit(f"psplit: CMake did not make {module.name}")
        shutil.copy(built[0], module)
        if "PSPLIT_LICENCES" in os.environ:
            shutil.copy(os.environ["PSPLIT_LICENCES"], module.parent)

    def configure(self, build, encoder, libraries="ON", may_fail=False):
        command = ["cmake", "-S", str(project), "-B", str(build), "-DCMAKE_BUILD_TYPE=Release", "-DPSPLIT_BUILD_PYTHON=ON",
                   f"-DPSPLIT_PYTHON={sys.executable}", f"-DPSPLIT_BUILD_ENCODER={encoder}", "-DPSPLIT_BUILD_TOOLS=OFF",
                   "-DPSPLIT_BUILD_TESTS=OFF", "-DPSPLIT_INSTALL=OFF", "-DPSPLIT_CUDA=OFF", "-DPSPLIT_THREADS=STD",
                   *(f"-DPSPLIT_WITH_{name}={libraries}" for name in ("DRACO", "MESHOPTIMIZER"))]
        if sys.platform.startswith("linux"):
            command.append("-DCMAKE_MODULE_LINKER_FLAGS=-s")  # no symbols that only debuggers need
        if "CMAKE_GENERATOR" not in os.environ and shutil.which("ninja"):
            command += ["-G", "Ninja"]
        command += shlex.split(os.environ.get("CMAKE_ARGS", ""))
        return subprocess.run(command, check=not may_fail).returncode == 0


class NoSourceDistribution(sdist):
    def run(self):
        sys.exit("psplit: a source distribution would lack the sources above this folder; build a wheel from a checkout")


setup(version=version, ext_modules=[Extension("psplit._native", sources=[])],
      cmdclass={"build_ext": BuildWithCMake, "sdist": NoSourceDistribution})
