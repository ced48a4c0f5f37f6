# The archive that cpack makes: the command alone, with its manual page, completions and licences. scripts/release has a
# static command for it.
if(WIN32)
  set(CPACK_GENERATOR ZIP)
else()
  set(CPACK_GENERATOR TGZ)
endif()
set(CPACK_PACKAGE_NAME gltf-psplit)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
string(TOLOWER "${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR}" system)
set(CPACK_PACKAGE_FILE_NAME gltf-psplit-${PROJECT_VERSION}-${system})
set(CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR};psplit;command;/")
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 1) # the same bytes each time
set(CPACK_VERBATIM_VARIABLES ON)
install(FILES LICENSE README.md CHANGELOG.md docs/manual.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command)
# What the licences of linked libraries ask to pass on, for an archive that holds these libraries.
set(PSPLIT_LICENCES "" CACHE FILEPATH "A file with the licences of all libraries in a static command")
if(PSPLIT_LICENCES)
  install(FILES ${PSPLIT_LICENCES} DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command)
endif()
include(CPack)
