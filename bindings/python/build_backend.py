"""Makes the wheel: the build backend of pyproject.toml (PEP 517). It asks an index for nothing that the machine has, so that
`pip install` works with PyPI and without a network. (Before Python 3.11, pip itself asks for tomli.) The module in C++ is built with the project's CMakeLists.txt.

Environment:
    PSPLIT_ENCODER   ON, OFF, or AUTO (the default): the encoder is built if its packages are found, without libdraco
                     and meshoptimizer if one of these is not;
                     CMAKE_ARGS=-DPSPLIT_WITH_DRACO=OFF builds it without libdraco
    PSPLIT_LICENCES  a file with the licences of linked libraries, which becomes a part of the wheel
    MACOSX_DEPLOYMENT_TARGET: on macOS, the oldest system that the wheel is for; by default this one
    PSPLIT_BUILD     the folder to build in; by default build/wheel-* of the checkout, where a second build is quick
    CMAKE_ARGS       more arguments for CMake
    CMAKE_BUILD_PARALLEL_LEVEL, CMAKE_GENERATOR, CMAKE_CXX_COMPILER_LAUNCHER: as CMake takes them
"""
import base64
import hashlib
import importlib.util
import os
import pathlib
import platform
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

try:
    import tomllib
except ImportError:  # before Python 3.11
    import tomli as tomllib

package = pathlib.Path(__file__).resolve().parent
project = package.parent.parent
described = tomllib.loads((package / "pyproject.toml").read_text())["project"]
version = re.search(r"project\(psplit VERSION (\S+)", (project / "CMakeLists.txt").read_text()).group(1)
name = f"{described['name'].replace('-', '_')}-{version}"


# The hooks of PEP 517


def get_requires_for_build_wheel(config_settings=None):
    missing = [] if shutil.which("cmake") else ["cmake>=3.22"]
    if not (shutil.which("ninja") or shutil.which("make") or sys.platform == "win32"):
        missing.append("ninja>=1.10")
    # CMake finds that of the system, which the interpreter of an environment does not see.
    found = importlib.util.find_spec("pybind11") or any(pathlib.Path("/usr").glob("*/cmake/pybind11/pybind11Config.cmake"))
    return missing if found else [*missing, "pybind11>=2.10"]


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = pathlib.Path(metadata_directory) / f"{name}.dist-info"
    for file, content in metadata().items():
        path = folder / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return folder.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    module = build_module()
    files = {f"gltf_psplit/{path.name}": path.read_bytes() for path in sorted((package / "gltf_psplit").iterdir()) if path.is_file()}
    files[f"gltf_psplit/{module.name}"] = module.read_bytes()
    if "PSPLIT_LICENCES" in os.environ:
        licences = pathlib.Path(os.environ["PSPLIT_LICENCES"])
        files[f"gltf_psplit/{licences.name}"] = licences.read_bytes()
    files.update({f"{name}.dist-info/{file}": content for file, content in metadata().items()})
    record = f"{name}.dist-info/RECORD"
    files[record] = "".join([*(f"{file},sha256={digest(content)},{len(content)}\n" for file, content in files.items()),
                             f"{record},,\n"]).encode()
    wheel = pathlib.Path(wheel_directory) / f"{name}-{tag()}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, content in files.items():
            entry = zipfile.ZipInfo(file)  # of a fixed time: the same bytes at any time
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return wheel.name


def build_sdist(sdist_directory, config_settings=None):
    sys.exit("gltf-psplit: a source distribution would lack the sources above this folder; build a wheel from a checkout")


# What a wheel has beside the package


def metadata():
    """The files of dist-info but RECORD, of what pyproject.toml says."""
    lines = ["Metadata-Version: 2.1", f"Name: {described['name']}", f"Version: {version}", f"Summary: {described['description']}",
             f"License: {described['license']['text']}", "License-File: LICENSE",
             *(f"Author: {author['name']}" for author in described["authors"]), "Keywords: " + ",".join(described["keywords"]),
             *(f"Classifier: {of}" for of in described["classifiers"]),
             *(f"Project-URL: {name}, {address}" for name, address in described["urls"].items()),
             f"Requires-Python: {described['requires-python']}",
             *(f"Requires-Dist: {needed}" for needed in described["dependencies"])]
    for extra, dependencies in described["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}", *(f"Requires-Dist: {needed}; extra == '{extra}'" for needed in dependencies)]
    readme = (package / described["readme"]).read_text()
    lines += ["Description-Content-Type: text/markdown", "", readme]
    wheel = f"Wheel-Version: 1.0\nGenerator: gltf-psplit\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    return {"METADATA": "\n".join(lines).encode(), "WHEEL": wheel.encode(), "LICENSE": (project / "LICENSE").read_bytes()}


