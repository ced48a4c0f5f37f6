# Refuses machines on which decoded values would differ from libdraco's. A reader of CMake's output sees why. Only the
# compiler's own macros are asked, so that a compiler without a standard library answers as well.
include(CheckCXXSourceCompiles)

function(psplit_require name condition text)
  set(CMAKE_REQUIRED_QUIET ON)
  check_cxx_source_compiles("#if ${condition}\nint main() { return 0; }\n#else\n#error\n#endif\n" ${name})
  if(NOT ${name})
    unset(${name} CACHE) # other flags may answer otherwise
    message(FATAL_ERROR "psplit does not build for this machine: ${text}")
  endif()
endfunction()

if(NOT MSVC)
  psplit_require(PSPLIT_IS_LITTLE_ENDIAN "__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__"
                 "it is big-endian, but glTF and Draco are little-endian, and psplit reads them as they lie in memory.")
  # The x87 calculates with more digits than a float has, and rounds when a value leaves its registers.
  psplit_require(PSPLIT_ROUNDS_FLOATS "__FLT_EVAL_METHOD__ == 0"
                 "its floats have more digits while they are calculated, so results would differ from other machines'. \
A 32-bit x86 needs SSE2: -DCMAKE_CXX_FLAGS=\"-msse2 -mfpmath=sse\".")
  psplit_require(PSPLIT_KEEPS_FLOATS "!defined(__FAST_MATH__)"
                 "-ffast-math lets the compiler change results. Please build without it.")
elseif(CMAKE_CXX_COMPILER_ID STREQUAL "MSVC" AND MSVC_VERSION LESS 1930)
  message(FATAL_ERROR "psplit does not build with this compiler: before Visual Studio 2022 it fuses multiply-adds, so results \
would differ from other machines'.")
endif()
