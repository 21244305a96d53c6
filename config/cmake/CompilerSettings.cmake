# One interface target, terravox::settings, that every target of the project links: include root,
# warnings, floating point and sanitizers. Third-party code (LASzip) does not link it.
include_guard(GLOBAL)

option(TERRAVOX_WERROR "Treat warnings as errors" OFF)
set(TERRAVOX_SANITIZE "" CACHE STRING "Value for -fsanitize=, e.g. address,undefined or thread")

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(TERRAVOX_CCACHE ccache)
if(TERRAVOX_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${TERRAVOX_CCACHE}")
  set(CMAKE_C_COMPILER_LAUNCHER "${TERRAVOX_CCACHE}")
endif()

add_library(terravox_settings INTERFACE)
add_library(terravox::settings ALIAS terravox_settings)
target_include_directories(terravox_settings INTERFACE
  "${PROJECT_SOURCE_DIR}" "${PROJECT_BINARY_DIR}/generated")
# No contraction: a picture must not depend on whether a CPU (or compiler flag) has fused
# multiply-add.
target_compile_options(terravox_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -ffp-contract=off
  # GCC 12 reports false positives inside libstdc++ strings and vectors at -O3 (bugs 105329,
  # 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
# Targets without threads get it, too: a precompiled header is shared, and its flags must be those
# of every source that uses it.
target_compile_options(terravox_settings INTERFACE -pthread)
if(TERRAVOX_WERROR)
  target_compile_options(terravox_settings INTERFACE -Werror)
endif()
# The baseline is every x86-64 CPU since about 2009: the 64-tree needs a popcount instruction. Wider
# SIMD is chosen at run time.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(terravox_settings INTERFACE -march=x86-64-v2)
  # GCC copies and clears values of some hundred bytes, such as rays, by string instructions unless
  # it is told otherwise. Those are slow to start (docs/benchmarks/light.md).
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(by_vectors "unrolled_loop:512:noalign,libcall:-1:noalign")
    target_compile_options(terravox_settings INTERFACE
      $<$<COMPILE_LANGUAGE:CXX>:-mmemcpy-strategy=${by_vectors}>
      $<$<COMPILE_LANGUAGE:CXX>:-mmemset-strategy=${by_vectors}>)
  endif()
endif()
# A damaged or hostile file that finds a fault in a parser should end the program, not run code in
# it. tests/e2e/hardening_test.py reads these back from the built programs.
# - LASzip does not link terravox::settings, so it takes the same list (config/cmake/LASzip.cmake).
# - FORTIFY_SOURCE needs an optimising compiler, and hides from the address sanitizer what it checks
#   itself.
set(TERRAVOX_HARDENING -fstack-protector-strong)
if(NOT TERRAVOX_SANITIZE)
  list(APPEND TERRAVOX_HARDENING -fstack-clash-protection
       $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE> $<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=3>)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND TERRAVOX_HARDENING -fcf-protection=full)
  endif()
endif()
target_compile_options(terravox_settings INTERFACE ${TERRAVOX_HARDENING})
# For all targets, modules in C among them.
add_link_options(-Wl,-z,relro,-z,now,-z,noexecstack)
# Programs get those functions of a library that they need, and with them fewer shared libraries:
# the server starts without GDAL. GNU ld would keep a shared library that only removed functions
# call (docs/adr/0027).
find_program(TERRAVOX_LLD ld.lld)
if(NOT TERRAVOX_LLD)
  message(FATAL_ERROR "The linker LLD (ld.lld, Debian package lld) is missing; "
          "run ./terravox deps first")
endif()
target_compile_options(terravox_settings INTERFACE -ffunction-sections -fdata-sections)
add_link_options(-fuse-ld=lld -Wl,--as-needed,--gc-sections)
# Programs at random addresses. Not by POSITION_INDEPENDENT_CODE, which would compile libraries for
# shared objects (-fPIC): those cost more. The parts of the module terravox-worlds.so set it
# themselves.
target_compile_options(terravox_settings INTERFACE
  $<$<NOT:$<BOOL:$<TARGET_PROPERTY:POSITION_INDEPENDENT_CODE>>>:-fPIE>)
target_link_options(terravox_settings INTERFACE
  $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie>)
# The standard library checks indexes, empty containers and iterators. Sources that trace rays or
# fill voxels leave it out (terravox_library's WITHOUT_ASSERTIONS, terravox_without_assertions()):
# they read only what this program itself has made and checked, and in loops that are small enough
# the checks cost a fifth to twice the time.
target_compile_definitions(terravox_settings INTERFACE _GLIBCXX_ASSERTIONS)
set(TERRAVOX_WITHOUT_ASSERTIONS -U_GLIBCXX_ASSERTIONS)
function(terravox_without_assertions target)
  set_property(SOURCE ${ARGN} TARGET_DIRECTORY ${target}
    APPEND PROPERTY COMPILE_OPTIONS ${TERRAVOX_WITHOUT_ASSERTIONS})
  # The precompiled headers were compiled with the assertions.
  set_property(SOURCE ${ARGN} TARGET_DIRECTORY ${target} PROPERTY SKIP_PRECOMPILE_HEADERS ON)
endfunction()

if(TERRAVOX_SANITIZE)
  target_compile_options(terravox_settings INTERFACE
    -fsanitize=${TERRAVOX_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(terravox_settings INTERFACE -fsanitize=${TERRAVOX_SANITIZE})
endif()
