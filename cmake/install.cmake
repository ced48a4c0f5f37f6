# What `cmake --install` puts where find_package(psplit) finds it: libraries, each as a component of its own, and the
# headers that their users need.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(components decoder cuda)
set(headers
    src/status.h src/parallel.h src/mesh/mesh.h src/container/decode_backend.h src/loader/loader.h
    decoder_cuda/psplit_cuda.h)
if(PSPLIT_HAS_TINYGLTF)
  list(APPEND components tinygltf)
  list(APPEND headers gltf_ext/tinygltf/tinygltf_plugin.h)
endif()

# Headers include each other as psplit/src/... once they are installed: a folder src of the user's is then not taken for
# ours. `#include "src/loader/loader.h"` finds them too.
foreach(header IN LISTS headers)
  file(READ ${PROJECT_SOURCE_DIR}/${header} text)
  string(REGEX REPLACE "#include \"(src|decoder_cuda|gltf_ext)/" "#include \"psplit/\\1/" text "${text}")
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/installed/${header} CONTENT "${text}" @ONLY)
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${header})
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/installed/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/psplit)

# Libraries find each other where they lie, wherever that is.
if(APPLE)
  set(rpath @loader_path)
else()
  set(rpath $ORIGIN)
endif()
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/psplit)
foreach(component IN LISTS components)
  set(library psplit_${component})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${component} VERSION ${PROJECT_VERSION}
                        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} WINDOWS_EXPORT_ALL_SYMBOLS ON
                        INSTALL_RPATH "${rpath}")
  target_compile_features(${library} PUBLIC cxx_std_20)
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/psplit>)
  install(TARGETS ${library} EXPORT psplit-${component} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(EXPORT psplit-${component} FILE psplit-${component}.cmake NAMESPACE psplit:: DESTINATION ${package_folder})
endforeach()

configure_package_config_file(cmake/psplit-config.cmake.in ${PROJECT_BINARY_DIR}/psplit-config.cmake
                              INSTALL_DESTINATION ${package_folder})
# Until 1.0, each minor version may change what it promises.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/psplit-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/psplit-config.cmake ${PROJECT_BINARY_DIR}/psplit-config-version.cmake
        DESTINATION ${package_folder})
if(PSPLIT_BUILD_TOOLS)
  file(RELATIVE_PATH libraries /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
  set_target_properties(gltf-psplit PROPERTIES INSTALL_RPATH "${rpath}/${libraries}")
  install(TARGETS gltf-psplit RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
