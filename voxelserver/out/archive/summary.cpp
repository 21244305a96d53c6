#include "voxelserver/out/archive/summary.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/util/printable.hpp"
#include "common/voxel/archive/archive_index.hpp"
#include "common/voxel/archive/change.hpp"
#include "common/voxel/archive/shard.hpp"
#include "common/voxel/world_json.hpp"

namespace terravox::archive_tools {

using voxel::archive::ArchiveIndex;
using voxel::archive::Entry;
using voxel::archive::Kind;

std::uint64_t Summary::holes() const noexcept {
    std::uint64_t count = 0;
    for (const LevelSummary& level : levels)
        count += level.holes;
    return count;
}

Summary summary_of(const ArchiveFiles& archive) {
    const auto source = archive.open();
    const ArchiveIndex index(*source, ArchiveIndex::Of::kAnyFile);
    Summary out;
    out.file_bytes = index.header().file_bytes;
    out.damage = index.header().damage;
    if (index.kind() == voxel::archive::FileKind::kShard) {
        const voxel::archive::Shard shard = voxel::archive::read_shard(*source, index);
        out.damage = static_cast<std::uint32_t>(shard.damage.size());
        out.shard = {shard.number, shard.of};
    }
    if (index.kind() == voxel::archive::FileKind::kChange) {
        const voxel::archive::Change change = voxel::archive::read_change(*source, index);
        out.damage = static_cast<std::uint32_t>(change.damage.size());
        out.replaced_columns = change.replaced.count();
    }
    out.facts = voxel::world_to_json(index.info());
    out.levels.resize(static_cast<std::size_t>(index.info().levels));
    for (std::size_t leaf = 0; leaf < index.leaves().size(); ++leaf) {
        for (const Entry& entry : index.entries(leaf)) {
            LevelSummary& level = out.levels[static_cast<std::size_t>(entry.key.level)];
            if (entry.kind == Kind::kHole) {
                ++level.holes;
                continue;
            }
            ++level.boxes;
            level.bytes += entry.bytes;
        }
    }
    return out;
}

std::string text_of(const Summary& summary) {
    const voxel::WorldInfo world = voxel::world_from_json(summary.facts, "the archive");
    const auto row = [](std::string_view name, const std::string& text) {
        return fmt::format("{:<12} {}\n", name, util::printable(text));
    };
    const auto metres = [&](std::size_t axis) {
        return (world.bounds.max[axis] - world.bounds.min[axis]) * world.voxel_m;
    };
    std::string out;
    if (!world.title.empty())
        out += row("title", world.title);
    out += row("format", fmt::format("box archive, version {}, {:.1f} MB", voxel::archive::kVersion,
                                     static_cast<double>(summary.file_bytes) / 1e6));
    if (summary.shard.of > 0)
        out += row("shard", fmt::format("{} of {}", summary.shard.number, summary.shard.of));
    if (summary.replaced_columns)
        out +=
            row("change", fmt::format("replaces {} columns of boxes", *summary.replaced_columns));
    out += row("CRS", world.crs.empty() ? "none" : world.crs);
    out += row("extent", fmt::format("{:.1f} x {:.1f} m, {:.1f} m high; voxels of {} m", metres(0),
                                     metres(2), metres(1), world.voxel_m));
    if (!world.licence.empty())
        out += row("licence", world.licence);
    if (!world.attribution.empty())
        out += row("attribution", world.attribution);
    out += row("damage", fmt::format("{} in the data that it was made from", summary.damage));
    for (std::size_t i = 0; i < summary.levels.size(); ++i) {
        const LevelSummary& level = summary.levels[i];
        out += row(fmt::format("level {}", i),
                   fmt::format("{} boxes, {:.1f} MB; {} holes", level.boxes,
                               static_cast<double>(level.bytes) / 1e6, level.holes));
    }
    return out;
}

std::string json_of(const Summary& summary) {
    nlohmann::ordered_json out;
    out["bytes"] = summary.file_bytes;
    out["damage"] = summary.damage;
    if (summary.shard.of > 0) {
        out["shard"] = summary.shard.number;
        out["shards"] = summary.shard.of;
    }
    if (summary.replaced_columns)
        out["replaced_columns"] = *summary.replaced_columns;
    out["levels"] = nlohmann::ordered_json::array();
    for (const LevelSummary& level : summary.levels)
        out["levels"].push_back(
            {{"boxes", level.boxes}, {"holes", level.holes}, {"bytes", level.bytes}});
    out["world"] = nlohmann::ordered_json::parse(summary.facts);
    return out.dump(2, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace terravox::archive_tools
