# One folder, one library, and one CMakeLists.txt a wing: what a folder needs stands with its
# library, and a program that links it gets no more than that.
include_guard(GLOBAL)

# terravox_library(name [[IN_MODULE] [WITHOUT_ASSERTIONS | OPTIMISE_LITTLE] | COMMAND_LINE]
#                  [SOURCES file...] [PUBLIC library...] [PRIVATE library...])
#   name                of the static library terravox_<name>, known as terravox::<name>
#   IN_MODULE           a part of shared objects, too (voxelserver/serve/module,
#                       raytracer/apps/library), and compiled for them
#   WITHOUT_ASSERTIONS  all of its sources are (terravox_without_assertions)
#   OPTIMISE_LITTLE     for what no picture or box waits for: links of a farm, plans, panels of a
#                       window; compiled with -O1, which takes two thirds of the time
#   COMMAND_LINE        the same, with precompiled headers of the library CLI11
#   SOURCES             none: a folder of headers
#   PUBLIC              what its headers include; PRIVATE: what only its sources include
function(terravox_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg
    "IN_MODULE;WITHOUT_ASSERTIONS;OPTIMISE_LITTLE;COMMAND_LINE" ""
    "SOURCES;PUBLIC;PRIVATE")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "terravox_library(${name} ...): not understood: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  # Each has precompiled headers of its own.
  set(flavour programs)
  if(arg_IN_MODULE AND arg_WITHOUT_ASSERTIONS)
    set(flavour unchecked_module)
  elseif(arg_IN_MODULE AND arg_OPTIMISE_LITTLE)
    set(flavour little_module)
  elseif(arg_IN_MODULE)
    set(flavour module)
  elseif(arg_WITHOUT_ASSERTIONS)
    set(flavour unchecked)
  elseif(arg_OPTIMISE_LITTLE)
    set(flavour little)
  elseif(arg_COMMAND_LINE)
    set(flavour commands)
  endif()
  if((arg_OPTIMISE_LITTLE AND NOT flavour MATCHES "^little") OR
     (arg_COMMAND_LINE AND NOT flavour STREQUAL commands))
    message(FATAL_ERROR "terravox_library(${name} ...): COMMAND_LINE goes with none of the others, "
            "OPTIMISE_LITTLE with IN_MODULE alone")
  endif()
  set(target terravox_${name})
  if(NOT arg_SOURCES)
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE terravox::settings ${arg_PUBLIC} ${arg_PRIVATE})
  else()
    add_library(${target} STATIC ${arg_SOURCES})
    target_link_libraries(${target} PUBLIC terravox::settings ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
    if(arg_IN_MODULE)
      set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
      target_compile_options(${target} PRIVATE -fno-semantic-interposition)
    endif()
    if(arg_WITHOUT_ASSERTIONS)
      target_compile_options(${target} PRIVATE ${TERRAVOX_WITHOUT_ASSERTIONS})
    endif()
    if(arg_OPTIMISE_LITTLE OR arg_COMMAND_LINE)
      target_compile_options(${target} PRIVATE ${TERRAVOX_OPTIMISE_LITTLE})
    endif()
    terravox_use_precompiled(${target} ${flavour})
    terravox_unite(${target})
  endif()
  add_library(terravox::${name} ALIAS ${target})
endfunction()

# terravox_program(name [sources...]): a program's main(), which no picture or box waits for either.
function(terravox_program name)
  add_executable(${name} ${ARGN})
  target_compile_options(${name} PRIVATE ${TERRAVOX_OPTIMISE_LITTLE})
  terravox_use_precompiled(${name} commands)
endfunction()

# terravox_optimise_little(target source...): the same for single sources of a library.
function(terravox_optimise_little target)
  set_property(SOURCE ${ARGN} TARGET_DIRECTORY ${target}
    APPEND PROPERTY COMPILE_OPTIONS ${TERRAVOX_OPTIMISE_LITTLE})
  # The precompiled headers were compiled with -O3.
  set_property(SOURCE ${ARGN} TARGET_DIRECTORY ${target} PROPERTY SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# terravox_link_module(target module folder): a link to a module where what `target` builds looks
# for it (util::module_file in common/util/folders.hpp); programs lie next to it.
function(terravox_link_module target module folder)
  add_dependencies(${target} ${module})
  add_custom_command(TARGET ${target} POST_BUILD
    COMMAND "${CMAKE_COMMAND}" -E make_directory "${folder}"
    COMMAND "${CMAKE_COMMAND}" -E create_symlink
            "$<TARGET_FILE:${module}>" "${folder}/$<TARGET_FILE_NAME:${module}>"
    VERBATIM)
endfunction()
