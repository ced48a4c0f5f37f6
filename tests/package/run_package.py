#!/usr/bin/env python3
"""Installs psplit as static and as shared libraries. Builds and runs gltf_ext/examples as a project that finds it, as one
that brings its sources, and with pkg-config:

  run_package.py --source FOLDER --build FOLDER --psplit COMMAND --cmake COMMAND --compiler COMMAND --shared ON|OFF

--build is a finished build, of static or shared libraries as --shared says. The other kind is built in its folder
other_libraries, without the command and the tests; the wheel is built there afterwards, of the same objects. All else is made
in package_test, which stays if something fails. Both have the same names each time, so that a compiler cache finds what it
compiled. The project has a folder src of its own, from which no header of ours
may be taken. c/examples is a project in C, which finds it and uses pkg-config.
"""
import argparse, json, os, pathlib, re, shutil, struct, subprocess, sys

parser = argparse.ArgumentParser()
for name in ("source", "build", "psplit", "cmake", "compiler", "shared"):
    parser.add_argument("--" + name, required=True)
options = parser.parse_args()
source = pathlib.Path(options.source)


def run(*command, code=0):
    return run_with(None, *command, code=code)


def run_with(variables, *command, code=0):
    done = subprocess.run([str(part) for part in command], env=variables, capture_output=True, text=True)
    if done.returncode != code:
        sys.exit(f"{' '.join(map(str, command))}\nexits with {done.returncode}:\n{done.stdout[-6000:]}{done.stderr[-6000:]}")
    return done.stdout + done.stderr


def expect(what, pattern, said):
    if not re.search(pattern, said):
        sys.exit(f"{what} says {said!r}, not {pattern!r}")


def configure(folder, build, *definitions):
    run(options.cmake, "-G", "Ninja", "-S", folder, "-B", build, "-DCMAKE_BUILD_TYPE=Release",
        f"-DCMAKE_CXX_COMPILER={options.compiler}", *definitions)


def stock_stream(asset):
    """The only Draco stream of a GLB with KHR_draco_mesh_compression."""
    file = asset.read_bytes()
    json_bytes = struct.unpack_from("<I", file, 12)[0]
    document = json.loads(file[20:20 + json_bytes])
    extension = document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
    view = document["bufferViews"][extension["bufferView"]]
    return file[28 + json_bytes + view.get("byteOffset", 0):][:view["byteLength"]]


def make_project(folder):
    """gltf_ext/examples as a user's project, whose own headers have names of ours."""
    folder.mkdir(parents=True)
    for name in ("base.h", "mesh.h", "parallel.h", "version.h"):
        (folder / name).write_text(f'#error "the user\'s own {name} was taken for ours"\n')
    for file in (source / "gltf_ext" / "examples").iterdir():
        (folder / file.name).write_text(file.read_text())


def run_examples(kind, examples, assets):
    model = run(examples / "print_model", assets["patches"])
    expect("print_model", r"^2\d{4} triangles, \d+ POSITION from \(", model)
    stock = run(examples / "print_model", assets["stock"])
    expect("print_model of stock Draco", r"^2\d{4} triangles, \d+ POSITION from \(", stock)
    drc = run(examples / "decode_draco", assets["drc"])
    expect("decode_draco", r"^2\d{4} triangles, \d+ points: POSITION from \(", drc)
    libdraco = run(examples / "decode_with_libdraco", assets["drc"])
    # All count the same.
    if len({tuple(re.findall(r"\d+", said.split("from")[0])[:2]) for said in (model, stock, drc, libdraco)}) != 1:
        sys.exit(f"{kind}: {model}{stock}{drc}{libdraco}")
    patch = run(examples / "one_patch", assets["patches"], 3)
    expect("one_patch", r"^patch 3 of 5: \d+ triangles, \d+ points, largest index \d+, from \(", patch)
    points, largest = map(int, re.search(r"(\d+) points, largest index (\d+)", patch).groups())
    if largest + 1 != points:
        sys.exit(f"one_patch: {patch}")
    run(examples / "one_patch", assets["patches"], 5, code=3)
    run(examples / "print_model", source / "README.md", code=3)
    run(examples / "decode_draco", source / "README.md", code=3)
    # The device's first point is the host's.
    gpu = subprocess.run([examples / "load_to_gpu", assets["patches"]], capture_output=True, text=True)
    if gpu.returncode == 5:
        expect("load_to_gpu", "no CUDA device to decode on: ", gpu.stderr)
        device = gpu.stderr.strip().rsplit(": ", 1)[-1]
    else:
        point = re.escape(re.search(r"from \(.*\)", model).group())
        expect("load_to_gpu", r"2\d{4} triangles, \d+ points on the device " + point, gpu.stdout)
        device = "on the device too"
    print(f"{kind}: {model.strip()}; {patch.strip()}; {drc.strip()}; GPU: {device}")


