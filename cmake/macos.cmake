# Toolchain: macOS by the clang of zig (scripts/macos), which has Apple's headers and knows what macOS' libraries hold. PSPLIT_ZIG
# is its program, and PSPLIT_ARCHITECTURE aarch64 or x86_64. It is for seeing what compiles and links.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES PSPLIT_ZIG PSPLIT_ARCHITECTURE)
set(CMAKE_SYSTEM_NAME Darwin)
set(CMAKE_SYSTEM_PROCESSOR ${PSPLIT_ARCHITECTURE})
foreach(language C CXX)
  set(CMAKE_${language}_COMPILER_TARGET ${PSPLIT_ARCHITECTURE}-macos.13.0)
endforeach()
# CMake takes a program, and no words for it. zig's linker makes no bundles: a library that is linked as a dynamic one instead
# shows the same names that are missing. Nothing is installed, so nothing renames libraries.
function(zig_program variable word)
  set(program ${CMAKE_BINARY_DIR}/zig-${word})
  file(CONFIGURE OUTPUT ${program} CONTENT "#!/bin/bash\nexec @PSPLIT_ZIG@ @word@ \"\${@/#-bundle/-dynamiclib}\"\n" @ONLY)
  file(CHMOD ${program} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  set(${variable} ${program} PARENT_SCOPE)
endfunction()
zig_program(CMAKE_C_COMPILER cc)
zig_program(CMAKE_CXX_COMPILER c++)
zig_program(CMAKE_AR ar)
zig_program(CMAKE_RANLIB ranlib)
set(CMAKE_INSTALL_NAME_TOOL true)
include(${CMAKE_CURRENT_LIST_DIR}/without_packages.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
