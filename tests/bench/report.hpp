#pragma once

#include <string>
#include <vector>

#include "tests/bench/machine.hpp"
#include "tests/bench/measure.hpp"

namespace terravox::bench {

inline constexpr int kReportVersion = 1;  ///< of the JSON format

struct Report {
    Machine machine;
    std::vector<std::string> warnings;
    Repeats repeats;
    int threads = 1;
    std::vector<Result> results;
};

/// Everything, with the value of every run.
[[nodiscard]] std::string to_json(const Report& report);

/// The machine, a table of medians and spreads with aligned columns (readable as text too), and
/// what was skipped or failed and why.
[[nodiscard]] std::string to_markdown(const Report& report);

/// A number with at least four significant digits, without an exponent from 0.001 to 10^12.
[[nodiscard]] std::string format_number(double value);

}  // namespace terravox::bench
