"""Type checkers see what a call takes and gives: mypy, and pyright where there is one."""
import ast
import json
import pathlib
import re
import shutil
import subprocess
import sys

import gltf_psplit
import pytest

PROGRAM = pathlib.Path(__file__).resolve().with_name("typed_program.py")
PACKAGE = pathlib.Path(gltf_psplit.__file__).resolve().parent
WRONG = {number for number, line in enumerate(PROGRAM.read_text().splitlines(), 1) if line.endswith("# wrong")}


@pytest.fixture
def copied(tmp_path):
    """The program beside the package, where checkers take its types."""
    shutil.copytree(PACKAGE, tmp_path / "gltf_psplit", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(PROGRAM, tmp_path)
    return tmp_path


def test_mypy(copied):
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "-p", "gltf_psplit", "-m", PROGRAM.stem], cwd=copied,
                          capture_output=True, text=True)
    found = {int(number): line for line in done.stdout.splitlines() for number in re.findall(r"program\.py:(\d+): error", line)}
    assert set(found) == WRONG, found


def test_pyright(copied):
    if shutil.which("pyright") is None:
        pytest.skip("there is no pyright")
    done = subprocess.run(["pyright", "--pythonpath", sys.executable, "--outputjson", "."], cwd=copied, capture_output=True, text=True)
    found = [error for error in json.loads(done.stdout)["generalDiagnostics"] if error["severity"] == "error"]
    assert {(pathlib.Path(error["file"]).name, error["range"]["start"]["line"] + 1) for error in found} == {
        (PROGRAM.name, number) for number in WRONG}, found


def parameters_of(function):
    """The names in the signature that pybind11 writes, such as "f(data: object, threads: int) -> tuple"."""
    names = re.findall(r"(\w+): ", function.__doc__.splitlines()[0].partition("(")[2].rpartition(")")[0])
    return [name for name in names if name != "self"]


def test_stub_of_the_module():
    """Names and parameters of _native.pyi are those of the module. It has no others."""
    stub = ast.parse((PACKAGE / "_native.pyi").read_text())

    def compare(body, of):
        functions = {node.name: [argument.arg for argument in node.args.args if argument.arg != "self"]
                     for node in body if isinstance(node, ast.FunctionDef)}
        real = {name: value for name, value in vars(of).items() if callable(value) and not isinstance(value, type)}
        present = {name for name in real if not name.startswith("_") or name in functions}
        assert set(functions) == present
        for name in present:
            assert functions[name] == parameters_of(real[name]), name

    if hasattr(gltf_psplit._native, "encode"):
        compare(stub.body, gltf_psplit._native)
        kind, = (node for node in stub.body if isinstance(node, ast.ClassDef))
        compare(kind.body, gltf_psplit._native.Asset)
