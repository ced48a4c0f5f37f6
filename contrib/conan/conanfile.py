"""The recipe of psplit for Conan 2. It takes the sources of the checkout in which it lies:

  conan create contrib/conan --build=missing
"""
import os

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, rmdir


class Psplit(ConanFile):
    name = "psplit"
    version = "0.1.0"
    license = "Apache-2.0"
    # Examples until the repository has a public address.
    homepage = "https://example.org/psplit"
    url = "https://example.org/psplit"
    description = "Draco meshes as balanced patches that decode in parallel"
    topics = ("gltf", "draco", "mesh", "compression")
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"
    # encoder: psplit::encoder and psplit::gltf. Without it, psplit::decoder needs no other package.
    options = {"encoder": [True, False], "fPIC": [True, False]}
    default_options = {"encoder": True, "fPIC": True}
    implements = ["auto_shared_fpic"]  # Windows has no fPIC

    def validate(self):
        if self.settings.compiler == "msvc":
            raise ConanInvalidConfiguration("psplit does not build with MSVC yet; docs/portability.md says what is left to do")
        check_min_cppstd(self, 17)  # its headers; its own sources are compiled as C++20

    def export_sources(self):
        root = os.path.join(self.recipe_folder, "..", "..")
        for pattern in ("CMakeLists.txt", "LICENSE", "README.md", "SECURITY.md", "CHANGELOG.md", "cmake/*", "third_party/*", "src/*", "bindings/*", "encoder/*",
                        "decoder_cuda/*", "gltf_ext/*", "mesh_files/*", "system/*", "docs/manual.md"):
            copy(self, pattern, root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        if self.options.encoder:
            self.requires("nlohmann_json/[>=3.10]", transitive_headers=True)
            self.requires("meshoptimizer/[>=0.18]")
            self.requires("xxhash/[>=0.8.1]")
            self.requires("zlib/[>=1.2.13 <2]")

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables.update({
            "PSPLIT_BUILD_ENCODER": bool(self.options.encoder), "PSPLIT_BUILD_TOOLS": False, "PSPLIT_WITH_DRACO": False,
            "PSPLIT_BUILD_TESTS": False, "PSPLIT_BUILD_C": False, "PSPLIT_THREADS": "STD", "PSPLIT_CUDA": "OFF",
            "CMAKE_DISABLE_FIND_PACKAGE_TinyGLTF": True})
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()
        rmdir(self, os.path.join(self.package_folder, "lib", "pkgconfig"))  # Conan makes these files itself

    def package_info(self):
        # psplit's own CMake package is that which users have elsewhere. Its targets psplit::encoder and psplit::decoder come with
        # that which is named here.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.set_property("cmake_target_name", "psplit::gltf" if self.options.encoder else "psplit::decoder")
        self.cpp_info.builddirs.append(os.path.join("lib", "cmake", "psplit"))
        self.cpp_info.libs = ["psplit_decoder"]
        if self.options.encoder:
            self.cpp_info.libs = ["psplit_gltf", "psplit_encoder", "psplit_decoder"]
        if self.settings.os == "Linux":
            self.cpp_info.system_libs = ["pthread"]
