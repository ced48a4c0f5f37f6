# Toolchain: 32-bit x86 Linux, with the registers of SSE2 for floats, because the x87 rounds otherwise (cmake/machine.cmake).
set(CMAKE_SYSTEM_PROCESSOR i686)
set(PSPLIT_TRIPLET i686-linux-gnu)
set(PSPLIT_QEMU qemu-i386-static)
set(CMAKE_CXX_FLAGS_INIT "-msse2 -mfpmath=sse")
include(${CMAKE_CURRENT_LIST_DIR}/debian_cross.cmake)
