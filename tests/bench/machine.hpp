#pragma once

#include <string>
#include <vector>

#include "tests/bench/children.hpp"

namespace terravox::bench {

/// Where and with what was measured. Empty texts: not known here.
struct Machine {
    std::string cpu;
    std::string system;
    std::string compiler;
    std::string build_type;
    int cores = 0;  ///< that this process may use
    double memory_gib = 0;
    double load = 0;   ///< mean of the last minute, at the start
    std::string date;  ///< UTC, ISO 8601
    std::string version;
    std::string commit;
};

/// @param scratch folder for the answer of git
[[nodiscard]] Machine read_machine(ChildRunner& children, const std::filesystem::path& scratch);

/// Reasons to doubt the figures, one line each: other programs running, a build that is not
/// optimized.
[[nodiscard]] std::vector<std::string> list_warnings(const Machine& machine);

}  // namespace terravox::bench
