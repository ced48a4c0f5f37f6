# Toolchain: 64-bit ARM Linux.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(PSPLIT_TRIPLET aarch64-linux-gnu)
set(PSPLIT_QEMU qemu-aarch64-static)
include(${CMAKE_CURRENT_LIST_DIR}/debian_cross.cmake)