def run_encoders(kind, examples, assets, folder):
    """What the examples of psplit::encoder and psplit::gltf write is what the command writes."""
    expect("encode_mesh", r"^7 patches, \d+ bytes: 24000 triangles, 12221 points$", run(examples / "encode_mesh", 7))
    written, wanted = folder / "example.glb", folder / "command.glb"
    said = run(examples / "encode_gltf", assets["plain"], written, 4000)
    expect("encode_gltf", r"^mesh 0, primitive 0: 5 patches, \d+ bytes\n", said)
    run(options.psplit, "encode", "-q", "--patch-faces", 4000, assets["plain"], wanted)
    if written.read_bytes() != wanted.read_bytes():
        sys.exit(f"{kind}: encode_gltf and gltf-psplit write different files")
    run(examples / "encode_gltf", source / "README.md", written, code=3)
    print(f"{kind}: {said.strip()}")


def pkg_config_variables(prefix):
    paths = sorted({str(file.parent) for file in prefix.rglob("psplit*.pc")})
    return dict(os.environ, PKG_CONFIG_PATH=":".join(paths))


def run_c(kind, examples, assets):
    """The examples in C say the same of a mesh in all its forms."""
    counts = set()
    for asset in ("patches", "stock", "drc"):
        said = run(examples / "decode_glb", assets[asset])
        expect(f"decode_glb of {asset}", r"^2\d{4} triangles, \d+ points: POSITION from \(", said)
        counts.add(tuple(re.findall(r"\d+", said)[:2]))
    if len(counts) != 1:
        sys.exit(f"{kind}: decode_glb counts {counts}")
    run(examples / "decode_glb", source / "README.md", code=3)
    expect("encode_mesh", r"^7 patches, \d+ bytes: 24000 triangles, 12221 points$", run(examples / "encode_mesh", 7))
    print(f"{kind}: {said.strip()}")


def check_c(kind, prefix, folder, assets):
    """Builds c/examples with the installed library, as a project of CMake in C alone and with pkg-config."""
    build = folder / "c-examples"
    run(options.cmake, "-G", "Ninja", "-S", source / "bindings/c/examples", "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}",
        "-DCMAKE_C_FLAGS=-Wall -Wextra -pedantic -Werror")
    run(options.cmake, "--build", build)
    run_c(f"{kind}, C", build, assets)
    if not shutil.which("pkg-config"):
        return
    build = folder / "c-pkg-config"
    build.mkdir()
    flags = run_with(pkg_config_variables(prefix), "pkg-config", "--cflags", "--libs", "psplit").split()
    library = next(prefix.rglob("libpsplit.so")).parent
    for name in ("decode_glb", "encode_mesh"):
        run("cc", "-std=c99", "-o", build / name, source / "bindings/c/examples" / f"{name}.c", *flags, f"-Wl,-rpath,{library}")
    run_c(f"{kind}, C, pkg-config", build, assets)


def check_pkg_config(kind, prefix, folder, assets):
    """The examples that need neither tinygltf nor CUDA, compiled by pkg-config's flags alone."""
    if not shutil.which("pkg-config"):
        print("pkg-config is not installed: its files are not tested")
        return
    folder.mkdir()
    variables = pkg_config_variables(prefix)
    for name, package in (("decode_draco", "psplit-decoder"), ("encode_mesh", "psplit-encoder"), ("encode_gltf", "psplit-gltf")):
        flags = run_with(variables, "pkg-config", "--cflags", "--libs", package)
        library = next(prefix.rglob("libpsplit_decoder.*")).parent
        run(options.compiler, "-std=c++20", "-o", folder / name, source / "gltf_ext" / "examples" / f"{name}.cpp",
            *flags.split(), f"-Wl,-rpath,{library}")
    run(folder / "decode_draco", assets["drc"])
    # libdraco itself is not needed by psplit-decoder, and may be the static library.
    flags = run_with(variables, "pkg-config", "--cflags", "--libs", "psplit-decoder")
    run(options.compiler, "-std=c++20", "-o", folder / "decode_with_libdraco", source / "gltf_ext/examples/decode_with_libdraco.cpp",
        *flags.split(), "-l:libdraco.a", f"-Wl,-rpath,{library}")
    run(folder / "decode_with_libdraco", assets["drc"])
    check_libdraco(variables, folder, assets)
    run_encoders(kind + ", pkg-config", folder, assets, folder)


