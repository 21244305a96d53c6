#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "raytracer/output/picture_info.hpp"
#include "raytracer/processors/processor_pool.hpp"
#include "raytracer/render/render.hpp"

namespace terravox::render {

/// What a rendered picture took: printed, written as a report, and stored in the picture.
struct RenderStatistics {
    RenderCounts counts;
    blocks::BlockStats blocks;
    std::size_t limit_bytes = 0;       ///< for boxes
    std::uint64_t peak_rss_bytes = 0;  ///< of the whole process; 0: not known
    double seconds = 0;
    int threads = 1;
    std::vector<processors::ProcessorPool::Status>
        participants;  ///< who rendered; empty: threads of this process alone
    processors::ProcessorPool::Counts pool;
    std::vector<std::string> damage;  ///< of the world's data, as World::damage()

    [[nodiscard]] bool has_holes() const noexcept {
        return !counts.holes.empty() || counts.missing > 0 || !damage.empty();
    }
};

/// Most memory that this process has had so far, bytes; 0 where the system does not say.
[[nodiscard]] std::uint64_t peak_rss_bytes() noexcept;

[[nodiscard]] nlohmann::json report_of(const RenderStatistics& statistics,
                                       const util::StageTimes& times, const shade::View& view);
/// A few lines for a person.
void print_statistics(const RenderStatistics& statistics, const util::StageTimes& times);
/// All that is stored in a picture beside its light. The same for each run that makes the same
/// picture, but for `with_run`: what this run took, for formats that are kept for work (EXR), not
/// for those that are compared byte by byte.
[[nodiscard]] output::PictureInfo picture_info(const shade::View& view,
                                               const voxel::WorldInfo& world,
                                               const RenderStatistics& statistics, bool with_run);

}  // namespace terravox::render
