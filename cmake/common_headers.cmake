# Part of toolchains for other machines: PSPLIT_HEADERS is a folder with this system's headers that are the same on all machines.
# /usr/include has also those of this system's C library.
if(NOT PSPLIT_HEADERS)
  set(PSPLIT_HEADERS ${CMAKE_BINARY_DIR}/headers)
  file(MAKE_DIRECTORY ${PSPLIT_HEADERS}/include ${PSPLIT_HEADERS}/share/cmake)
  foreach(name include/nlohmann include/CLI include/xxhash.h share/cmake/nlohmann_json share/cmake/CLI11)
    file(CREATE_LINK /usr/${name} ${PSPLIT_HEADERS}/${name} SYMBOLIC)
  endforeach()
endif()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PSPLIT_HEADERS)