def check_libdraco(variables, folder, assets):
    """A program that uses libdraco's own names, linked with psplit-draco's flags: psplit decodes for it."""
    if subprocess.run(["pkg-config", "--exists", "psplit-draco"], env=variables).returncode != 0:
        print("psplit was built without a shared libdraco: psplit-draco.pc is not tested")
        return
    program = folder / "by_libdraco.cpp"
    program.write_text("""#include <draco/compression/decode.h>
#include <fstream>
#include <iterator>
int main(int, char** argv) {
  std::ifstream file(argv[1], std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  return decoder.DecodeMeshFromBuffer(&buffer).ok() ? 0 : 1;
}
""")
    flags = run_with(variables, "pkg-config", "--cflags", "--libs", "psplit-draco").split()
    library = run_with(variables, "pkg-config", "--variable=libdir", "psplit-draco").strip()
    run(options.compiler, "-std=c++17", "-w", "-o", folder / "by_libdraco", program, "-Wl,--as-needed", *flags, f"-Wl,-rpath,{library}")
    said = run_with(variables | {"PSPLIT_DRACO": "verbose"}, folder / "by_libdraco", assets["drc"])
    expect("a program with psplit-draco", r"psplit_draco: .* psplit\n", said)


def check_uninstall(build, prefix):
    installed = [path for path in prefix.rglob("*") if not path.is_dir()]
    run(options.cmake, "--build", build, "--target", "uninstall")
    left = [path for path in prefix.rglob("*") if not path.is_dir() or path.name == "psplit"]
    if left or len(installed) < 20:
        sys.exit(f"{len(installed)} files are installed, and these stay: {left}")


def check(kind, prefix, folder, assets):
    """Builds the examples against what is installed, and runs them."""
    make_project(folder / "project")
    configure(folder / "project", folder / "examples", f"-DCMAKE_PREFIX_PATH={prefix}", user_flags(folder),
              "-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG")
    run(options.cmake, "--build", folder / "examples")
    run_examples(kind, folder / "examples", assets)
    run_encoders(kind, folder / "examples", assets, folder)
    check_pkg_config(kind, prefix, folder / "pkg-config", assets)
    check_c(kind, prefix, folder, assets)


def user_flags(folder):
    return f"-DCMAKE_CXX_FLAGS=-I{folder / 'project'} -Wall -Wextra -Wconversion -Wshadow -Werror"


def check_headers(prefix):
    """Each installed header compiles alone, and all together in C++17 and C++20 by each compiler that is here. Their comments name
    installed headers only. psplit.h is C."""
    warnings = ("-fsyntax-only", "-Wall", "-Wextra", "-pedantic")
    include = prefix / "include"
    headers = {path.relative_to(include / "psplit").as_posix(): path.read_text() for path in sorted(include.rglob("*.h*"))}
    for name, text in headers.items():
        run(options.compiler, "-std=c++17", *warnings, f"-I{include}", "-include", f"psplit/{name}", "-x", "c++", "/dev/null")
        for word in re.findall(r"([\w/]+\.h(?:pp)?)\b", "\n".join(re.findall(r"//.*", text))):
            wanted = "/" + word.removeprefix("psplit/")
            if word != "tiny_gltf.h" and not any(f"/{header}".endswith(wanted) for header in headers):
                sys.exit(f"{name} names {word}, which is not installed")
    every = [word for name in headers for word in ("-include", f"psplit/{name}")]
    for compiler in {options.compiler, *filter(None, map(shutil.which, ("g++", "clang++")))}:
        for standard in ("c++17", "c++20"):
            run(compiler, f"-std={standard}", *warnings, f"-I{include}", *every, "-x", "c++", "/dev/null")
    for language, standard in (("c", "c99"), ("c", "c17"), ("c++", "c++11")):
        run(options.compiler, f"-std={standard}", "-fsyntax-only", "-Wall", "-Wextra", "-pedantic", "-Werror", f"-I{include}",
            "-include", "psplit/psplit.h", "-x", language, "/dev/null")
    included = set(re.findall(r'#include "psplit/(\S+)"', headers["psplit.hpp"]))
    if missing := set(headers) - included - {"draco_decoder.h", "psplit.h", "psplit.hpp", "tinygltf.h"}:
        sys.exit(f"psplit.hpp does not include {missing}")
    print(f"{len(headers)} headers")


