# Writes version.cpp with the commit of the checkout. It runs at every build and touches the file only when it changes.
# A "+" marks uncommitted changes, except for the pages, into which scripts/figures writes measured results.
execute_process(COMMAND git -C "${SOURCE_DIR}" rev-parse --short=12 HEAD
  OUTPUT_VARIABLE RANGEGRASP_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
execute_process(COMMAND git -C "${SOURCE_DIR}" diff --quiet HEAD -- . :!docs :!README.md
  ERROR_QUIET RESULT_VARIABLE changed)
# New sources are compiled as well.
execute_process(COMMAND git -C "${SOURCE_DIR}" ls-files --others --exclude-standard -- src cmake
  OUTPUT_VARIABLE untracked ERROR_QUIET)
if(failed)
  set(RANGEGRASP_COMMIT unknown)
elseif(changed OR untracked)
  string(APPEND RANGEGRASP_COMMIT "+")
endif()
configure_file("${SOURCE_DIR}/src/base/version.cpp.in" "${OUTPUT}" @ONLY)
