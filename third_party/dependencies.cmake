# Every dependency of psplit is found here and nowhere else. All of them are installed packages (packages.txt lists
# Debian's names, vcpkg.json those of other platforms); no dependency is vendored or downloaded.

if(PSPLIT_STATIC_COMMAND)
  # The command needs all of them as static libraries.
  set(CMAKE_FIND_LIBRARY_SUFFIXES .a)
endif()
if(PSPLIT_BUILD_ENCODER)
  # Without libdraco it is empty.
  add_library(psplit_draco_package INTERFACE)
endif()
if(PSPLIT_WITH_DRACO)
  # Draco 1.5.5: the reference, which also decodes streams of older versions.
  # Debian's config file names its static library with a path relative to a build folder, so the library and
  # the headers are looked up by name.
  find_path(DRACO_INCLUDE_DIR draco/compression/encode.h REQUIRED)
  find_library(DRACO_LIBRARY NAMES draco REQUIRED)
  target_include_directories(psplit_draco_package SYSTEM INTERFACE ${DRACO_INCLUDE_DIR})
  target_link_libraries(psplit_draco_package INTERFACE ${DRACO_LIBRARY})
endif()

# nlohmann-json 3.11: glTF's JSON, edited in place with its order kept. tinygltf: the loader of our plugin, which is left
# out without it; in tests also a second loader that reads what psplit writes.
find_package(nlohmann_json 3.10 QUIET)
find_package(TinyGLTF QUIET)
set(PSPLIT_HAS_TINYGLTF OFF)
if(nlohmann_json_FOUND AND TinyGLTF_FOUND)
  set(PSPLIT_HAS_TINYGLTF ON)
endif()
message(STATUS "tinygltf plugin: ${PSPLIT_HAS_TINYGLTF}")
if(PSPLIT_BUILD_ENCODER)
  find_package(nlohmann_json 3.10 REQUIRED)
  # meshoptimizer: decodes buffer views that it compressed, simplifies meshes, and is a rival that `compare` measures.
  add_library(psplit_meshoptimizer_package INTERFACE)
  if(PSPLIT_WITH_MESHOPTIMIZER)
    find_package(meshoptimizer REQUIRED)
    target_link_libraries(psplit_meshoptimizer_package INTERFACE meshoptimizer::meshoptimizer)
  endif()
  # xxHash: file names made from content, and how `batch` recognizes what it made already. Its header is also its source,
  # for systems that have no library of it.
  find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
  set(xxhash_library REQUIRED)
  if(CMAKE_CROSSCOMPILING)
    set(xxhash_library)
  endif()
  find_library(XXHASH_LIBRARY NAMES xxhash ${xxhash_library})
  add_library(psplit_xxhash_package INTERFACE)
  target_include_directories(psplit_xxhash_package SYSTEM INTERFACE ${XXHASH_INCLUDE_DIR})
  if(XXHASH_LIBRARY)
    target_link_libraries(psplit_xxhash_package INTERFACE ${XXHASH_LIBRARY})
  else()
    target_compile_definitions(psplit_xxhash_package INTERFACE XXH_STATIC_LINKING_ONLY XXH_IMPLEMENTATION)
  endif()
  # zlib: mesh files compressed by gzip.
  find_package(ZLIB REQUIRED)
endif()
# oneTBB: the pool of threads behind psplit/parallel.h, unless the standard library is.
find_package(Threads REQUIRED)
if(NOT PSPLIT_THREADS MATCHES "^(AUTO|TBB|STD)$")
  message(FATAL_ERROR "PSPLIT_THREADS is ${PSPLIT_THREADS}; it takes AUTO, TBB or STD")
endif()
if(PSPLIT_THREADS STREQUAL "TBB")
  find_package(TBB REQUIRED)
elseif(PSPLIT_THREADS STREQUAL "AUTO")
  find_package(TBB QUIET)
endif()
set(PSPLIT_THREADS_LIBRARIES Threads::Threads)
if(TBB_FOUND AND NOT PSPLIT_THREADS STREQUAL "STD")
  set(PSPLIT_HAS_TBB ON)
  set(PSPLIT_OTHER_THREADS std)
  list(APPEND PSPLIT_THREADS_LIBRARIES TBB::tbb)
else()
  set(PSPLIT_HAS_TBB OFF)
  set(PSPLIT_OTHER_THREADS tbb)
endif()
message(STATUS "oneTBB: ${PSPLIT_HAS_TBB}")

# CUDA 12 or newer, for decoder_cuda: AUTO uses a toolkit if one is installed, ON requires one, OFF does not look.
set(PSPLIT_HAS_CUDA OFF)
if(NOT PSPLIT_CUDA MATCHES "^(AUTO|ON|OFF)$")
  message(FATAL_ERROR "PSPLIT_CUDA is ${PSPLIT_CUDA}; it takes AUTO, ON or OFF")