def check_reasons(prefix, folder):
    """A component that is not there says what it lacks."""
    def said_without(package, components):
        folder.mkdir(exist_ok=True)
        (folder / "CMakeLists.txt").write_text(f"""cmake_minimum_required(VERSION 3.22)
project(reasons LANGUAGES CXX)
find_package(psplit REQUIRED COMPONENTS {components})
""")
        return run(options.cmake, "-G", "Ninja", "-S", folder, "-B", folder / f"without-{package}-{len(components)}",
                   f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={options.compiler}",
                   f"-DCMAKE_DISABLE_FIND_PACKAGE_{package}=ON", code=1)

    tinygltf = said_without("TinyGLTF", "decoder tinygltf")
    expect("tinygltf without TinyGLTF", r"psplit::tinygltf: no CMake package TinyGLTF was found", tinygltf)
    if "psplit::decoder:" in tinygltf:
        sys.exit(f"the decoder is not missing: {tinygltf}")
    gltf = said_without("nlohmann_json", "decoder encoder gltf")
    expect("gltf without JSON", r"psplit::gltf: no CMake package nlohmann_json was found", gltf)
    if "psplit::encoder:" in gltf:
        sys.exit(f"the encoder is not missing: {gltf}")
    both = said_without("TBB", "decoder tinygltf meshes encoder c")
    expect("without TBB", r"psplit::decoder: no CMake package TBB \(oneTBB\) was found", both)
    expect("without TBB", r"psplit::tinygltf: no CMake package TBB \(oneTBB\) was found", both)
    expect("without TBB", r"psplit::encoder: no CMake package TBB \(oneTBB\) was found", both)
    if "psplit::c:" in both:
        sys.exit(f"the library for C needs no TBB: {both}")
    expect("an unknown component", r"psplit::meshes: there is no such component", both)


def check_exports(prefix):
    """Shared libraries export only what the installed headers declare, and instances of the standard library's templates."""
    headers = " ".join(path.read_text() for path in (prefix / "include").rglob("*.h*"))
    declared = set(re.findall(r"\w+", re.sub(r"//.*", "", headers)))
    for library in sorted((prefix / "lib").rglob("libpsplit_*.so")):
        own = 0
        # Minor versions may change interfaces, so the name has both numbers of version.h.
        numbers = re.search(r"_MAJOR (\d+)\n.*_MINOR (\d+)", (prefix / "include/psplit/version.h").read_text()).groups()
        expect(f"{library.name}'s SONAME", rf"SONAME.*\[{library.name}[.]{numbers[0]}[.]{numbers[1]}\]", run("readelf", "-d", library))
        if library.name == "libpsplit_draco.so":
            symbols = run("nm", "-DC", "--defined-only", library).splitlines()
            if len(symbols) != 1 or "draco::PointCloudDecoder::Decode(" not in symbols[0]:
                sys.exit(f"{library.name} exports {symbols}, and not one function of libdraco")
            continue
        for line in run("nm", "-DC", "--defined-only", library).splitlines():
            _, kind, name = line.split(" ", 2)
            if not name.startswith("psplit::"):
                # Instances of the standard library's templates, which are weak.
                if kind not in "VWu" or "psplit::core" in name:
                    sys.exit(f"{library.name} exports {line}")
                continue
            words = re.match(r"psplit::([\w:~]+)", name).group(1).replace("~", "").split("::")
            if not all(word in declared for word in words):
                sys.exit(f"{library.name} exports {name}, which no installed header declares")
            own += 1
        if own < 3:
            sys.exit(f"{library.name} exports {own} symbols")
        print(f"{library.name}: {own} symbols of ours")


