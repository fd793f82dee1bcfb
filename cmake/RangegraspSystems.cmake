# Systems are built on top of the core, in src/systems/<name>. RANGEGRASP_SYSTEMS selects the systems to build: names, "all", or
# "none" for the core alone. The system.txt of a system lists what it provides (tasks, commands, keys). A program that was built
# without the system can therefore name it, and scripts/rangegrasp can build it when it is first needed:
#
#   about TEXT | minutes N | needs OTHER ... | library | task WORD | command WORD | option WORD | key PATH | value KEY=WORD
set(RANGEGRASP_SYSTEMS all CACHE STRING "Systems to build: names with semicolons, all, or none")

file(GLOB system_files RELATIVE "${PROJECT_SOURCE_DIR}/src/systems" CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/systems/*/system.txt")
set(all_systems "")
foreach(file ${system_files})
  get_filename_component(system ${file} DIRECTORY)
  list(APPEND all_systems ${system})
  file(STRINGS "${PROJECT_SOURCE_DIR}/src/systems/${file}" ${system}_lines REGEX "^[a-z]+ ?")
  set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "src/systems/${file}")
endforeach()

# Adds a system after the systems that it needs.
set(RANGEGRASP_BUILT_SYSTEMS "")
function(rangegrasp_choose system)
  if(NOT system IN_LIST all_systems)
    list(JOIN all_systems ", " words)
    message(FATAL_ERROR "RANGEGRASP_SYSTEMS: no system '${system}'; there are ${words}, all, and none")
  endif()
  foreach(line ${${system}_lines})
    if(line MATCHES "^needs (.*)")
      separate_arguments(needed UNIX_COMMAND "${CMAKE_MATCH_1}")
      foreach(other ${needed})
        rangegrasp_choose(${other})
      endforeach()
    endif()
  endforeach()
  if(NOT system IN_LIST RANGEGRASP_BUILT_SYSTEMS)
    list(APPEND RANGEGRASP_BUILT_SYSTEMS ${system})
  endif()
  set(RANGEGRASP_BUILT_SYSTEMS "${RANGEGRASP_BUILT_SYSTEMS}" PARENT_SCOPE)
endfunction()

set(chosen "${RANGEGRASP_SYSTEMS}")
if(chosen STREQUAL "all")
  set(chosen "${all_systems}")
elseif(chosen STREQUAL "none")
  set(chosen "")
endif()
foreach(system ${chosen})
  rangegrasp_choose(${system})
endforeach()

# Writes code that registers the systems that are built and lists the words of the others.
function(rangegrasp_write_systems file)
  set(declared "")
  set(registered "")
  foreach(system ${RANGEGRASP_BUILT_SYSTEMS})
    if(NOT "library" IN_LIST ${system}_lines)
      string(SUBSTRING ${system} 0 1 first)
      string(SUBSTRING ${system} 1 -1 rest)
      string(TOUPPER ${first} first)
      string(APPEND declared "void Register${first}${rest}();\n")
      string(APPEND registered "  Register${first}${rest}();\n")
    endif()
  endforeach()
  set(words "")
  foreach(system ${all_systems})
    if(NOT system IN_LIST RANGEGRASP_BUILT_SYSTEMS)
      foreach(line ${${system}_lines})
        if(line MATCHES "^(task|command|option|key|value) (.*)")
          string(APPEND words "  base::AddWordNotBuilt({\"${CMAKE_MATCH_1}\", \"${CMAKE_MATCH_2}\", \"${system}\"});\n")
        endif()
      endforeach()
    endif()
  endforeach()
  file(CONFIGURE OUTPUT "${file}" CONTENT "#include \"base/installation.h\"

namespace rangegrasp {

${declared}
void RegisterSystems() {
${registered}${words}}

}  // namespace rangegrasp
" @ONLY)
endfunction()
