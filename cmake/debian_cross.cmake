# Part of the toolchains for other Linux machines, by Debian's cross compilers: PSPLIT_TRIPLET names the machine, and PSPLIT_QEMU
# the emulator of qemu-user that runs its programs. Other packages lie in the folder PSPLIT_SYSROOT (scripts/arm64 makes one);
# without it there is what the compiler brings, and headers that are the same on all machines.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_C_COMPILER ${PSPLIT_TRIPLET}-gcc)
set(CMAKE_CXX_COMPILER ${PSPLIT_TRIPLET}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${PSPLIT_TRIPLET})
set(PSPLIT_ROOT /usr/${PSPLIT_TRIPLET})
if(PSPLIT_SYSROOT)
  set(CMAKE_SYSROOT ${PSPLIT_SYSROOT})
  set(PSPLIT_ROOT ${PSPLIT_SYSROOT})
endif()
include(${CMAKE_CURRENT_LIST_DIR}/cross.cmake)
set(CMAKE_CROSSCOMPILING_EMULATOR ${PSPLIT_QEMU} -L ${PSPLIT_ROOT})
