# Finds the OpenCV libraries that are used here and defines OpenCVParts::core, OpenCVParts::imgproc and, as the component calib3d,
# OpenCVParts::calib3d.
# The libraries are found by name, because Debian's OpenCVConfig.cmake requires every OpenCV library, and libopencv-dev, which contains
# it, depends on hundreds of packages. OpenCVParts_VERSION is read from core/version.hpp.
find_path(OPENCVPARTS_INCLUDE_DIR opencv2/core/version.hpp PATH_SUFFIXES opencv4)
set(_opencvparts_required OPENCVPARTS_INCLUDE_DIR)
set(_opencvparts core imgproc)
if("calib3d" IN_LIST OpenCVParts_FIND_COMPONENTS)
  list(APPEND _opencvparts calib3d)
endif()
foreach(_part ${_opencvparts})
  find_library(OPENCVPARTS_${_part}_LIBRARY NAMES opencv_${_part})
  list(APPEND _opencvparts_required OPENCVPARTS_${_part}_LIBRARY)
endforeach()

if(OPENCVPARTS_INCLUDE_DIR)
  file(STRINGS "${OPENCVPARTS_INCLUDE_DIR}/opencv2/core/version.hpp" _opencvparts_lines REGEX "#define CV_VERSION_(MAJOR|MINOR|REVISION)")
  string(REGEX MATCHALL "[0-9]+" _opencvparts_numbers "${_opencvparts_lines}")
  list(JOIN _opencvparts_numbers "." OpenCVParts_VERSION)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVParts REQUIRED_VARS ${_opencvparts_required} VERSION_VAR OpenCVParts_VERSION
  REASON_FAILURE_MESSAGE "Debian's packages are libopencv-core-dev, libopencv-imgproc-dev and libopencv-calib3d-dev")

if(OpenCVParts_FOUND)
  foreach(_part ${_opencvparts})
    if(NOT TARGET OpenCVParts::${_part})
      add_library(OpenCVParts::${_part} UNKNOWN IMPORTED)
      set_target_properties(OpenCVParts::${_part} PROPERTIES
        IMPORTED_LOCATION "${OPENCVPARTS_${_part}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OPENCVPARTS_INCLUDE_DIR}")
    endif()
  endforeach()
  set_property(TARGET OpenCVParts::imgproc PROPERTY INTERFACE_LINK_LIBRARIES OpenCVParts::core)
  if(TARGET OpenCVParts::calib3d)
    set_property(TARGET OpenCVParts::calib3d PROPERTY INTERFACE_LINK_LIBRARIES OpenCVParts::imgproc)
  endif()
endif()
