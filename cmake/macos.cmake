# Toolchain: macOS by the clang of zig (scripts/macos), which has Apple's headers and knows what macOS' libraries hold. PSPLIT_ZIG
# is its program, and PSPLIT_ARCHITECTURE aarch64 or x86_64. It is for seeing what compiles and links.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PSPLIT_ZIG PSPLIT_ARCHITECTURE)
set(CMAKE_SYSTEM_NAME Darwin)
set(CMAKE_SYSTEM_PROCESSOR ${PSPLIT_ARCHITECTURE})
foreach(language C CXX)
  set(CMAKE_${language}_COMPILER_TARGET ${PSPLIT_ARCHITECTURE}-macos.13.0)
endforeach()
set(CMAKE_C_COMPILER ${PSPLIT_ZIG} cc)
set(CMAKE_CXX_COMPILER ${PSPLIT_ZIG} c++)
# CMake takes a program, and no words for it. Nothing is installed, so nothing renames libraries.
foreach(tool AR RANLIB)
  string(TOLOWER ${tool} name)
  set(CMAKE_${tool} ${CMAKE_BINARY_DIR}/zig-${name})
  file(WRITE ${CMAKE_${tool}} "#!/bin/sh\nexec ${PSPLIT_ZIG} ${name} \"$@\"\n")
  file(CHMOD ${CMAKE_${tool}} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endforeach()
set(CMAKE_INSTALL_NAME_TOOL true)
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
