# Finds Mesa's off-screen library, by its run-time name too, and defines OSMesa::OSMesa. Headers are not needed:
# src/base/image/open_gl.h declares what is used.
find_library(OSMESA_LIBRARY NAMES OSMesa libOSMesa.so.8)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OSMesa REQUIRED_VARS OSMESA_LIBRARY REASON_FAILURE_MESSAGE "Debian's package is libosmesa6")

if(OSMesa_FOUND AND NOT TARGET OSMesa::OSMesa)
  add_library(OSMesa::OSMesa UNKNOWN IMPORTED)
  set_target_properties(OSMesa::OSMesa PROPERTIES IMPORTED_LOCATION "${OSMESA_LIBRARY}")
endif()
