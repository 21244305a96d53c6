#pragma once

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <new>
#include <string>

namespace terravox::util {

/// Returns free pages that the allocator retains to the system, where possible: after many blocks
/// of different sizes were freed, it may retain as much again as is in use. Takes milliseconds.
inline void trim_heap() noexcept {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

/// To be called before a library that cannot bear to run out of memory. Takes microseconds.
/// @throws std::bad_alloc unless so many bytes can be allocated now
inline void check_memory(std::size_t bytes) {
    // Mapped rather than allocated: a compiler may optimise away an unused allocation.
    void* const room =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED)
        throw std::bad_alloc();
    ::munmap(room, bytes);
}

/// Resident memory (RSS) of a process in bytes; 0 where the system does not report it.
/// @param process its id; "self": this one
[[nodiscard]] inline std::uint64_t resident_bytes(const std::string& process = "self") {
    std::uint64_t all = 0;
    std::uint64_t resident = 0;
    std::ifstream("/proc/" + process + "/statm") >> all >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace terravox::util
