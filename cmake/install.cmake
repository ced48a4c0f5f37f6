# Installs what find_package(psplit) finds: the libraries, each as a component of its own, their public headers, and the
# command with its manual page.
include(CMakePackageConfigHelpers)

list(JOIN headers "|" names)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/psplit DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING
        REGEX "/(${names})[.]hp*$")

# Libraries find each other in their own folder.
if(APPLE)
  set(rpath @loader_path)
else()
  set(rpath $ORIGIN)
endif()
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/psplit)
set(installed ${components})
if(PSPLIT_BUILD_C)
  list(APPEND installed c)
endif()
foreach(component IN LISTS installed)
  set_target_properties(psplit_${component}_package PROPERTIES INSTALL_RPATH "${rpath}")
  install(TARGETS psplit_${component}_package EXPORT psplit-${component} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(EXPORT psplit-${component} FILE psplit-${component}.cmake NAMESPACE psplit:: DESTINATION ${package_folder})
endforeach()

# The library that is loaded before a shared libdraco.
if(TARGET psplit_draco_override)
  install(TARGETS psplit_draco_override LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
# Blender and Unity load these by their paths (docs/c.md).
foreach(plugin psplit_blender_package psplit_unity_package psplit_unity_5_package)
  if(TARGET ${plugin})
    install(TARGETS ${plugin} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/psplit)
  endif()
endforeach()

# psplit_pkg_config(COMPONENT NAME REQUIRES TEXT NEEDS...): NAME.pc, for builds without CMake. Static libraries name all that they
# need.
file(RELATIVE_PATH prefix_of_pc /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
function(psplit_pkg_config component name requires text)
  if(NOT component IN_LIST installed AND NOT (component STREQUAL "libdraco" AND TARGET psplit_draco_override))
    return()
  endif()
  string(REPLACE - _ library ${name})
  set(library -l${library})
  if(component STREQUAL "libdraco" AND NOT APPLE)
    # Programs name symbols of libdraco only. A linker with --as-needed, the default of Debian and others, would drop it.
    set(library "-Wl,--push-state,--no-as-needed ${library} -Wl,--pop-state")
  endif()
  if(NOT BUILD_SHARED_LIBS OR component STREQUAL "libdraco")
    list(JOIN ARGN " " needs)
  elseif(NOT component STREQUAL "c") # whose header needs no definition
    set(definitions " -DPSPLIT_SHARED")
  endif()
  configure_file(${PROJECT_SOURCE_DIR}/cmake/psplit.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
if(PSPLIT_HAS_TBB)
  set(tbb -ltbb)
endif()
if(PSPLIT_WITH_DRACO)
  set(draco ${DRACO_LIBRARY})
endif()
if(PSPLIT_WITH_MESHOPTIMIZER)
  set(meshoptimizer -lmeshoptimizer)
endif()
if(PSPLIT_HAS_CUDA)
  set(cuda_runtime -L${CUDAToolkit_LIBRARY_DIR} -lcudart_static -ldl -lrt)
endif()
psplit_pkg_config(decoder psplit-decoder "" "Decodes PSPLIT_mesh_draco_patches and Draco meshes into the caller's memory"
                  ${tbb} -pthread)
psplit_pkg_config(cuda psplit-cuda psplit-decoder "Decodes PSPLIT_mesh_draco_patches on a GPU" ${cuda_runtime})
psplit_pkg_config(tinygltf psplit-tinygltf "psplit-cuda tinygltf" "Loads glTF files with PSPLIT_mesh_draco_patches by tinygltf")
psplit_pkg_config(encoder psplit-encoder psplit-decoder "Encodes meshes as balanced Draco patches" ${draco})
psplit_pkg_config(gltf psplit-gltf psplit-encoder "Encodes the meshes of glTF documents as balanced Draco patches"
                  ${meshoptimizer} ${XXHASH_LIBRARY} -lz)
psplit_pkg_config(c psplit "" "Decodes and encodes meshes as balanced Draco patches, for C and other languages")
psplit_pkg_config(libdraco psplit-draco "" "Takes the place of a shared libdraco's decoder" ${draco})

configure_package_config_file(cmake/psplit-config.cmake.in ${PROJECT_BINARY_DIR}/psplit-config.cmake
                              INSTALL_DESTINATION ${package_folder})
# Until 1.0, each minor version may change its interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/psplit-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/psplit-config.cmake ${PROJECT_BINARY_DIR}/psplit-config-version.cmake
        DESTINATION ${package_folder})

if(PSPLIT_BUILD_TOOLS)
  install(TARGETS gltf-psplit RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
  # The manual page is made from the command's own help.
  if(NOT CMAKE_CROSSCOMPILING OR CMAKE_CROSSCOMPILING_EMULATOR)
    set(man_page ${PROJECT_BINARY_DIR}/gltf-psplit.1)
    add_custom_command(OUTPUT ${man_page}
                       COMMAND ${CMAKE_COMMAND} -D "COMMAND=${CMAKE_CROSSCOMPILING_EMULATOR};$<TARGET_FILE:gltf-psplit>" -D VERSION=${PROJECT_VERSION}
                               -D PAGE=${man_page} -P ${PROJECT_SOURCE_DIR}/cmake/man_page.cmake
                       DEPENDS gltf-psplit ${PROJECT_SOURCE_DIR}/cmake/man_page.cmake VERBATIM)
    add_custom_target(psplit_man_page ALL DEPENDS ${man_page})
    install(FILES ${man_page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT command)
    # So are the completions of shells, where each looks for them.
    set(completions)
    foreach(place IN ITEMS bash:bash-completion/completions/gltf-psplit zsh:zsh/site-functions/_gltf-psplit
                           fish:fish/vendor_completions.d/gltf-psplit.fish)
      string(REGEX MATCH "^([a-z]+):(.*)/([^/]+)$" place ${place})
      set(shell ${CMAKE_MATCH_1})
      set(folder ${CMAKE_INSTALL_DATADIR}/${CMAKE_MATCH_2})
      set(script ${PROJECT_BINARY_DIR}/completions/${shell}/${CMAKE_MATCH_3})
      add_custom_command(OUTPUT ${script}
                         COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/completions/${shell}
                         COMMAND gltf-psplit completion ${shell} -o ${script} DEPENDS gltf-psplit VERBATIM)
      list(APPEND completions ${script})
      install(FILES ${script} DESTINATION ${folder} COMPONENT command)
    endforeach()
    add_custom_target(psplit_completions ALL DEPENDS ${completions})
  endif()
endif()

# cmake --build FOLDER --target uninstall
if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(uninstall COMMAND ${CMAKE_COMMAND} -D MANIFEST=${PROJECT_BINARY_DIR}/install_manifest.txt
                                      -P ${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake VERBATIM)
endif()
