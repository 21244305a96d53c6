#include "voxelserver/out/export/core/changed_columns.hpp"

#include <set>
#include <utility>
#include <vector>

namespace terravox::exports {
namespace {

using Places = std::set<std::pair<std::int32_t, std::int32_t>>;  // by z, then by x

Places places_of(const Part& part, std::span<const ColumnAt> columns) {
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
    const Places replaced = places_of(part, changed);
    ChangedColumns out;
    for (const auto& [bz, bx] : replaced)
        out.replaced.push_back({bx, bz});
    for (const auto& [bz, bx] : places_of(part, others))
        if (!replaced.contains({bz, bx}))
            out.compared.push_back({bx, bz});
    return out;
}

}  // namespace terravox::exports
