# The standard library's headers are most of what a compiler reads of a source here, and Catch2's
# most of what it reads of a test. They are compiled once for each set of flags: GCC requires the
# same flags as for the source.
include_guard(GLOBAL)

option(TERRAVOX_PRECOMPILED_HEADERS
       "Compile the headers of the standard library once; without it, forgotten includes are found"
       ON)

option(TERRAVOX_UNITY_BUILD
       "Compile the sources of a library or a test together, ten at a time; without it, one by one"
       ON)

# terravox_unite(target): sources that share headers are compiled together, which takes a third to
# half of the time. CMake leaves out sources with flags of their own. Names in unnamed namespaces
# have to be unique within a folder.
function(terravox_unite target)
  set_target_properties(${target} PROPERTIES
    UNITY_BUILD ${TERRAVOX_UNITY_BUILD} UNITY_BUILD_BATCH_SIZE 10)
  if(TERRAVOX_UNITY_BUILD)
    # GCC takes the sources for headers, whose classes should not have members of unnamed
    # namespaces.
    target_compile_options(${target} PRIVATE
      $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# ccache keeps what was compiled with precompiled headers only with the setting that times and
# macros in them do not matter.
if(TERRAVOX_PRECOMPILED_HEADERS AND TERRAVOX_CCACHE)
  set(ccache "${CMAKE_COMMAND}" -E env "CCACHE_SLOPPINESS=pch_defines,time_macros"
      "${TERRAVOX_CCACHE}")
  set(CMAKE_CXX_COMPILER_LAUNCHER "${ccache}")
endif()

# Headers that most sources include. No source may rely on it: some builds go without.
set(TERRAVOX_COMMON_HEADERS
    <algorithm> <array> <atomic> <bit> <charconv> <chrono> <cmath> <condition_variable>
    <cstddef> <cstdint> <cstdio> <cstdlib> <cstring> <deque> <exception> <filesystem> <fstream>
    <functional> <limits> <map> <memory> <mutex> <numeric> <optional> <set> <span> <sstream>
    <stop_token> <string> <string_view> <thread> <tuple> <unordered_map> <utility> <variant>
    <vector>)

file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/nothing.cpp"
     CONTENT "// A library of precompiled headers needs a source.\n")

# Some libraries' packages define this for their users, and Catch2 looks at it: it has to be the
# same for all that use one precompiled header.
set(TERRAVOX_PRECOMPILED_DEFINITIONS NOMINMAX)

# ccache needs the first. In precompiled headers GCC 12 reports false positives of the others within
# strings (bug 105651); the preset `dev` goes without them, and takes warnings for errors.
set(TERRAVOX_PRECOMPILED_OPTIONS
    $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overread>)

# terravox_precompile(flavour [IN_MODULE] [OPTIONS option...] [HEADERS header...]
#                     [LIBRARIES target...])
#   makes the precompiled headers that terravox_use_precompiled(target flavour) uses
#   IN_MODULE  for shared objects
#   OPTIONS    as those of the targets that use it
#   HEADERS    more of them, apart from those of the standard library
#   LIBRARIES  that these headers belong to
function(terravox_precompile flavour)
  cmake_parse_arguments(PARSE_ARGV 1 arg "IN_MODULE" "" "OPTIONS;HEADERS;LIBRARIES")
  if(NOT TERRAVOX_PRECOMPILED_HEADERS)
    return()
  endif()
  set(target terravox_precompiled_${flavour})
  add_library(${target} OBJECT "${PROJECT_BINARY_DIR}/generated/nothing.cpp")
  target_link_libraries(${target} PRIVATE terravox::settings ${arg_LIBRARIES})
  if(arg_IN_MODULE)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  target_compile_options(${target} PRIVATE ${arg_OPTIONS})
  target_compile_definitions(${target} PRIVATE ${TERRAVOX_PRECOMPILED_DEFINITIONS})
  target_compile_options(${target} PRIVATE ${TERRAVOX_PRECOMPILED_OPTIONS})
  target_precompile_headers(${target}
    PRIVATE ${TERRAVOX_COMMON_HEADERS} ${arg_HEADERS})
endfunction()

function(terravox_use_precompiled target flavour)
  if(NOT TERRAVOX_PRECOMPILED_HEADERS)
    return()
  endif()
  target_compile_definitions(${target} PRIVATE ${TERRAVOX_PRECOMPILED_DEFINITIONS})
  target_precompile_headers(${target} REUSE_FROM terravox_precompiled_${flavour})
  target_compile_options(${target} PRIVATE ${TERRAVOX_PRECOMPILED_OPTIONS})
endfunction()

# Little optimisation, for what no picture or box waits for: the compiler is done in two thirds of
# the time.
set(TERRAVOX_OPTIMISE_LITTLE $<$<CONFIG:Release>:-O1>)

terravox_precompile(programs)
terravox_precompile(module IN_MODULE OPTIONS -fno-semantic-interposition)
terravox_precompile(unchecked OPTIONS ${TERRAVOX_WITHOUT_ASSERTIONS})
terravox_precompile(unchecked_module IN_MODULE
                    OPTIONS -fno-semantic-interposition ${TERRAVOX_WITHOUT_ASSERTIONS})
terravox_precompile(little OPTIONS ${TERRAVOX_OPTIMISE_LITTLE})
terravox_precompile(little_module IN_MODULE
                    OPTIONS -fno-semantic-interposition ${TERRAVOX_OPTIMISE_LITTLE})
# Command lines: reading the headers of CLI11 takes longer than compiling what uses them.
terravox_precompile(commands OPTIONS ${TERRAVOX_OPTIMISE_LITTLE} HEADERS <CLI/CLI.hpp>
                    LIBRARIES CLI11::CLI11)
