#!/usr/bin/env python3
"""The package of bindings/csharp, compiled and run by Mono:

  csharp_test.py --source FOLDER --library libpsplit.so --build FOLDER

Compiles the library with warnings as errors, runs its tests, which compare the declarations with psplit.h and tests/c/abi.txt,
compiles the example for SharpGLTF against declarations of it and the code of the pages, and checks the package's description. Exits with 77 if there is
no mcs or no mono.
"""
import argparse, os, pathlib, re, shutil, subprocess, sys
from xml.etree import ElementTree

parser = argparse.ArgumentParser()
for name in ("source", "library", "build"):
    parser.add_argument("--" + name, type=lambda path: pathlib.Path(path).resolve(), required=True)
options = parser.parse_args()
for program in ("mcs", "mono"):
    if not shutil.which(program):
        print(f"skipped: there is no {program} (Debian's packages mono-mcs and mono-runtime)")
        sys.exit(77)
package = options.source / "bindings/csharp"
tests = options.source / "tests/csharp"
options.build.mkdir(parents=True, exist_ok=True)
sys.dont_write_bytecode = True
sys.path.insert(0, str(options.source / "tests/docs"))
from pages import blocks


def run(*command, fails=False, **more):
    done = subprocess.run([str(part) for part in command], cwd=options.build, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **more)
    if (done.returncode != 0) != fails:
        sys.exit(f"{' '.join(map(str, command))}: {done.returncode}\n{done.stdout}")
    return done.stdout


def compile(output, *arguments):
    run("mcs", "-nologo", "-unsafe", "-langversion:7.2", "-warn:4", "-warnaserror", f"-out:{output}", *arguments)


environment = os.environ | {"LD_LIBRARY_PATH": str(options.library.parent), "DYLD_LIBRARY_PATH": str(options.library.parent)}
header = options.source / "include/psplit/psplit.h"
samples = options.source / "gltf_ext/PSPLIT_mesh_draco_patches/samples"


def run_tests(header, **more):
    # A thread that keeps Mono alive would make it wait forever.
    return run("mono", "--debug", "Tests.exe", header, options.source / "tests/c/abi.txt", samples, env=environment, timeout=300, **more)


compile("GltfPsplit.dll", "-target:library", *sorted((package / "GltfPsplit").glob("*.cs")))
compile("Tests.exe", "-r:GltfPsplit.dll", tests / "Tests.cs")
compile("SharpGltfExample.exe", "-r:GltfPsplit.dll", "-r:System.Numerics", tests / "SharpGltfStub.cs", *(package / "examples").glob("*.cs"))
# The code of the pages compiles: each block is a function, with arguments for names that it does not declare.
functions = []
for block in [*blocks("docs/csharp.md"), *blocks("bindings/csharp/README.md")]:
    if block.language == "csharp":
        code = block.code.replace("using GltfPsplit;", "").replace("= ...;", "= default;")
        arguments = {"mesh": "CompressedMesh", "indices": "uint[]", "positions": "Vector3[]", "texcoords": "Vector2[]"}
        taken = [f"{kind} {name}" for name, kind in arguments.items() if not re.search(rf"[\]>]\s{name} =|var {name} =", code)]
        functions.append(f'static void Page{len(functions)}({", ".join(taken)}) {{\n#line {block.line} "{block.page}"\n{code}\n}}')
if len(functions) < 4:
    sys.exit(f"the pages have {len(functions)} blocks of C#")
(options.build / "Pages.cs").write_text("using System; using System.IO; using System.Numerics; using GltfPsplit;\nstatic class Pages {\n"
                                        + "\n".join(functions) + "\n}\n")
compile("Pages.dll", "-target:library", "-r:GltfPsplit.dll", "-r:System.Numerics", "-nowarn:219", "Pages.cs")
said = run_tests(header)
passed = int(re.search(r"(\d+) passed, 0 failed", said).group(1))

# A function of the header with another parameter fails the test that compares them.
folder = options.build / "other_header"
folder.mkdir(exist_ok=True)
shutil.copy(header.with_name("version.h"), folder)
text = header.read_text()
changed = text.replace("psplit_mesh_free(psplit_mesh* mesh)", "psplit_mesh_free(psplit_mesh* mesh, int32_t added)")
assert changed != text
(folder / "psplit.h").write_text(changed)
assert "FAILED FunctionsAreThoseOfC" in run_tests(folder / "psplit.h", fails=True)

# What the package has: files of the source tree, and what `dotnet pack` builds in its own folders.
namespace = "{http://schemas.microsoft.com/packaging/2013/05/nuspec.xsd}"
description = ElementTree.parse(package / "GltfPsplit.nuspec").getroot()
files = [file.get("src") for file in description.iter(namespace + "file")]
missing = [file for file in files if not file.startswith("bin/Release/netstandard2.1/") and not (package / file).exists()]
project = ElementTree.parse(package / "GltfPsplit.csproj").getroot()
if missing or len(files) < 3 or project.find(".//NuspecFile").text != "GltfPsplit.nuspec":
    sys.exit(f"GltfPsplit.nuspec names files that do not exist: {missing}")
print(f"{passed} tests in {run('mono', '--version').splitlines()[0]}")
