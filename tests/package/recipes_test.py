#!/usr/bin/env python3
"""The recipes of contrib/ for other package managers, as far as they can be checked without these:  recipes_test.py SOURCE CMAKE

vcpkg's functions and Conan's classes are replaced by small ones. Then CMake has to configure psplit with what the port and the
recipe say, and the recipe from the sources alone that it exports."""
import importlib.util, json, os, pathlib, re, shutil, subprocess, sys, tempfile, types

sys.dont_write_bytecode = True
source, cmake = pathlib.Path(sys.argv[1]), sys.argv[2]


def configure(folder, build, *options):
    done = subprocess.run([cmake, "-G", "Ninja", "-S", folder, "-B", build, *options], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, options))}: {done.stdout[-2000:]}{done.stderr[-4000:]}")
    cache = dict(re.findall(r"^(\w+):\w+=(.*)$", (build / "CMakeCache.txt").read_text(), re.M))
    # An option that is spelled wrong is one that the project does not read.
    unread = re.search(r"Manually-specified variables were not used by the project:(.*?)\n\n\n", done.stderr, re.S)
    if unread:
        sys.exit(f"the project does not read {unread.group(1).split()}")
    return cache


def expect(what, found, wanted):
    if found != wanted:
        sys.exit(f"{what} is {found!r}, not {wanted!r}")


def check_vcpkg(folder):
    port = source / "contrib/vcpkg/psplit"
    features = json.loads((port / "vcpkg.json").read_text())["features"]
    for asked, linkage in (([], "static"), (["encoder"], "dynamic"), (["encoder", "tools"], "static")):
        script = folder / "port.cmake"
        script.write_text(f"""
cmake_minimum_required(VERSION 3.22)
set(FEATURES core {' '.join(asked)})
set(CURRENT_PACKAGES_DIR {folder}/packages)
set(VCPKG_LIBRARY_LINKAGE {linkage})
function(vcpkg_check_features)
  cmake_parse_arguments(A "" OUT_FEATURE_OPTIONS FEATURES ${{ARGN}})
  set(options)
  while(A_FEATURES)
    list(POP_FRONT A_FEATURES feature option)
    if(feature IN_LIST FEATURES)
      list(APPEND options -D${{option}}=ON)
    else()
      list(APPEND options -D${{option}}=OFF)
    endif()
  endwhile()
  set(${{A_OUT_FEATURE_OPTIONS}} ${{options}} PARENT_SCOPE)
endfunction()
function(vcpkg_cmake_configure)
  cmake_parse_arguments(A "" SOURCE_PATH OPTIONS ${{ARGN}})
  if(NOT EXISTS ${{A_SOURCE_PATH}}/CMakeLists.txt)
    message(FATAL_ERROR "no project in ${{A_SOURCE_PATH}}")
  endif()
  foreach(option IN LISTS A_OPTIONS)
    message(NOTICE "option ${{option}}")
  endforeach()
endfunction()
foreach(name vcpkg_cmake_install vcpkg_cmake_config_fixup vcpkg_fixup_pkgconfig vcpkg_copy_tools vcpkg_install_copyright)
  cmake_language(EVAL CODE "function(${{name}})\\nendfunction()")
endforeach()
include({port}/portfile.cmake)
""")
        done = subprocess.run([cmake, "-P", script], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"portfile.cmake: {done.stderr}")
        options = re.findall(r"^option (\S+)$", done.stderr, re.M)
        cache = configure(source, folder / f"vcpkg-{len(asked)}", *options)
        for feature, option in {"encoder": "PSPLIT_BUILD_ENCODER", "tools": "PSPLIT_BUILD_TOOLS"}.items():
            expect(f"vcpkg {asked}: {option}", cache.get(option), "ON" if feature in asked else "OFF")
        expect(f"vcpkg with {linkage} libraries: PSPLIT_BUILD_C", cache.get("PSPLIT_BUILD_C") in ("1", "ON"), linkage == "dynamic")
        for feature in asked:
            expect(f"vcpkg.json has the feature {feature}", feature in features, True)


def copy(_, pattern, start, target):
    start, target = pathlib.Path(start), pathlib.Path(target)
    found = [path for path in start.glob(pattern.replace("/*", "/**/*")) if path.is_file()]
    if not found:
        sys.exit(f"conanfile.py exports {pattern}, which does not exist")
    for file in found:
        (target / file.relative_to(start)).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, target / file.relative_to(start))


class CMakeToolchain:
    made = None

    def __init__(self, recipe):
        self.cache_variables = {}
        CMakeToolchain.made = self

    def generate(self):
        pass


class InvalidConfiguration(Exception):
    pass


def check_conan(folder):
    minima, removed = [], []
    modules = {"conan": {"ConanFile": object}, "conan.errors": {"ConanInvalidConfiguration": InvalidConfiguration}, "conan.tools": {},
               "conan.tools.build": {"check_min_cppstd": lambda recipe, minimum: minima.append(minimum)},
               "conan.tools.files": {"copy": copy, "rmdir": lambda recipe, folder: removed.append(folder)},
               "conan.tools.cmake": {"CMake": lambda recipe: types.SimpleNamespace(install=lambda: None),
                                     "CMakeToolchain": CMakeToolchain, "cmake_layout": None,
                                     "CMakeDeps": lambda recipe: types.SimpleNamespace(generate=lambda: None)}}
    for name, members in modules.items():
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].__dict__.update(members)
    file = source / "contrib/conan/conanfile.py"
    spec = importlib.util.spec_from_file_location("conanfile", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    recipe = module.Psplit()
    recipe.recipe_folder, recipe.export_sources_folder = file.parent, folder / "exported"
    recipe.export_sources()
    for compiler, valid in (("gcc", True), ("apple-clang", True), ("msvc", False)):
        recipe.settings = types.SimpleNamespace(compiler=compiler, os="Linux")
        try:
            recipe.validate()
            expect(f"what {compiler} is", True, valid)
        except InvalidConfiguration as refusal:
            expect(f"{compiler}: {refusal}", False, valid)
    expect("the least C++", set(minima), {17})
    for encoder in (False, True):
        recipe.options = types.SimpleNamespace(encoder=encoder)
        required = []
        recipe.requires = lambda reference, **_: required.append(reference.split("/")[0])
        recipe.requirements()
        expect("what the recipe requires", bool(required), encoder)
        recipe.generate()
        properties = {}
        recipe.cpp_info = types.SimpleNamespace(builddirs=[], set_property=properties.__setitem__)
        recipe.package_info()
        target = properties["cmake_target_name"]
        expect(f"psplit-config.cmake has {target}", f"#   {target} " in (source / "cmake/psplit-config.cmake.in").read_text(), True)
        recipe.source_folder, recipe.package_folder = folder / "exported", folder / "package"
        recipe.package()
        expect("what is left to Conan", removed.pop(), str(folder / "package/lib/pkgconfig"))
        options = [f"-D{name}={'ON' if value is True else 'OFF' if value is False else value}"
                   for name, value in CMakeToolchain.made.cache_variables.items()]
        configure(folder / "exported", folder / f"conan-{encoder}", *options)


with tempfile.TemporaryDirectory() as name:
    check_vcpkg(pathlib.Path(name))
    check_conan(pathlib.Path(name))
print("the port of vcpkg and the recipe of Conan configure")
