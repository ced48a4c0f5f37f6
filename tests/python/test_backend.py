"""The build backend of bindings/python, without its compiler. run_wheel.py installs the package with it."""
import base64
import csv
import hashlib
import importlib.util
import io
import shutil
import sys
import zipfile

import gltf_psplit
import pytest
from conftest import ROOT

pytestmark = pytest.mark.decoder


@pytest.fixture
def backend():
    if sys.version_info < (3, 11):
        pytest.importorskip("tomli")
    spec = importlib.util.spec_from_file_location("build_backend", ROOT / "bindings" / "python" / "build_backend.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_only_what_is_missing_comes_from_an_index(backend, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda tool: f"/usr/bin/{tool}")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    assert backend.get_requires_for_build_wheel() == []
    monkeypatch.setattr(shutil, "which", lambda tool: None)
    assert backend.get_requires_for_build_wheel() == ["cmake>=3.22", "ninja>=1.10"]


def configured(backend, monkeypatch):
    """The arguments of CMake."""
    commands = []

    class Done:
        returncode = 0

    with monkeypatch.context() as patched:
        patched.delenv("CMAKE_ARGS", raising=False)
        patched.setattr(backend.subprocess, "run", lambda command, check: commands.append(command) or Done)
        assert backend.configure("build", "ON")
    return commands[0]


def test_flags_of_the_environment_are_kept(backend, monkeypatch):
    """CMake takes them from LDFLAGS and CXXFLAGS, as long as no argument replaces them."""
    command = configured(backend, monkeypatch)
    assert "-DPSPLIT_STRIP_PYTHON=ON" in command and not [argument for argument in command if "_FLAGS" in argument]


@pytest.mark.parametrize("system, wanted, oldest", [("14.5", None, "14.0"), ("14.5", "11.0", "11.0"), ("10.15.7", None, "10.15")])
def test_a_wheel_for_macos_is_for_one_architecture(backend, monkeypatch, system, wanted, oldest):
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(backend.platform, "mac_ver", lambda: (system, ("", "", ""), "arm64"))
    monkeypatch.setattr(backend.platform, "machine", lambda: "arm64")
    monkeypatch.setattr(backend.sysconfig, "get_platform", lambda: "macosx-10.9-universal2")
    monkeypatch.delenv("MACOSX_DEPLOYMENT_TARGET", raising=False)
    if wanted:
        monkeypatch.setenv("MACOSX_DEPLOYMENT_TARGET", wanted)
    assert backend.tag().endswith(f"-macosx_{oldest.replace('.', '_')}_arm64")
    command = configured(backend, monkeypatch)
    assert {f"-DCMAKE_OSX_DEPLOYMENT_TARGET={oldest}", "-DCMAKE_OSX_ARCHITECTURES=arm64"} < set(command)


def test_wheel(backend, monkeypatch, tmp_path):
    module = tmp_path / "_native.so"
    module.write_bytes(b"a module")
    monkeypatch.setattr(backend, "build_module", lambda: module)
    (tmp_path / "again").mkdir()
    name = backend.build_wheel(tmp_path)
    assert name.startswith(f"gltf_psplit-{gltf_psplit.__version__}-cp") and name.endswith(".whl")
    assert (tmp_path / backend.build_wheel(tmp_path / "again")).read_bytes() == (tmp_path / "again" / name).read_bytes()
    with zipfile.ZipFile(tmp_path / name) as wheel:
        assert {entry.external_attr >> 16 for entry in wheel.infolist()} == {0o644}
        files = {file: wheel.read(file) for file in wheel.namelist()}
    record = f"gltf_psplit-{gltf_psplit.__version__}.dist-info/RECORD"
    listed = {row[0]: row[1:] for row in csv.reader(io.StringIO(files[record].decode()))}
    assert set(listed) == set(files) and listed.pop(record) == ["", ""]
    for file, (digest, size) in listed.items():
        expected = base64.urlsafe_b64encode(hashlib.sha256(files[file]).digest()).rstrip(b"=").decode()
        assert digest == f"sha256={expected}" and int(size) == len(files[file])
    assert {"gltf_psplit/_native.so", "gltf_psplit/__init__.py", "gltf_psplit/py.typed"} < set(files)
    metadata = backend.prepare_metadata_for_build_wheel(tmp_path)
    for file in ("METADATA", "WHEEL", "LICENSE"):
        assert (tmp_path / metadata / file).read_bytes() == files[f"{metadata}/{file}"]
    assert "Name: gltf-psplit\n" in files[f"{metadata}/METADATA"].decode()
