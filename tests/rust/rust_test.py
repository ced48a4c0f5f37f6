#!/usr/bin/env python3
"""The crates of bindings/rust, as a user of the library builds them, without a network:

  rust_test.py --source FOLDER --library libpsplit.so --build FOLDER

Runs their tests and the example; compiles the code of the pages; compiles them with pkg-config in place of PSPLIT_LIB_DIR; packages both crates, and compiles
what was packaged; and shows that a header that differs fails. Exits with 77 if there is no rustc or no cargo.
"""
import argparse, hashlib, json, os, pathlib, shutil, subprocess, sys, tarfile

parser = argparse.ArgumentParser()
for name in ("source", "library", "build"):
    parser.add_argument("--" + name, type=lambda path: pathlib.Path(path).resolve(), required=True)
options = parser.parse_args()
for program in ("rustc", "cargo"):
    if not shutil.which(program):
        print(f"skipped: there is no {program} (Debian's packages rustc and cargo)")
        sys.exit(77)

samples = options.source / "gltf_ext/PSPLIT_mesh_draco_patches/samples"
libraries = options.library.parent
crates = options.build / "crates"
shutil.rmtree(crates, ignore_errors=True)
# A copy, because cargo writes beside its sources.
shutil.copytree(options.source / "bindings/rust", crates, ignore=shutil.ignore_patterns("target", "Cargo.lock"))
base = {key: value for key, value in os.environ.items() if not key.startswith(("PSPLIT_", "CARGO_TARGET", "PKG_CONFIG"))}
base |= {"CARGO_TARGET_DIR": str(options.build / "target"), "PSPLIT_SAMPLES": str(samples), "CARGO_NET_OFFLINE": "true",
         "LD_LIBRARY_PATH": str(libraries), "DYLD_LIBRARY_PATH": str(libraries), "RUSTFLAGS": "-D warnings"}
by_folder = base | {"PSPLIT_LIB_DIR": str(libraries), "PSPLIT_INCLUDE_DIR": str(options.source / "include")}


def cargo(*arguments, environment=by_folder, fails=False):
    done = subprocess.run(["cargo", *arguments], cwd=crates, env=environment, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if (done.returncode != 0) != fails:
        sys.exit(f"cargo {' '.join(arguments)}: {done.returncode}\n{done.stdout}")
    return done.stdout


def write_pages():
    """A test of the crate with the code of the pages, which compiles: each block is a function."""
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(options.source / "tests/docs"))
    from pages import blocks
    found = [block for page in ("docs/rust.md", "bindings/rust/gltf-psplit/README.md") for block in blocks(page) if block.language == "rust"]
    assert len(found) >= 3, found
    arguments = "indices: Vec<u32>, point_count: u32, positions: Vec<f32>, texcoords: Vec<f32>"
    functions = [f"// {block}\npub fn page_{i}({arguments}) -> Result<(), Box<dyn std::error::Error>> {{\n{block.code}\nOk(())\n}}\n"
                 for i, block in enumerate(found)]
    (crates / "gltf-psplit/tests/pages.rs").write_text("#![allow(unused)]\n" + "\n".join(functions))


def passed(output):
    return sum(int(line.split("ok. ")[1].split()[0]) for line in output.splitlines() if line.startswith("test result: ok. "))


def header_that_differs():
    """A member more in a struct of the header fails the test that compares them."""
    folder = options.build / "other_header/psplit"
    shutil.rmtree(folder.parent, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copy(options.source / "include/psplit/version.h", folder)
    header = (options.source / "include/psplit/psplit.h").read_text()
    changed = header.replace("  uint32_t index_size; ", "  uint32_t added;\n  uint32_t index_size; ", 1)
    assert changed != header
    (folder / "psplit.h").write_text(changed)
    output = cargo("test", "-q", "--test", "header", environment=by_folder | {"PSPLIT_INCLUDE_DIR": str(folder.parent)}, fails=True)
    assert "added: u32" in output and "only in C" in output, output


def by_pkg_config():
    folder = options.build / "pkgconfig"
    folder.mkdir(exist_ok=True)
    (folder / "psplit.pc").write_text(f"libdir={libraries}\nincludedir={options.source / 'include'}\nName: psplit\nDescription: psplit\n"
                                      "Version: 0.1\nLibs: -L${libdir} -lpsplit\n")
    environment = base | {"PKG_CONFIG_PATH": str(folder), "CARGO_TARGET_DIR": str(options.build / "target_pkg_config")}
    cargo("test", "-q", "--test", "header", environment=environment)
    output = cargo("build", environment=environment | {"PKG_CONFIG": "no-such-program"}, fails=True)
    assert "libpsplit was not found: no-such-program" in output and "PSPLIT_LIB_DIR" in output, output


def packages():
    """Packages both crates. The second finds the first in a folder that takes the place of crates.io."""
    index, target = options.build / "index", options.build / "target_package"
    for folder in (index, target):  # cargo takes a crate of a registry for what it was when it was compiled last
        shutil.rmtree(folder, ignore_errors=True)
    index.mkdir()
    in_place = ("--config", "source.crates-io.replace-with='packaged'", "--config", f"source.packaged.directory='{index}'")
    for name in ("gltf-psplit-sys", "gltf-psplit"):
        cargo("package", "--offline", "--allow-dirty", "-p", name, *in_place, environment=by_folder | {"CARGO_TARGET_DIR": str(target)})
        packed, = (target / "package").glob(f"{name}-[0-9]*.crate")
        with tarfile.open(packed) as archive:
            files = archive.getnames()
            archive.extractall(index)
        for file in ("README.md", "LICENSE", "src/lib.rs"):
            assert f"{packed.stem}/{file}" in files, files
        assert "Apache License" in (index / packed.stem / "LICENSE").read_text()
        checksum = {"files": {}, "package": hashlib.sha256(packed.read_bytes()).hexdigest()}
        (index / packed.stem / ".cargo-checksum.json").write_text(json.dumps(checksum))


write_pages()
count = passed(cargo("test", "--offline"))
assert count > 15, count
example = cargo("run", "-q", "--offline", "--example", "decode_glb", str(samples / "patches.glb"))
assert example.startswith("1222 triangles, 663 points: POSITION from (-0.63615763"), example
header_that_differs()
if shutil.which("pkg-config"):
    by_pkg_config()
packages()
print(f"{count} tests of {subprocess.check_output(['rustc', '--version'], text=True).strip()}, and two packages")
