# Finds MuJoCo and defines MuJoCo::MuJoCo. Searches MUJOCO_DIR (variable or environment) first, then the folder that
# scripts/setup fills from the wheel: <cache>/mujoco, which contains include/, licenses/ and libmujoco.so.*.
# MUJOCO_LICENSES lists the license files found there.
set(_mujoco_hints "")
if(MUJOCO_DIR)
  list(APPEND _mujoco_hints "${MUJOCO_DIR}")
endif()
if(DEFINED ENV{MUJOCO_DIR})
  list(APPEND _mujoco_hints "$ENV{MUJOCO_DIR}")
endif()
list(APPEND _mujoco_hints "${PROJECT_SOURCE_DIR}/.cache/mujoco")

find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h HINTS ${_mujoco_hints} PATH_SUFFIXES include)
find_library(MUJOCO_LIBRARY NAMES mujoco libmujoco.so.4.0.0 HINTS ${_mujoco_hints} PATH_SUFFIXES lib .)

get_filename_component(_mujoco_folder "${MUJOCO_LIBRARY}" DIRECTORY)
file(GLOB MUJOCO_LICENSES "${_mujoco_folder}/licenses/*" "${_mujoco_folder}/../LICENSE*")

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(MuJoCo REQUIRED_VARS MUJOCO_LIBRARY MUJOCO_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "run scripts/setup, or give the folder of an installed MuJoCo 4.0.0 with -DMUJOCO_DIR=")

if(MuJoCo_FOUND AND NOT TARGET MuJoCo::MuJoCo)
  add_library(MuJoCo::MuJoCo SHARED IMPORTED)
  set_target_properties(MuJoCo::MuJoCo PROPERTIES
    IMPORTED_LOCATION "${MUJOCO_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${MUJOCO_INCLUDE_DIR}")
endif()
