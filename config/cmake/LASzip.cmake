# LASzip as the imported target LASzip::laszip.
#
# Why a module of our own: Debian 12 has no LASzip package, and damaged files crash LASzip as it is
# (below). The official sources are taken from the source package `laszip` of the Python package
# index, which `./terravox deps` downloads and checks (config/setup/laszip.sh). The project's own
# CMake files in there force C++11 late and fail with GCC 12, so this module compiles the same list
# of sources as a static library with C++17 (docs/adr/0002).
include_guard(GLOBAL)

set(TERRAVOX_LASZIP_DIR "${PROJECT_SOURCE_DIR}/build/deps/laszip"
    CACHE PATH "Unpacked LASzip sources")
if(NOT EXISTS "${TERRAVOX_LASZIP_DIR}/src/laszip_dll.cpp")
  message(FATAL_ERROR "LASzip: no sources in ${TERRAVOX_LASZIP_DIR}; run ./terravox deps first")
endif()
message(STATUS "LASzip: built from ${TERRAVOX_LASZIP_DIR}")
# The list of sources is read from LASzip's own file, so that the two cannot drift apart.
file(STRINGS "${TERRAVOX_LASZIP_DIR}/src/CMakeLists.txt" laszip_sources REGEX "^ +[a-z0-9_]+\\.cpp")
list(TRANSFORM laszip_sources STRIP)
list(APPEND laszip_sources laszip_dll.cpp)
list(REMOVE_DUPLICATES laszip_sources)
list(TRANSFORM laszip_sources PREPEND "${TERRAVOX_LASZIP_DIR}/src/")

# Four of LASzip's sources are compiled from copies. Damaged files crash it in two places:
# - GPS times of point formats 1 to 5 are read by a function that calls itself each time the file
#   switches to the other sequence. A good file switches once for a point, a damaged one a hundred
#   thousand times, which overflows the stack. The calls are counted (laszip_guard.h).
# - The arithmetic decoder looks symbols up in tables, and is safe while its value is below its
#   length. It begins with a length of 2^32 - 1 and four bytes of the file as value: only 0xFFFFFFFF
#   is too much, which no encoder writes.
# The third allocates memory, which has to begin as zeros (laszip_guard.h). Without memory it
# returns null pointers, which nobody expects, or what is too small. The fourth is the one source
# that holds a file stream. It is read byte by byte through getc, which locks the stream each time;
# every reader has a stream of its own, and decoding is 8 % faster without.
function(terravox_guard_laszip source from to)
  set(original "${TERRAVOX_LASZIP_DIR}/src/${source}")
  set(guarded "${PROJECT_BINARY_DIR}/laszip-guarded/${source}")
  if("${original}" IN_LIST laszip_sources)
    file(READ "${original}" text)
  else()
    file(READ "${guarded}" text)
  endif()
  string(REPLACE "${from}" "${to}" guarded_text "${text}")
  if(text STREQUAL guarded_text)
    message(FATAL_ERROR "LASzip: ${original} is not the version that config/cmake/LASzip.cmake "
            "can guard")
  endif()
  file(CONFIGURE OUTPUT "${guarded}" CONTENT "${guarded_text}" @ONLY)
  set(sources "${laszip_sources}")
  list(TRANSFORM sources REPLACE "^${original}$" "${guarded}")
  set(laszip_sources "${sources}" PARENT_SCOPE)
endfunction()
add_library(terravox_laszip STATIC)
terravox_guard_laszip(lasreaditemcompressed_v2.cpp
  "read(item, context);"
  "{ TERRAVOX_LASZIP_COUNT_CALL; read(item, context); }")
terravox_guard_laszip(arithmeticdecoder.cpp
  "value |= (instream->getByte());"
  "value |= (instream->getByte()); terravox_laszip::check_value(value);")
terravox_guard_laszip(mydefs.cpp "= malloc(size)" "= terravox_laszip::allocated(calloc(1, size))")
terravox_guard_laszip(mydefs.cpp
  "= realloc(ptr, size)" "= terravox_laszip::allocated(realloc(ptr, size))")
terravox_guard_laszip(laszip_dll.cpp "#include \"bytestreamin_file.hpp\""
  "#define getc getc_unlocked\n#include \"bytestreamin_file.hpp\"\n#undef getc")
target_sources(terravox_laszip PRIVATE ${laszip_sources})

# The API header lives in dll/ but is included as <laszip/laszip_api.h> once installed: lay it out
# the same way.
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/laszip-include/laszip")
foreach(header dll/laszip_api.h include/laszip/laszip_common.h include/laszip/laszip_api_version.h)
  file(COPY "${TERRAVOX_LASZIP_DIR}/${header}"
       DESTINATION "${PROJECT_BINARY_DIR}/laszip-include/laszip")
endforeach()
target_compile_features(terravox_laszip PRIVATE cxx_std_17)
target_compile_definitions(terravox_laszip PRIVATE
  LASZIPDLL_EXPORTS UNORDERED HAVE_UNORDERED_MAP=1 NDEBUG)
# A part of terravox-worlds.so (voxelserver/serve/module).
set_target_properties(terravox_laszip PROPERTIES POSITION_INDEPENDENT_CODE ON)
# It deletes intervals of a spatial index through a base without a virtual destructor: the size that
# would be handed to the allocator is the base's, which allocators and the address sanitizer may
# take for damage.
target_compile_options(terravox_laszip PRIVATE
  -w -O3 -fno-semantic-interposition -fno-sized-deallocation ${TERRAVOX_HARDENING})
if(TERRAVOX_SANITIZE)
  # The address sanitizer checks LASzip, too, since damaged files reach its memory. Its arithmetic
  # relies on what the standard leaves undefined (shifts of negative numbers, unaligned loads), so
  # that sanitizer is left out.
  string(REPLACE "," ";" laszip_sanitizers "${TERRAVOX_SANITIZE}")
  list(REMOVE_ITEM laszip_sanitizers undefined)
  list(TRANSFORM laszip_sanitizers PREPEND "-fsanitize=")
  target_compile_options(terravox_laszip PRIVATE ${laszip_sanitizers} -fno-omit-frame-pointer)
endif()
target_compile_definitions(terravox_laszip PRIVATE _GLIBCXX_ASSERTIONS)
target_include_directories(terravox_laszip PRIVATE
  "${TERRAVOX_LASZIP_DIR}/src" "${TERRAVOX_LASZIP_DIR}/dll")
target_include_directories(terravox_laszip SYSTEM PUBLIC "${PROJECT_BINARY_DIR}/laszip-include"
                           "${PROJECT_BINARY_DIR}/laszip-include/laszip")
# Included before each of its sources. The option keeps what is written before a constructor begins:
# the zeros.
set(guard "${PROJECT_SOURCE_DIR}/config/cmake/laszip_guard.h")
target_compile_options(terravox_laszip PRIVATE
  $<$<CXX_COMPILER_ID:GNU>:-flifetime-dse=1>)
if(TERRAVOX_PRECOMPILED_HEADERS)
  target_precompile_headers(terravox_laszip PRIVATE "${guard}")
  target_compile_options(terravox_laszip PRIVATE ${TERRAVOX_PRECOMPILED_OPTIONS})
else()
  target_compile_options(terravox_laszip PRIVATE "SHELL:-include \"${guard}\"")
endif()
add_library(LASzip::laszip ALIAS terravox_laszip)
