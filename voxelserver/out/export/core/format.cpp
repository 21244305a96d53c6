#include "voxelserver/out/export/core/format.hpp"

#include <set>
#include <utility>

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

namespace {

using Places = std::set<std::pair<std::int32_t, std::int32_t>>;  // by z, then by x

Places find_places(const Part& part, std::span<const ColumnAt> columns) {
    const voxel::BoxRange all = part.boxes();
    Places out;
    for (const ColumnAt& column : columns) {
        const std::int32_t bx = column.bx >> part.level;
        const std::int32_t bz = column.bz >> part.level;
        if (bx >= all.min.bx && bx < all.max.bx && bz >= all.min.bz && bz < all.max.bz)
            out.emplace(bz, bx);
    }
    return out;
}

}  // namespace

ChangedColumns changed_columns(const Part& part, std::span<const ColumnAt> changed,
                               std::span<const ColumnAt> others) {
    const Places replaced = find_places(part, changed);
    ChangedColumns out;
    for (const auto& [bz, bx] : replaced)
        out.replaced.push_back({bx, bz});
    for (const auto& [bz, bx] : find_places(part, others))
        if (!replaced.contains({bz, bx}))
            out.compared.push_back({bx, bz});
    return out;
}

}  // namespace terravox::exports
