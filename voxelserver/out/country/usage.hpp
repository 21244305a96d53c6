#pragma once

#include <string>

namespace terravox::country {

/// User and system time of this process, seconds.
[[nodiscard]] double used_cpu_s();
/// Most resident memory of this process so far.
[[nodiscard]] double used_peak_mib();
[[nodiscard]] std::string host_name();

}  // namespace terravox::country
