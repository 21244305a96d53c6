#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::jobs {

/// Bounds of one job.
struct JobLimits {
    std::int64_t max_cells = 4'000'000;
    int max_minutes = 30;
    int memory_mib = 1024;  ///< of its process
    int threads = 0;        ///< 0: one for each core
};

/// A checked request for an analysis.
struct JobRequest {
    std::string kind;  ///< terrain, sky, sun, energy, sight
    std::int64_t cells = 0;
    /// Words of `terravox analyse KIND`, each an option with its value.
    std::vector<std::string> words;
};

/// Reads a request: a JSON object of known names, all of whose values are checked. No text of it
/// can name a file or be an option.
/// @param body untrusted
/// @throws UsageError naming what is wrong, and what is allowed
[[nodiscard]] JobRequest read_job_request(std::string_view body, const voxel::WorldInfo& world,
                                          const JobLimits& limits);

/// Names of the kinds.
[[nodiscard]] const std::vector<std::string>& job_kinds();

}  // namespace terravox::jobs
