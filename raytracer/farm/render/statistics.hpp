#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/farm/processors/processor_pool.hpp"
#include "raytracer/farm/render/passes/passes.hpp"

namespace terravox::render {

/// Cost of a rendered picture: printed, written as a report, and stored in the picture.
struct RenderStatistics {
    RenderCounts counts;
    blocks::BlockStats blocks;
    std::size_t limit_bytes = 0;       ///< limit for boxes
    std::uint64_t peak_rss_bytes = 0;  ///< of the whole process; 0: not known
    double seconds = 0;
    int threads = 1;
    /// What rendered; empty: threads of this process alone.
    std::vector<processors::ProcessorPool::Status> participants;
    processors::ProcessorPool::Counts pool;
    std::vector<std::string> damage;  ///< of the world's data, as World::damage()

    [[nodiscard]] bool has_holes() const noexcept {
        return !counts.holes.empty() || counts.missing > 0 || !damage.empty();
    }
};

/// Peak memory of this process so far, bytes; 0 where the system does not report it.
[[nodiscard]] std::uint64_t peak_rss_bytes() noexcept;

[[nodiscard]] nlohmann::json make_report(const RenderStatistics& statistics,
                                         const util::StageTimes& times, const shade::View& view);
/// Prints a summary of a few lines.
void print_statistics(const RenderStatistics& statistics, const util::StageTimes& times);
/// What a picture says of its data: their attribution, and the name of their licence where the
/// attribution does not have it. Empty: nothing is known.
[[nodiscard]] std::string find_copyright(const voxel::WorldInfo& world);

/// Everything that is stored in a picture in addition to its light. It is the same for each run
/// that makes the same picture, except with `with_run`, which adds the cost of this run: for
/// formats that are used as working files (EXR), not for those that are compared byte by byte.
[[nodiscard]] output::PictureInfo picture_info(const shade::View& view,
                                               const voxel::WorldInfo& world,
                                               const RenderStatistics& statistics, bool with_run);

}  // namespace terravox::render
