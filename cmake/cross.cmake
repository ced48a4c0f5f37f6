# Part of toolchains for other machines: libraries and headers are found in CMAKE_FIND_ROOT_PATH alone, to which PSPLIT_ROOT is
# appended. Unless that is a whole system (PSPLIT_SYSROOT), PSPLIT_HEADERS follows: a folder with this system's headers that are
# the same on all machines. /usr/include also has headers of this system's C library.
if(NOT PSPLIT_SYSROOT AND NOT PSPLIT_HEADERS)
  set(PSPLIT_HEADERS ${CMAKE_BINARY_DIR}/headers)
  file(MAKE_DIRECTORY ${PSPLIT_HEADERS}/include ${PSPLIT_HEADERS}/share/cmake)
  foreach(name include/nlohmann include/CLI include/xxhash.h share/cmake/nlohmann_json share/cmake/CLI11)
    file(CREATE_LINK /usr/${name} ${PSPLIT_HEADERS}/${name} SYMBOLIC)
  endforeach()
endif()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PSPLIT_SYSROOT PSPLIT_HEADERS)
list(APPEND CMAKE_FIND_ROOT_PATH ${PSPLIT_ROOT} ${PSPLIT_HEADERS})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
