# The libraries that users link: psplit::decoder, psplit::cuda, psplit::tinygltf, psplit::encoder and psplit::gltf. They
# have the same names and the same include paths with find_package, add_subdirectory and FetchContent. Each holds the
# objects of libraries in this tree, is static or shared as BUILD_SHARED_LIBS says, and adds none of our compiler flags.
# The command and the tests link the libraries of the tree instead, because shared libraries hide what tests need.

set(components decoder cuda)
set(headers base cuda decode draco_decoder draco_types loader mesh parallel psplit version)
if(PSPLIT_HAS_TINYGLTF)
  list(APPEND components tinygltf)
  list(APPEND headers tinygltf)
endif()
if(PSPLIT_BUILD_ENCODER)
  list(APPEND components encoder gltf)
  list(APPEND headers document encode gltf)
endif()
# The libraries of this tree whose objects a component holds, if they are not only the one of its name.
set(tinygltf_objects psplit_tinygltf psplit_json)
set(decoder_objects psplit_decoder psplit_threads)
set(encoder_objects psplit_encoder psplit_partition)
set(gltf_objects psplit_gltf psplit_mesh_files psplit_documents psplit_json)

include(GNUInstallDirs)
foreach(component IN LISTS components)
  set(package psplit_${component}_package)
  if(NOT DEFINED ${component}_objects)
    set(${component}_objects psplit_${component})
  endif()
  add_library(${package})
  foreach(tree IN LISTS ${component}_objects)
    set_target_properties(${tree} PROPERTIES CXX_VISIBILITY_PRESET hidden CUDA_VISIBILITY_PRESET hidden
                          VISIBILITY_INLINES_HIDDEN ON)
    target_compile_definitions(${tree} PRIVATE $<$<BOOL:${BUILD_SHARED_LIBS}>:PSPLIT_BUILDS_SHARED>)
    target_sources(${package} PRIVATE $<TARGET_OBJECTS:${tree}>)
  endforeach()
  add_library(psplit::${component} ALIAS ${package})
  set_target_properties(${package} PROPERTIES LINKER_LANGUAGE CXX EXPORT_NAME ${component} OUTPUT_NAME psplit_${component}
                        ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/package
                        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(${package} PUBLIC cxx_std_17)
  target_compile_definitions(${package} PUBLIC $<$<BOOL:${BUILD_SHARED_LIBS}>:PSPLIT_SHARED>)
  target_include_directories(${package} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  if(PSPLIT_SANITIZE)
    target_link_options(${package} PRIVATE -fsanitize=${PSPLIT_SANITIZE})
  endif()
endforeach()

# A library that has no CMake package is found again by psplit-config.cmake, as psplit::<name>.
function(psplit_link_found package tree name)
  target_link_libraries(${package} PRIVATE $<BUILD_INTERFACE:${tree}> $<INSTALL_INTERFACE:psplit::${name}>)
endfunction()
# A shared library holds a copy of what another one hides and it needs.
function(psplit_link_hidden package)
  if(BUILD_SHARED_LIBS)
    foreach(tree IN LISTS ARGN)
      target_link_libraries(${package} PRIVATE $<BUILD_INTERFACE:${tree}>)
    endforeach()
  endif()
endfunction()

target_link_libraries(psplit_decoder_package PRIVATE ${PSPLIT_THREADS_LIBRARIES})
target_link_libraries(psplit_cuda_package PUBLIC psplit_decoder_package)
if(PSPLIT_HAS_CUDA)
  target_link_libraries(psplit_cuda_package PRIVATE CUDA::cudart_static)
  psplit_link_hidden(psplit_cuda_package psplit_decoder)
endif()
if(PSPLIT_HAS_TINYGLTF)
  target_link_libraries(psplit_tinygltf_package PUBLIC psplit_decoder_package psplit_cuda_package TinyGLTF::TinyGLTF)
endif()
if(PSPLIT_BUILD_ENCODER)
  target_link_libraries(psplit_encoder_package PUBLIC psplit_decoder_package)
  psplit_link_hidden(psplit_encoder_package psplit_decoder)
  if(PSPLIT_WITH_DRACO)
    psplit_link_found(psplit_encoder_package psplit_draco_package draco_library)
  endif()
  set(meshoptimizer)
  if(PSPLIT_WITH_MESHOPTIMIZER)
    set(meshoptimizer meshoptimizer::meshoptimizer)
  endif()
  target_link_libraries(psplit_gltf_package PUBLIC psplit_encoder_package nlohmann_json::nlohmann_json
                        PRIVATE ${meshoptimizer} ZLIB::ZLIB)
  psplit_link_hidden(psplit_gltf_package psplit_encoder psplit_decoder)
  set(psplit_has_xxhash_library OFF)
  if(XXHASH_LIBRARY)
    set(psplit_has_xxhash_library ON)
    psplit_link_found(psplit_gltf_package psplit_xxhash_package xxhash_library)
  endif()
endif()

# psplit_exporting(TARGET TYPE NAME MAP OBJECTS LIBRARIES...): a library that other languages load, with the objects of its own
# that it needs. It exports what MAP names, and lies beside the packages.
function(psplit_exporting target type name map objects)
  add_library(${target} ${type})
  target_link_libraries(${target} PRIVATE ${ARGN})
  foreach(tree IN LISTS objects)
    set_target_properties(${tree} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    # A program does not replace exported functions, so they may be inlined as in a static library.
    target_compile_options(${tree} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-semantic-interposition>)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${tree}>)
  endforeach()
  set(folder ${PROJECT_BINARY_DIR}/package)
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME ${name} LIBRARY_OUTPUT_DIRECTORY ${folder}
                        RUNTIME_OUTPUT_DIRECTORY ${folder})
  if(type STREQUAL "MODULE")
    set_target_properties(${target} PROPERTIES PREFIX lib)
  endif()
  if(PSPLIT_SANITIZE)
    target_link_options(${target} PRIVATE -fsanitize=${PSPLIT_SANITIZE})
  endif()
  if(UNIX AND NOT APPLE)
    # Threads wait in the library for work until the process ends. A program that unloads the library, as Mono does at its
    # end, would take the code away from under them.
    target_link_options(${target} PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/${map} -Wl,-z,nodelete)
    set_target_properties(${target} PROPERTIES LINK_DEPENDS ${PROJECT_SOURCE_DIR}/${map})
  endif()
endfunction()
# psplit::c, with versions of what it exports.
if(PSPLIT_BUILD_C)
  set(objects psplit_decoder)
  if(PSPLIT_BUILD_ENCODER)
    list(APPEND objects psplit_encoder psplit_partition)
    set(libdraco $<BUILD_INTERFACE:psplit_draco_package>)
  endif()
  psplit_exporting(psplit_c_package SHARED psplit bindings/c/psplit.map "psplit_c;psplit_json;psplit_threads;${objects}" ${libdraco}
                   ${PSPLIT_THREADS_LIBRARIES})
  add_library(psplit::c ALIAS psplit_c_package)
  # The number of the interface, not of the project.
  set_target_properties(psplit_c_package PROPERTIES EXPORT_NAME c VERSION 0.1 SOVERSION 0)
  target_include_directories(psplit_c_package INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endif()
# psplit_plugin(TARGET NAME MAP OBJECTS LIBRARIES...): a module that Blender or Unity loads, which bring libraries of their own. On Linux
# it needs the C library alone.
function(psplit_plugin target name map objects)
  psplit_exporting(${target} MODULE ${name} ${map} "psplit_decoder;psplit_plugin_threads;${objects}" Threads::Threads ${ARGN})
  if(UNIX AND NOT APPLE AND NOT PSPLIT_SANITIZE)
    target_link_options(${target} PRIVATE -static-libstdc++ -static-libgcc)
  endif()
endfunction()
if(PSPLIT_BUILD_C AND PROJECT_IS_TOP_LEVEL)
  psplit_library(psplit_plugin_threads FILES src/task_arena_std.cpp LINK psplit_core)
  # libextern_draco.so, for Blender.
  if(PSPLIT_BUILD_ENCODER)
    set(encoder psplit_encoder psplit_partition)
    psplit_plugin(psplit_blender_package extern_draco bindings/c/blender/bridge.map "psplit_blender;${encoder}"
                  psplit_static_draco_package)
  endif()
  # libdracodec_unity.so, for DracoUnity 4, and libdraco_unity.so, for com.unity.cloud.draco 5.
  psplit_plugin(psplit_unity_package dracodec_unity bindings/c/unity/plugin.map psplit_unity)
  set(unity psplit_unity_package)
  if(PSPLIT_BUILD_ENCODER)
    psplit_plugin(psplit_unity_5_package draco_unity bindings/c/unity/draco_unity.map
                  "psplit_unity;psplit_unity_encoder;${encoder}" psplit_static_draco_package)
    list(APPEND unity psplit_unity_5_package)
  endif()
  if(APPLE) # the names that Blender's add-on and Unity look for
    set_target_properties(${unity} PROPERTIES PREFIX "" SUFFIX .bundle)
    if(TARGET psplit_blender_package)
      set_target_properties(psplit_blender_package PROPERTIES SUFFIX .dylib)
    endif()
  endif()
elseif(PSPLIT_BUILD_C AND NOT PSPLIT_INSTALL)
  set_target_properties(psplit_c_package PROPERTIES EXCLUDE_FROM_ALL ON)
endif()
if(PSPLIT_WITH_DRACO AND UNIX AND NOT DRACO_LIBRARY MATCHES "[.]a$")
  psplit_exporting(psplit_draco_override SHARED psplit_draco bindings/libdraco/override.map "" psplit_libdraco psplit_draco_package
                   ${CMAKE_DL_LIBS})
  target_sources(psplit_draco_override PRIVATE ${PROJECT_SOURCE_DIR}/bindings/libdraco/override.cpp)
  # The layout of libdraco's classes is its interface.
  set_target_properties(psplit_draco_override PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
endif()