def check_sources(folder, assets):
    """Checks a project that takes psplit as sources: by FetchContent, which calls add_subdirectory."""
    make_project(folder / "project")
    shutil.copy(source / "bindings/c/examples/decode_glb.c", folder / "project")
    project = folder / "project" / "CMakeLists.txt"
    # Nothing of the user's is changed, and nothing but the libraries is built.
    project.write_text(project.read_text() + """
foreach(name CMAKE_BUILD_TYPE BUILD_SHARED_LIBS CMAKE_CXX_STANDARD CMAKE_CXX_EXTENSIONS CMAKE_EXPORT_COMPILE_COMMANDS
        CMAKE_POSITION_INDEPENDENT_CODE CMAKE_CXX_VISIBILITY_PRESET)
  if(NOT "${${name}}" STREQUAL "")
    message(FATAL_ERROR "psplit sets ${name} to ${${name}}")
  endif()
endforeach()
enable_language(C)
add_executable(c_decode_glb EXCLUDE_FROM_ALL ${CMAKE_CURRENT_SOURCE_DIR}/decode_glb.c)
target_link_libraries(c_decode_glb PRIVATE psplit::c)
foreach(target gltf-psplit loader_tests psplit_unity psplit_blender)
  if(TARGET ${target})
    message(FATAL_ERROR "psplit builds ${target}")
  endif()
endforeach()
get_target_property(options psplit::decoder INTERFACE_COMPILE_OPTIONS)
if(options)
  message(FATAL_ERROR "psplit::decoder has the options ${options}")
endif()
""")
    build = folder / "examples"
    run(options.cmake, "-G", "Ninja", "-S", folder / "project", "-B", build, f"-DCMAKE_CXX_COMPILER={options.compiler}",
        f"-DFETCHCONTENT_SOURCE_DIR_PSPLIT={source}", user_flags(folder))
    if "psplit_encoder" in run(options.cmake, "--build", build, "--target", "help"):
        sys.exit("psplit builds its encoder, which nobody asked for")
    # The library for C is there for who links it.
    run(options.cmake, "--build", build, "--target", "c_decode_glb")
    expect("decode_glb", r"^2\d{4} triangles, \d+ points: POSITION from \(", run(build / "c_decode_glb", assets["patches"]))
    run(options.cmake, "--build", build, "--target", "decode_draco", "decode_with_libdraco", "print_model", "one_patch", "load_to_gpu")
    run_examples("sources", build, assets)
    # The encoder comes if the project asks for it, also without libdraco, which the other builds link.
    run(options.cmake, build, "-DPSPLIT_BUILD_ENCODER=ON", "-DPSPLIT_WITH_DRACO=OFF")
    run(options.cmake, "--build", build, "--target", "encode_mesh")
    expect("encode_mesh", r"^4 patches", run(build / "encode_mesh"))
    linked = subprocess.run(["nm", "-C", build / "encode_mesh"], capture_output=True, text=True).stdout
    if "psplit::encode(" not in linked or "draco::" in linked or "libdraco" in run("ldd", build / "encode_mesh"):
        sys.exit("psplit without libdraco links it")


folder = pathlib.Path(options.build) / "package_test"
if folder.exists():
    shutil.rmtree(folder)
folder.mkdir()
asset = folder / "asset.glb"
run(options.psplit, "generate", "-q", folder / "plain.glb", "--shape", "blob", "--faces", 20000, "--seed", 1)
run(options.psplit, "encode", "-q", "--patches", 5, folder / "plain.glb", asset)
assets = {"plain": folder / "plain.glb", "patches": asset, "stock": folder / "stock.glb", "drc": folder / "stock.drc"}
run(options.psplit, "decode", "-q", asset, assets["stock"], "--to", "draco")
assets["drc"].write_bytes(stock_stream(assets["stock"]))
for shared in ("OFF", "ON"):
    kind = "shared" if shared == "ON" else "static"
    build = options.build
    if shared != options.shared:
        build = folder.parent / "other_libraries"
        (build / "CMakeCache.txt").unlink(missing_ok=True)  # an earlier wheel's options
        # Without optimization everything compiles in half the time, and inlining hides no missing symbol.
        configure(source, build, "-DPSPLIT_BUILD_TOOLS=OFF", "-DPSPLIT_BUILD_TESTS=OFF", "-DPSPLIT_CUDA=OFF",
                  "-DPSPLIT_UNITY_BUILD=ON", "-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG", "-DBUILD_SHARED_LIBS=" + shared)
        run(options.cmake, "--build", build)
    run(options.cmake, "--install", build, "--prefix", folder / kind)
    libraries = sorted(path.name for path in (folder / kind).rglob("libpsplit_*"))
    if not any(library.endswith(".so" if shared == "ON" else ".a") for library in libraries):
        sys.exit(f"{kind}: installed {libraries}")
    check(kind, folder / kind, folder / f"{kind}-project", assets)
    if shared == "ON":
        check_exports(folder / kind)
    else:
        check_headers(folder / kind)
        check_reasons(folder / kind, folder / "reasons")
    check_uninstall(build, folder / kind)
check_sources(folder / "sources", assets)
shutil.rmtree(folder)
