# One module = one folder = one static library rangegrasp_<name>, alias rangegrasp::<name>.
#
#   rangegrasp_module(NAME core SOURCES a.cpp b.cpp PUBLIC Eigen3::Eigen PRIVATE foo SYSTEM_INCLUDES dir...)
#
# Warnings are errors in our code; third-party headers come in as SYSTEM.
include(CMakeParseArguments)

function(rangegrasp_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow -Werror)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # False alarms of GCC 12 on std::optional members that are moved, and on "text" + std::string.
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -Wno-restrict)
  endif()
  if(RANGEGRASP_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${RANGEGRASP_SANITIZE} -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${RANGEGRASP_SANITIZE})
  endif()
endfunction()

function(rangegrasp_module)
  cmake_parse_arguments(M "" "NAME" "SOURCES;PUBLIC;PRIVATE;SYSTEM_INCLUDES" ${ARGN})
  set(target rangegrasp_${M_NAME})
  add_library(${target} STATIC ${M_SOURCES})
  add_library(rangegrasp::${M_NAME} ALIAS ${target})
  target_include_directories(${target} PUBLIC "${PROJECT_SOURCE_DIR}/src")
  target_include_directories(${target} SYSTEM PRIVATE ${M_SYSTEM_INCLUDES})
  target_link_libraries(${target} PUBLIC ${M_PUBLIC} PRIVATE ${M_PRIVATE})
  rangegrasp_compile_options(${target})
endfunction()
