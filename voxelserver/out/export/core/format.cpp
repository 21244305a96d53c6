#include "voxelserver/out/export/core/format.hpp"

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::exports {

namespace fs = std::filesystem;

void check_file_target(const fs::path& out, const WriteOptions& options) {
    util::check_writable(out);
    if (fs::exists(out) && !options.overwrite) {
        throw util::UsageError("convert to " + out.string() +
                               ": it is there already; allowed: another name, or --overwrite");
    }
}

std::uint64_t column_steps(const Part& part, const voxel::WorldInfo& /*world*/) {
    const voxel::BoxRange boxes = part.boxes();
    const auto width = static_cast<std::uint64_t>(boxes.max.bx - boxes.min.bx);
    const auto depth = static_cast<std::uint64_t>(boxes.max.bz - boxes.min.bz);
    return width * depth;
}

}  // namespace terravox::exports