endif()
if(NOT PSPLIT_CUDA STREQUAL "OFF")
  find_package(CUDAToolkit 12 QUIET)
  if(CUDAToolkit_FOUND AND CUDAToolkit_NVCC_EXECUTABLE)
    if(NOT CMAKE_CUDA_COMPILER)
      set(CMAKE_CUDA_COMPILER ${CUDAToolkit_NVCC_EXECUTABLE})
    endif()
    # Code for all architectures since Turing, and PTX for newer ones.
    if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
      set(CMAKE_CUDA_ARCHITECTURES 75-real 80-real 86-real 89-real 90)
      if(CUDAToolkit_VERSION VERSION_GREATER_EQUAL 12.8)
        set(CMAKE_CUDA_ARCHITECTURES 75-real 80-real 86-real 89-real 90-real 100-real 120)
      endif()
    endif()
    enable_language(CUDA)
    # CMake before 3.26 does not know that nvcc 12 speaks C++20.
    set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION -std=c++20)
    set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION -std=c++20)
    set(PSPLIT_HAS_CUDA ON)
  elseif(PSPLIT_CUDA STREQUAL "ON")
    message(FATAL_ERROR "PSPLIT_CUDA is ON, but no CUDA toolkit 12 or newer was found; "
                        "-DCUDAToolkit_ROOT=FOLDER says where it is")
  endif()
endif()
message(STATUS "CUDA decoder: ${PSPLIT_HAS_CUDA}")

if(PSPLIT_BUILD_TOOLS)
  # CLI11: the command line of gltf-psplit.
  find_package(CLI11 REQUIRED)
  # libpng: the pictures of `inspect --preview`.
  add_library(psplit_png_package INTERFACE)
  if(PSPLIT_WITH_PNG)
    find_package(PNG 1.6 REQUIRED)
    target_link_libraries(psplit_png_package INTERFACE PNG::PNG)
  endif()
  # zstd: the rival that `compare` measures, on top of meshoptimizer.
  add_library(psplit_zstd_package INTERFACE)
  if(PSPLIT_WITH_MESHOPTIMIZER)
    find_path(ZSTD_INCLUDE_DIR zstd.h REQUIRED)
    find_library(ZSTD_LIBRARY NAMES zstd REQUIRED)
    target_include_directories(psplit_zstd_package SYSTEM INTERFACE ${ZSTD_INCLUDE_DIR})
    target_link_libraries(psplit_zstd_package INTERFACE ${ZSTD_LIBRARY})
  endif()
endif()

if(PSPLIT_BUILD_PYTHON)
  # Python and pybind11 2.10: the Python package. By default it is built for the first interpreter that has numpy.
  set(PSPLIT_PYTHON "" CACHE FILEPATH "The Python that the package is built for; empty: the first that has numpy")
  if(NOT PSPLIT_PYTHON)
    foreach(candidate python3 /usr/bin/python3)
      execute_process(COMMAND ${candidate} -c "import numpy, sys; print(sys.executable)" OUTPUT_VARIABLE found
                      ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
      if(failed EQUAL 0)
        set_property(CACHE PSPLIT_PYTHON PROPERTY VALUE ${found})
        break()
      endif()
    endforeach()
    if(NOT PSPLIT_PYTHON)
      message(FATAL_ERROR "PSPLIT_BUILD_PYTHON needs a Python that has numpy; -DPSPLIT_PYTHON=FILE says where it is")
    endif()
  endif()
  set(Python_EXECUTABLE ${PSPLIT_PYTHON})
  find_package(Python 3.8 REQUIRED COMPONENTS Interpreter Development.Module)
  # Debian's pybind11 lies where CMake looks; pip's says where it lies.
  execute_process(COMMAND ${PSPLIT_PYTHON} -m pybind11 --cmakedir OUTPUT_VARIABLE pybind11_of_python
                  ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  find_package(pybind11 2.10 REQUIRED CONFIG HINTS ${pybind11_of_python})
  message(STATUS "Python package: for ${PSPLIT_PYTHON}")
endif()

if(PSPLIT_BUILD_TESTS)
  # An installed GoogleTest works only with the standard library that it was built with.
  set(PSPLIT_GOOGLETEST "" CACHE PATH "GoogleTest's sources, to build it with this build's flags; empty for an installed one")
  if(PSPLIT_GOOGLETEST)
    set(INSTALL_GTEST OFF CACHE BOOL "" FORCE)
    add_subdirectory(${PSPLIT_GOOGLETEST} ${PROJECT_BINARY_DIR}/googletest EXCLUDE_FROM_ALL)
  else()
    find_package(GTest REQUIRED)
  endif()
  if(PSPLIT_WITH_DRACO)
    find_package(TinyGLTF REQUIRED)
  endif()
endif()

if(PSPLIT_BUILD_BENCHMARKS)
  find_package(benchmark REQUIRED)
  # METIS 5.1: the rival of our partition.
  find_path(METIS_INCLUDE_DIR metis.h REQUIRED)
  find_library(METIS_LIBRARY NAMES metis REQUIRED)
  add_library(psplit_metis_package INTERFACE)
  target_include_directories(psplit_metis_package SYSTEM INTERFACE ${METIS_INCLUDE_DIR})
  target_link_libraries(psplit_metis_package INTERFACE ${METIS_LIBRARY})
endif()
