#!/usr/bin/env python3
"""The code of the pages compiles:  code_test.py CXX

C++ in README.md and docs/*.md is compiled against include/, without object files. C that is called from Go is looked up in psplit.h,
imports of JavaScript in the package's files, and names in sentences (`psplit::Mesh`) in the headers. JSON and TOML are parsed. Other
tests run all other code: kElsewhere says which. Exits with 77 if a compiler is absent.
"""
import json, pathlib, re, shutil, subprocess, sys, tempfile

from pages import blocks, inline_code, pages, root, text_of

try:
    import tomllib
except ImportError:  # before Python 3.11
    tomllib = None

compiler = sys.argv[1]
# {(language, page): the test that runs the code}. In other pages of that language each block is a failure.
kElsewhere = {
    ("js", "bindings/web/README.md"): "tests/web/readme_test.mjs",
    ("ts", "bindings/web/README.md"): "tests/web/readme_test.mjs",
    ("tsx", "bindings/web/README.md"): "tests/web/readme_test.mjs",
    ("html", "bindings/web/README.md"): "tests/web/readme_test.mjs",
    ("python", "docs/python.md"): "tests/python/test_page.py",
    ("py", "bindings/python/README.md"): "tests/python/test_page.py",
    ("csharp", "docs/csharp.md"): "tests/csharp/csharp_test.py",
    ("csharp", "bindings/csharp/README.md"): "tests/csharp/csharp_test.py",
    ("rust", "docs/rust.md"): "tests/rust/rust_test.py",
    ("rust", "bindings/rust/gltf-psplit/README.md"): "tests/rust/rust_test.py",
}
# Pages with blocks of no language: pictures, layouts, output and headers of HTTP.
kPlain = {"docs/architecture.md", "gltf_ext/PSPLIT_mesh_draco_patches/README.md", "bindings/web/README.md"}

# What the C++ of a page stands in: {page: (headers, declarations at the top of a function)}.
kAround = {
    "README.md": ("#include <psplit/psplit.h>\n#include <psplit/tinygltf.h>\n#include <psplit/draco_decoder.h>\n#include <psplit/document.h>\n"
                  "#include <psplit/gltf.h>\n#include <psplit/psplit.hpp>",
                  "tinygltf::Model model; psplit::Expected<psplit::Document> document = psplit::read_document(\"a.glb\"); psplit::ThreadPool pool;"
                  "psplit_mesh* mesh = nullptr; psplit_buffers buffers{}; psplit_error error{}; psplit::CudaBatch* one = nullptr; auto& batch = *one;"
                  "CUstream_st* stream = nullptr;"),
    "docs/cuda.md": ("",
                     "psplit::Span<const uint8_t> bytes; std::vector<psplit::AttributeRequest> attributes; void *indices = nullptr, *positions = nullptr, *scratch = nullptr;"
                     "std::vector<psplit::CudaPrimitive> primitives; uint64_t scratch_bytes = 0; CUstream_st* stream = nullptr;"),
    "docs/libdraco.md": ("#include <draco/compression/decode.h>", "draco::DecoderBuffer buffer;"),
}


def compile_cpp(page, codes):
    """Compiles all C++ of a page, each block in the scope of those before it."""
    headers, declarations = kAround[page]
    includes, scopes = [], ""
    for line, code in codes:
        includes += re.findall(r"^#include .*$", code, re.M)
        scopes += f'{{\n#line {line} "{page}"\n{re.sub("^#include .*$", "", code, flags=re.M)}\n'
    text = "\n".join([*includes, headers, f"int page() {{ {declarations}", scopes + "}" * len(codes), "return 0; }\n"])
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "page.cpp")
        file.write_text(text)
        done = subprocess.run([compiler, "-std=c++17", "-fsyntax-only", "-w", f"-I{root / 'include'}", file], capture_output=True, text=True)
    return done.stderr if done.returncode else None


