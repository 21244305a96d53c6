#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// The middle and the spread of some numbers.
struct Summary {
    double median = 0;
    double mad = 0;  ///< median absolute deviation from the median: one bad run does not move it
    double min = 0;
    double max = 0;
    std::size_t count = 0;
};

/// The mean of the two middle numbers when their count is even. @throws Error without any
[[nodiscard]] double measure_median(std::vector<double> values);
[[nodiscard]] Summary summarize(const std::vector<double>& values);

struct Metric {
    std::string name;
    std::string unit;
    std::vector<double> values;  ///< in the order of the runs
    Target target = {};
};

enum class Status { kMeasured, kSkipped, kFailed };
[[nodiscard]] const char* status_name(Status status) noexcept;

struct Result {
    std::string name;
    std::string measures;
    std::string work;
    std::string floor;
    Status status = Status::kMeasured;
    std::string reason;           ///< one line, when skipped or failed
    std::vector<Metric> metrics;  ///< of the runs after the warm-up; empty unless measured
    double others_cores =
        -1;  ///< cores that other programs kept busy during those runs; negative: not known
    std::vector<std::string> notes = {};  ///< of the last run, Markdown
};

struct Repeats {
    int warmup = 1;
    int runs = 5;
};

/// Collects the readings of one more run. @throws Error when a metric changes its unit
void add_readings(std::vector<Metric>& metrics, const Readings& readings);

/// Warms up, repeats, collects. Never throws for what the entry does: its failure is a result.
/// @param stop ends between two runs: failed, "interrupted"
[[nodiscard]] Result measure(const Entry& entry, const Context& context, Repeats repeats,
                             const std::atomic<bool>& stop);

}  // namespace terravox::bench
