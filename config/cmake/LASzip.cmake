# LASzip as the imported target LASzip::laszip.
#
# Why a module of our own: Debian 12 has no LASzip package, and damaged files crash LASzip as it is (below). The official sources are
# taken from the source package `laszip` of the Python package index, which `./terravox deps` downloads and checks
# (config/setup/laszip.sh). The project's own CMake files in there force C++11 late and fail with GCC 12, so this module compiles the
# same list of sources as a static library with C++17 (docs/adr/0002).
include_guard(GLOBAL)

set(TERRAVOX_LASZIP_DIR "${PROJECT_SOURCE_DIR}/build/deps/laszip" CACHE PATH "Unpacked LASzip sources")
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

# GPS times of point formats 1 to 5 are read by a function that calls itself each time the file says "the other sequence". A good file says so
# once for a point, a damaged one a hundred thousand times: the stack ends. So the calls are counted (laszip_guard.h), in a copy.
set(laszip_damaged "${TERRAVOX_LASZIP_DIR}/src/lasreaditemcompressed_v2.cpp")
set(laszip_guarded "${PROJECT_BINARY_DIR}/laszip-guarded/lasreaditemcompressed_v2.cpp")
file(READ "${laszip_damaged}" laszip_text)
string(REPLACE "read(item, context);" "{ TERRAVOX_LASZIP_COUNT_CALL; read(item, context); }" laszip_text_guarded "${laszip_text}")
if(laszip_text STREQUAL laszip_text_guarded)
  message(FATAL_ERROR "LASzip: ${laszip_damaged} is not the one that config/cmake/LASzip.cmake knows how to guard")
endif()
file(CONFIGURE OUTPUT "${laszip_guarded}" CONTENT "${laszip_text_guarded}" @ONLY)
list(TRANSFORM laszip_sources REPLACE "^${laszip_damaged}$" "${laszip_guarded}")
# The API header lives in dll/ but is included as <laszip/laszip_api.h> once installed: lay it out the same way.
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/laszip-include/laszip")
foreach(header dll/laszip_api.h include/laszip/laszip_common.h include/laszip/laszip_api_version.h)
  file(COPY "${TERRAVOX_LASZIP_DIR}/${header}" DESTINATION "${PROJECT_BINARY_DIR}/laszip-include/laszip")
endforeach()
add_library(terravox_laszip STATIC ${laszip_sources})
target_compile_features(terravox_laszip PRIVATE cxx_std_17)
target_compile_definitions(terravox_laszip PRIVATE LASZIPDLL_EXPORTS UNORDERED HAVE_UNORDERED_MAP=1 NDEBUG)
target_compile_options(terravox_laszip PRIVATE -w -O3)
# The one source that holds the file stream; others say std::getc, which a macro would break.
set_property(SOURCE "${TERRAVOX_LASZIP_DIR}/src/laszip_dll.cpp" APPEND PROPERTY COMPILE_OPTIONS
             "-include;${PROJECT_SOURCE_DIR}/config/cmake/laszip_unlocked_getc.h")
set_property(SOURCE "${laszip_guarded}" APPEND PROPERTY COMPILE_OPTIONS "-include;${PROJECT_SOURCE_DIR}/config/cmake/laszip_guard.h")
target_include_directories(terravox_laszip PRIVATE "${TERRAVOX_LASZIP_DIR}/src" "${TERRAVOX_LASZIP_DIR}/dll")
target_include_directories(terravox_laszip SYSTEM PUBLIC "${PROJECT_BINARY_DIR}/laszip-include"
                           "${PROJECT_BINARY_DIR}/laszip-include/laszip")
add_library(LASzip::laszip ALIAS terravox_laszip)
