# What users link: psplit::decoder, psplit::cuda and psplit::tinygltf, under the same names and with the same include
# paths whether find_package, add_subdirectory or FetchContent brings them. Each holds the objects of the library of its
# name in this tree, is static or shared as BUILD_SHARED_LIBS says, and has none of our flags. The command and the tests
# link the libraries of the tree, where they see what shared libraries hide.

set(components decoder cuda)
set(headers
    src/export.h src/status.h src/parallel.h src/mesh/mesh.h src/core/data_type.h src/container/decode_backend.h
    src/container/stream_description.h src/cpu/cpu_backend.h src/loader/loader.h decoder_cuda/psplit_cuda.h)
if(PSPLIT_HAS_TINYGLTF)
  list(APPEND components tinygltf)
  list(APPEND headers gltf_ext/tinygltf/tinygltf_plugin.h)
endif()

# Headers include each other as psplit/src/... here: a folder src of the user's is then not taken for ours.
# `#include "src/loader/loader.h"` finds them too.
foreach(header IN LISTS headers)
  file(READ ${PROJECT_SOURCE_DIR}/${header} text)
  string(REGEX REPLACE "#include \"(src|decoder_cuda|gltf_ext)/" "#include \"psplit/\\1/" text "${text}")
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/include/psplit/${header} CONTENT "${text}" @ONLY)
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${header})
endforeach()

include(GNUInstallDirs)
foreach(component IN LISTS components)
  set(tree psplit_${component})
  set(package psplit_${component}_package)
  set_target_properties(${tree} PROPERTIES CXX_VISIBILITY_PRESET hidden CUDA_VISIBILITY_PRESET hidden
                        VISIBILITY_INLINES_HIDDEN ON)
  target_compile_definitions(${tree} PRIVATE $<$<BOOL:${BUILD_SHARED_LIBS}>:PSPLIT_BUILDS_SHARED>)
  add_library(${package} $<TARGET_OBJECTS:${tree}>)
  add_library(psplit::${component} ALIAS ${package})
  set_target_properties(${package} PROPERTIES LINKER_LANGUAGE CXX EXPORT_NAME ${component} OUTPUT_NAME ${tree}
                        ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/package
                        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(${package} PUBLIC cxx_std_20)
  target_compile_definitions(${package} PUBLIC $<$<BOOL:${BUILD_SHARED_LIBS}>:PSPLIT_SHARED>)
  foreach(folder "" /psplit)
    target_include_directories(${package} INTERFACE $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include${folder}>
                               $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}${folder}>)
  endforeach()
  target_link_options(${package} PRIVATE $<$<BOOL:${PSPLIT_SANITIZE}>:-fsanitize=${PSPLIT_SANITIZE}>)
endforeach()

target_link_libraries(psplit_decoder_package PRIVATE TBB::tbb Threads::Threads)
target_link_libraries(psplit_cuda_package PUBLIC psplit_decoder_package)
if(PSPLIT_HAS_CUDA)
  target_link_libraries(psplit_cuda_package PRIVATE CUDA::cudart_static)
  if(BUILD_SHARED_LIBS)
    # It plans by what the decoder's library hides: a copy of that.
    target_link_libraries(psplit_cuda_package PRIVATE $<BUILD_INTERFACE:psplit_decoder>)
  endif()
endif()
if(PSPLIT_HAS_TINYGLTF)
  set_target_properties(psplit_json PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  target_sources(psplit_tinygltf_package PRIVATE $<TARGET_OBJECTS:psplit_json>)
  target_link_libraries(psplit_tinygltf_package PUBLIC psplit_decoder_package psplit_cuda_package TinyGLTF::TinyGLTF)
endif()