def tag():
    """The wheel's tag for this interpreter and this system. Modules have a suffix as .cpython-311-x86_64-linux-gnu.so or .cp311-win_amd64.pyd."""
    abi = re.match(r"\.c(?:python-|p)(\w+?)-", sysconfig.get_config_var("EXT_SUFFIX"))
    if abi is None:
        sys.exit(f"gltf-psplit: {sys.implementation.name} is not CPython")
    system = "-".join(("macosx", *macos())) if sys.platform == "darwin" else sysconfig.get_platform()
    return "-".join((f"cp{sys.version_info[0]}{sys.version_info[1]}", f"cp{abi.group(1)}", re.sub(r"\W", "_", system)))


def macos():
    """The oldest macOS that the module is for, and the architecture. Both are this machine's, because the interpreter may be built
    for two architectures, and for a system without the library of C++20."""
    major, minor = f"{os.environ.get('MACOSX_DEPLOYMENT_TARGET') or platform.mac_ver()[0]}.0".split(".")[:2]
    return f"{major}.{minor if int(major) < 11 else 0}", platform.machine()  # since 11, tags have the minor version 0


def digest(content):
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


# The module in C++


def build_module():
    build = pathlib.Path(os.environ.get("PSPLIT_BUILD") or project / "build" / f"wheel-{sys.implementation.cache_tag}")
    wanted = os.environ.get("PSPLIT_ENCODER", "AUTO").upper()
    if wanted not in ("ON", "OFF", "AUTO"):
        sys.exit(f"PSPLIT_ENCODER is {wanted}; it takes ON, OFF or AUTO")
    if wanted != "AUTO":
        configure(build, wanted)
    elif not configure(build, "ON", may_fail=True):
        print("gltf-psplit: CMake fails (above); trying without libdraco and meshoptimizer", flush=True)
        if not configure(build, "ON", "OFF", may_fail=True):
            print("gltf-psplit: CMake fails (above); the package will only decode", flush=True)
            configure(build, "OFF")
    subprocess.run(["cmake", "--build", str(build), "--config", "Release", "--target", "psplit_python"], check=True)
    file = "_native" + sysconfig.get_config_var("EXT_SUFFIX")
    built = list((build / "python" / "gltf_psplit").rglob(file))
    if not built:
        sys.exit(f"gltf-psplit: CMake did not make {file}")
    return built[0]


def configure(build, encoder, libraries="ON", may_fail=False):
    command = ["cmake", "-S", str(project), "-B", str(build), "-DCMAKE_BUILD_TYPE=Release", "-DPSPLIT_BUILD_PYTHON=ON",
               f"-DPSPLIT_PYTHON={sys.executable}", f"-DPSPLIT_BUILD_ENCODER={encoder}", "-DPSPLIT_BUILD_TOOLS=OFF",
               "-DPSPLIT_BUILD_TESTS=OFF", "-DPSPLIT_INSTALL=OFF", "-DPSPLIT_CUDA=OFF", "-DPSPLIT_THREADS=STD",
               "-DPSPLIT_STRIP_PYTHON=ON",
               *(f"-DPSPLIT_WITH_{library}={libraries}" for library in ("DRACO", "MESHOPTIMIZER"))]
    if sys.platform == "darwin":
        oldest, architecture = macos()
        command += [f"-DCMAKE_OSX_DEPLOYMENT_TARGET={oldest}", f"-DCMAKE_OSX_ARCHITECTURES={architecture}"]
    if "CMAKE_GENERATOR" not in os.environ and shutil.which("ninja"):
        command += ["-G", "Ninja"]
    command += shlex.split(os.environ.get("CMAKE_ARGS", ""))
    return subprocess.run(command, check=not may_fail).returncode == 0
