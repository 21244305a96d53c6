# Writes HEADER with a name for what this build makes of a scene: a hash of the sources that
# pictures depend on, the compiler and its flags. Run as a script before each build; the header
# changes only when the name does.
#   cmake -DROOT=... -DHEADER=... -DCOMPILER=... -P BuildId.cmake
cmake_minimum_required(VERSION 3.25)
file(GLOB_RECURSE sources RELATIVE "${ROOT}"
  "${ROOT}/common/*.[ch]pp" "${ROOT}/raytracer/*.[ch]pp" "${ROOT}/voxelserver/*.[ch]pp"
  "${ROOT}/raytracer/*.proto")
list(SORT sources)
set(all "${COMPILER}")
foreach(source IN LISTS sources)
  file(SHA256 "${ROOT}/${source}" hash)
  string(APPEND all "\n${source} ${hash}")
endforeach()
string(SHA256 id "${all}")
string(SUBSTRING "${id}" 0 16 id)
file(CONFIGURE OUTPUT "${HEADER}" CONTENT "#pragma once

namespace terravox {

/// Names the sources, the compiler and its flags: pictures are bit-identical within one build.
inline constexpr const char* kBuild = \"@id@\";

}  // namespace terravox
" @ONLY)
