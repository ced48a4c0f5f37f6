# Leaves out the libraries that other systems than Debian may not have. Toolchains include it; for a build of this system it is
# cmake -C. docs/portability.md says what such a build lacks.
foreach(library DRACO MESHOPTIMIZER PNG)
  set(PSPLIT_WITH_${library} OFF CACHE BOOL "")
endforeach()
set(PSPLIT_THREADS STD CACHE STRING "")
