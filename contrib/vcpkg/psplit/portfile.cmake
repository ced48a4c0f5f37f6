# Builds the checkout in which this port lies:
#
#   vcpkg install psplit --classic --editable --overlay-ports=contrib/vcpkg
#
# --classic: a checkout has a vcpkg.json, with which vcpkg takes no names. --editable: otherwise vcpkg would take what it built
# before, because it looks for changes in the folder of the port alone.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS options FEATURES
    draco PSPLIT_WITH_DRACO
    encoder PSPLIT_BUILD_ENCODER
    tools PSPLIT_BUILD_TOOLS)
set(threads STD)
if("tbb" IN_LIST FEATURES)
  set(threads TBB)
endif()

# psplit::c is always a shared library, which triplets of static libraries must not have.
string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" dynamic is_shared)

vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS ${options} -DPSPLIT_THREADS=${threads} -DPSPLIT_CUDA=OFF -DPSPLIT_BUILD_TESTS=OFF
            -DPSPLIT_BUILD_C=${is_shared} -DCMAKE_DISABLE_FIND_PACKAGE_TinyGLTF=ON)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/psplit)
vcpkg_fixup_pkgconfig()
if("tools" IN_LIST FEATURES)
  vcpkg_copy_tools(TOOL_NAMES gltf-psplit AUTO_CLEAN)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
