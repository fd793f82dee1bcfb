# Installation rules for `cmake --install` and cpack. There are two components:
#   Runtime      the program, libmujoco, data, completion, licences
#   Development  static libraries, public headers and CMake files of every module
# No file contains the prefix, so the installed tree can be moved.
include(CMakePackageConfigHelpers)

set(RANGEGRASP_LIBRARY_DIR "${CMAKE_INSTALL_LIBDIR}/rangegrasp")
set(RANGEGRASP_CMAKE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/rangegrasp")

# --- Runtime ---
set_target_properties(rangegrasp PROPERTIES
  INSTALL_RPATH "$ORIGIN/../${RANGEGRASP_LIBRARY_DIR};$ORIGIN/../${RANGEGRASP_LIBRARY_DIR}/coacd")
install(TARGETS rangegrasp RUNTIME DESTINATION bin COMPONENT Runtime)

file(REAL_PATH "${MUJOCO_LIBRARY}" mujoco_library)
get_filename_component(RANGEGRASP_MUJOCO_FILE "${mujoco_library}" NAME)
install(FILES "${mujoco_library}" DESTINATION "${RANGEGRASP_LIBRARY_DIR}" COMPONENT Runtime)

# CoACD, which add-object loads, if scripts/setup fetched it. It searches for its OpenMP in ../coacd.libs.
set(coacd "${PROJECT_SOURCE_DIR}/.cache/coacd")
if(EXISTS "${coacd}/lib_coacd.so")
  install(FILES "${coacd}/lib_coacd.so" DESTINATION "${RANGEGRASP_LIBRARY_DIR}/coacd" COMPONENT Runtime)
  install(DIRECTORY "${coacd}.libs/" DESTINATION "${RANGEGRASP_LIBRARY_DIR}/coacd.libs" COMPONENT Runtime)
  install(FILES "${coacd}/LICENSE" DESTINATION share/doc/rangegrasp/coacd COMPONENT Runtime)
endif()

# base/installation.h finds these folders; experiments refer to scenes and models by relative paths.
install(DIRECTORY models scenes experiments examples DESTINATION share/rangegrasp COMPONENT Runtime)

install(FILES "${PROJECT_BINARY_DIR}/src/rangegrasp.bash" DESTINATION share/bash-completion/completions RENAME rangegrasp
  COMPONENT Runtime)

file(ARCHIVE_CREATE OUTPUT "${PROJECT_BINARY_DIR}/changelog.gz" PATHS "${PROJECT_SOURCE_DIR}/packaging/changelog"
  FORMAT raw COMPRESSION GZip COMPRESSION_LEVEL 9)
install(FILES packaging/copyright "${PROJECT_BINARY_DIR}/changelog.gz" DESTINATION share/doc/rangegrasp COMPONENT Runtime)
install(FILES packaging/copyright "${PROJECT_BINARY_DIR}/changelog.gz" DESTINATION share/doc/librangegrasp-dev COMPONENT Development)
install(FILES ${MUJOCO_LICENSES} DESTINATION share/doc/rangegrasp/mujoco COMPONENT Runtime)

# --- Development ---
set(RANGEGRASP_INSTALLED_MODULES "")
get_property(modules GLOBAL PROPERTY RANGEGRASP_MODULES)
foreach(module ${modules})
  install(TARGETS ${module} EXPORT rangegraspTargets
    ARCHIVE DESTINATION "${RANGEGRASP_LIBRARY_DIR}" COMPONENT Development)
  get_target_property(export_name ${module} EXPORT_NAME)
  list(APPEND RANGEGRASP_INSTALLED_MODULES ${export_name})
  get_target_property(folder ${module} SOURCE_DIR)
  file(RELATIVE_PATH name "${PROJECT_SOURCE_DIR}/src" "${folder}")
  string(REGEX REPLACE "^systems/" "" name "${name}")
  install(DIRECTORY "${folder}/" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/rangegrasp/${name}" COMPONENT Development
    FILES_MATCHING PATTERN "*.h" PATTERN internal EXCLUDE PATTERN command EXCLUDE PATTERN task EXCLUDE)
endforeach()
install(EXPORT rangegraspTargets NAMESPACE rangegrasp:: DESTINATION "${RANGEGRASP_CMAKE_DIR}" COMPONENT Development)

configure_package_config_file(cmake/rangegraspConfig.cmake.in "${PROJECT_BINARY_DIR}/rangegraspConfig.cmake"
  INSTALL_DESTINATION "${RANGEGRASP_CMAKE_DIR}" PATH_VARS RANGEGRASP_LIBRARY_DIR)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/rangegraspConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/rangegraspConfig.cmake" "${PROJECT_BINARY_DIR}/rangegraspConfigVersion.cmake"
    cmake/FindOpenCVParts.cmake
  DESTINATION "${RANGEGRASP_CMAKE_DIR}" COMPONENT Development)
