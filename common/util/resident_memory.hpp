#pragma once

#include <unistd.h>

#include <cstdint>
#include <fstream>

namespace terravox::util {

/// Memory that this process has in RAM now, bytes; 0 where the system does not say.
[[nodiscard]] inline std::uint64_t resident_bytes() {
    std::uint64_t all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace terravox::util
