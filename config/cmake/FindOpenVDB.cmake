# OpenVDB as OpenVDB::openvdb. The module that Debian ships lies outside CMake's own path and
# requires more than the -dev package brings; header and library are looked up instead.
# The headers use half floats of Imath, and TBB.
find_path(OpenVDB_INCLUDE_DIR openvdb/openvdb.h)
find_library(OpenVDB_LIBRARY openvdb)
find_package(Imath CONFIG QUIET)
find_package(TBB QUIET)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVDB
  REQUIRED_VARS OpenVDB_LIBRARY OpenVDB_INCLUDE_DIR Imath_FOUND TBB_FOUND)
if(OpenVDB_FOUND AND NOT TARGET OpenVDB::openvdb)
  add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
  set_target_properties(OpenVDB::openvdb PROPERTIES
    IMPORTED_LOCATION "${OpenVDB_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenVDB_INCLUDE_DIR}")
  target_link_libraries(OpenVDB::openvdb INTERFACE Imath::Imath TBB::tbb)
endif()
