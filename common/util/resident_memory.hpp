#pragma once

#include <unistd.h>

#include <cstdint>
#include <fstream>

namespace terravox::util {

/// Resident memory (RSS) of this process in bytes; 0 where the system does not report it.
[[nodiscard]] inline std::uint64_t resident_bytes() {
    std::uint64_t all = 0;
    std::uint64_t resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace terravox::util
