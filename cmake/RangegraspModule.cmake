# A module is one folder with all its sources, built as one static library rangegrasp_<name>, alias rangegrasp::<name>.
#
#   rangegrasp_module(NAME base [SOURCES generated.cpp] PUBLIC Eigen3::Eigen PRIVATE foo SYSTEM_INCLUDES dir...)
#
# Warnings are errors in our code; third-party headers are included as SYSTEM. cmake/RangegraspInstall.cmake installs every
# module with its public headers, which are all headers except those in internal/, command/ and task/.
include(CMakeParseArguments)

function(rangegrasp_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow $<$<BOOL:${RANGEGRASP_WARNINGS_ARE_ERRORS}>:-Werror>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 gives false warnings for moved std::optional members and for "text" + std::string.
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -Wno-restrict)
    # In a batch, GCC treats a source as a header; an Impl there may use types of the source's unnamed namespace.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  if(RANGEGRASP_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${RANGEGRASP_SANITIZE} -fno-omit-frame-pointer)
    # With the address sanitizer, Eigen would use its own aligned allocation. OMPL, built without the sanitizer, passes it to free().
    target_compile_definitions(${target} PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1)
    target_link_options(${target} PUBLIC -fsanitize=${RANGEGRASP_SANITIZE})
  endif()
  if(RANGEGRASP_COVERAGE)
    get_target_property(folder ${target} SOURCE_DIR)
    if(folder MATCHES "^${PROJECT_SOURCE_DIR}/src")
      target_compile_options(${target} PRIVATE --coverage -fprofile-update=atomic)
    endif()
    # Cases run in processes that end with _exit, which does not write the coverage counts.
    target_link_options(${target} PUBLIC --coverage -Wl,--wrap=_exit)
    target_link_libraries(${target} PUBLIC $<BUILD_INTERFACE:rangegrasp_coverage>)
  endif()
endfunction()

if(RANGEGRASP_COVERAGE AND NOT TARGET rangegrasp_coverage)
  file(WRITE "${PROJECT_BINARY_DIR}/coverage.cpp"
    "extern \"C\" void __gcov_dump();\nextern \"C\" [[noreturn]] void __real__exit(int);\n"
    "extern \"C\" void __wrap__exit(int code) { __gcov_dump(); __real__exit(code); }\n")
  add_library(rangegrasp_coverage STATIC "${PROJECT_BINARY_DIR}/coverage.cpp")
endif()

# Precompiles headers of the standard library, Eigen and fmt once for all modules. The dev presets do not use this: ccache and
# clang-tidy work better without, and the build then proves that each source includes what it needs.
function(rangegrasp_precompile target)
  if(NOT RANGEGRASP_PRECOMPILE)
    return()
  endif()
  if(NOT TARGET rangegrasp_precompiled)
    file(WRITE "${PROJECT_BINARY_DIR}/precompiled.cpp" "")
    add_library(rangegrasp_precompiled OBJECT "${PROJECT_BINARY_DIR}/precompiled.cpp")
    target_link_libraries(rangegrasp_precompiled PRIVATE Eigen3::Eigen fmt::fmt)
    target_compile_features(rangegrasp_precompiled PRIVATE cxx_std_20)
    target_precompile_headers(rangegrasp_precompiled PRIVATE <Eigen/Dense> <algorithm> <array> <cmath> <cstdint> <filesystem>
      <functional> <limits> <map> <memory> <numeric> <optional> <set> <span> <sstream> <stdexcept> <string> <string_view>
      <tuple> <unordered_map> <utility> <vector> <fmt/format.h>)
  endif()
  target_precompile_headers(${target} REUSE_FROM rangegrasp_precompiled)
endfunction()

# Private libraries that consist of headers only are needed by this build, but not by users who link an installed module.
function(rangegrasp_needed_to_link result)
  set(libraries "")
  foreach(library ${ARGN})
    if(TARGET ${library})
      get_target_property(type ${library} TYPE)
      get_target_property(links ${library} INTERFACE_LINK_LIBRARIES)
      if(type STREQUAL "INTERFACE_LIBRARY" AND NOT links)
        set(library "$<BUILD_INTERFACE:${library}>")
      endif()
    endif()
    list(APPEND libraries ${library})
  endforeach()
  set(${result} ${libraries} PARENT_SCOPE)
endfunction()

# Sources are compiled ten at a time, because most of the time is spent on templates that neighboring sources instantiate, too.
# Names in unnamed namespaces must therefore be unique within a module. CMake's own unity builds use absolute paths, which would
# prevent ccache hits in another clone.
#   rangegrasp_batches(RESULT NAME ROOT source...)  sources are below ROOT, which is an include directory
function(rangegrasp_batches result name root)
  if(NOT RANGEGRASP_BATCHES)
    set(${result} ${ARGN} PARENT_SCOPE)
    return()
  endif()
  set(batches "")
  set(remaining ${ARGN})
  while(remaining)
    list(LENGTH batches number)
    list(SUBLIST remaining 0 10 sources)
    list(REMOVE_ITEM remaining ${sources})
    set(text "")
    foreach(source ${sources})
      file(RELATIVE_PATH path "${root}" "${source}")
      string(APPEND text "#include \"${path}\"\n")
    endforeach()
    list(APPEND batches "${CMAKE_CURRENT_BINARY_DIR}/${name}_${number}.cpp")
    file(CONFIGURE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/${name}_${number}.cpp" CONTENT "${text}" @ONLY)
  endwhile()
  set(${result} ${batches} PARENT_SCOPE)
endfunction()

function(rangegrasp_module)
  cmake_parse_arguments(M "" "NAME" "SOURCES;PUBLIC;PRIVATE;SYSTEM_INCLUDES" ${ARGN})
  set(target rangegrasp_${M_NAME})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  list(SORT sources)
  rangegrasp_batches(sources ${M_NAME} "${PROJECT_SOURCE_DIR}/src" ${sources})
  add_library(${target} STATIC ${sources} ${M_SOURCES})
  add_library(rangegrasp::${M_NAME} ALIAS ${target})
  foreach(root src src/systems)
    target_include_directories(${target} PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/${root}>")
  endforeach()
  target_include_directories(${target} PUBLIC "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/rangegrasp>")
  target_include_directories(${target} SYSTEM PRIVATE ${M_SYSTEM_INCLUDES})
  target_compile_features(${target} PUBLIC cxx_std_20)
  rangegrasp_needed_to_link(private_libraries ${M_PRIVATE})
  target_link_libraries(${target} PUBLIC ${M_PUBLIC} PRIVATE ${private_libraries})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${M_NAME})
  set_property(GLOBAL APPEND PROPERTY RANGEGRASP_MODULES ${target})
  rangegrasp_compile_options(${target})
  rangegrasp_precompile(${target})
endfunction()
