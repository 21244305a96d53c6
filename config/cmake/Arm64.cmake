# Toolchain: 64-bit ARM, compiled on another processor. Libraries are those of TERRAVOX_ARM64_ROOT,
# which config/setup/arm64.sh makes; programs run in an emulator.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

set(TERRAVOX_ARM64_ROOT "${CMAKE_CURRENT_LIST_DIR}/../../build/deps/arm64"
    CACHE PATH "Debian's libraries for 64-bit ARM")
# Checks of the compiler read this file, too.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES TERRAVOX_ARM64_ROOT)
cmake_path(ABSOLUTE_PATH TERRAVOX_ARM64_ROOT NORMALIZE OUTPUT_VARIABLE CMAKE_SYSROOT)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L "${CMAKE_SYSROOT}")

# Generators and scripts run on this machine; what is linked is the other's.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${CMAKE_SYSROOT}")
set(ENV{PKG_CONFIG_LIBDIR}
    "${CMAKE_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${CMAKE_SYSROOT}/usr/share/pkgconfig")

# The headers of the other's Python, which has the version of this machine's, and the end of the
# names of its modules: CMake and nanobind would ask this machine's Python.
file(GLOB Python_INCLUDE_DIR "${CMAKE_SYSROOT}/usr/include/python3.[0-9]*")
string(REGEX REPLACE ".*/python3\\.([0-9]+)$" ".cpython-3\\1-aarch64-linux-gnu.so" NB_SUFFIX
       "${Python_INCLUDE_DIR}")

# The compiler looks for linkers by its own prefix, and in folders that it is given.
foreach(kind EXE SHARED MODULE)
  set(CMAKE_${kind}_LINKER_FLAGS_INIT "-B${CMAKE_SYSROOT}/linker")
endforeach()
