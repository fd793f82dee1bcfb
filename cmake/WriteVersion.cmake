# Writes version.cpp with the commit of the checkout; run at every build, touches the file only when it changes.
execute_process(COMMAND git -C "${SOURCE_DIR}" describe --always --dirty=+ --abbrev=12
  OUTPUT_VARIABLE RANGEGRASP_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(RANGEGRASP_COMMIT unknown)
endif()
configure_file("${SOURCE_DIR}/src/base/version.cpp.in" "${OUTPUT}" @ONLY)