def absent_header(page):
    """The header of another project that a page's C++ needs and this machine lacks."""
    text = kAround[page][0] + text_of(page)
    for ours, header in (("psplit/tinygltf.h", "tiny_gltf.h"), ("psplit/draco_decoder.h", "draco/compression/decode.h")):
        if ours in text and subprocess.run([compiler, "-E", "-x", "c++", "-include", header, "/dev/null"], capture_output=True).returncode:
            return header


def check_cpp(bad, skipped):
    count = 0
    for page in pages():
        codes = [(block.line, block.code) for block in blocks(page) if block.language == "cpp"]
        if page == "README.md":  # the table of interfaces
            codes = [(line, code) for line, code in inline_code(page) if re.search(r"psplit_mesh_|psplit::\w+\(|psplit::\w+ \w+;|batch\.", code)]
        if not codes:
            continue
        if page not in kAround:
            bad.append(f"{page}: kAround of {sys.argv[0]} lacks what its C++ stands in")
        elif header := absent_header(page):
            skipped.append(f"{page}, because there is no {header}")
        elif error := compile_cpp(page, codes):
            bad.append(error)
        count += len(codes)
    return count


def check_javascript(block, bad):
    for names, module in re.findall(r"import \{([^}]*)\} from 'psplit/?([\w-]*)'", block.code):
        source = (root / f"bindings/web/js/{module or 'index'}.js").read_text()
        for name in re.findall(r"\w+", names):
            if not re.search(rf"export [^;]*\b{name}\b", source):
                bad.append(f"{block}: psplit/{module} has no {name}")
    if shutil.which("node"):
        done = subprocess.run(["node", "--input-type=module", "--check"], input=block.code, capture_output=True, text=True)
        if done.returncode:
            bad.append(f"{block}: {done.stderr}")


def main():
    bad, skipped = [], []
    header = (root / "include/psplit/psplit.h").read_text()
    headers = "\n".join(path.read_text() for path in (root / "include/psplit").glob("*.h*")) + (root / "cmake/psplit-config.cmake.in").read_text()
    headers += "\n".join(path.read_text() for path in (root / "gltf_ext").rglob("*.h")) + "\n".join(
        path.read_text() for folder in ("src", "encoder") for path in (root / folder).rglob("*.h"))
    count = check_cpp(bad, skipped)
    for page in pages():
        for block in blocks(page):
            count += 1
            if block.language in ("sh", "text", "cpp"):
                continue  # commands_test.py, and above
            if elsewhere := kElsewhere.get((block.language, page)):
                if not re.search(rf"{page}|readme_blocks", (root / elsewhere).read_text()):
                    bad.append(f"{block}: {elsewhere} does not read the page")
            elif block.language == "json":
                try:
                    json.loads(block.code)
                except ValueError as error:
                    bad.append(f"{block}: {error}")
            elif block.language == "toml":
                try:
                    tomllib and tomllib.loads(block.code)
                except ValueError as error:
                    bad.append(f"{block}: {error}")
            elif block.language == "go":  # Debian's Go is no package of the tests
                bad += [f"{block}: psplit.h has no {name}" for name in re.findall(r"\bC\.(?:sizeof_)?((?:psplit|PSPLIT)_\w+)", block.code)
                        if not re.search(rf"\b{name}\b", header)]
            elif block.language == "js":
                check_javascript(block, bad)
            elif block.language or page not in kPlain:
                bad.append(f"{block}: nothing checks the language {block.language!r}")
        if page not in ("CHANGELOG.md", "docs/decisions.md", "docs/performance.md"):
            for line, code in inline_code(page):
                bad += [f"{page}:{line}: no header has {name}" for name in re.findall(r"\bpsplit::(\w+)|\b(psplit_[a-z_]+\b(?=\())", code)
                        for name in name if name and not re.search(rf"\b{name}\b", headers)]
    if bad:
        sys.exit("\n".join(bad))
    print("\n".join([*(f"skipped: {what}" for what in skipped), f"{count} blocks"]))
    if skipped:
        sys.exit(77)


main()
