#include "voxelserver/make/worlds/luanti/luanti_world.hpp"

#include <string>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/make/worlds/luanti/block_survey.hpp"
#include "voxelserver/make/worlds/luanti/column_boxes.hpp"
#include "voxelserver/make/worlds/luanti/world_files.hpp"

namespace terravox::luanti {
namespace {

using voxel::BoxKey;
using voxel::FineColumn;
using voxel::floor_div;

constexpr std::size_t kMinMemoryBytes = std::size_t{16} << 20;

// The beginning of messages.
std::string opening(const LuantiWorldOptions& options) {
    return "open the Luanti world " + options.path.string() + ": ";
}

/// Blocks are decoded once for all the boxes that they touch, and kept under a byte limit.
class LuantiWorld final : public voxel::PyramidWorld {
public:
    LuantiWorld(const LuantiWorldOptions& options, const minecraft::BlockTable& nodes)
        : PyramidWorld(options.memory_bytes / 2),
          m_files(find_world_files(options.path)),
          m_database(m_files.map),
          m_appearances(nodes),
          m_blocks(options.memory_bytes / 4) {
        BlockSurvey survey = survey_blocks(m_database, m_appearances, m_damage, options.threads,
                                           options.max_surveyed);
        if (survey.blocks == 0 && m_damage.lines().empty())
            throw util::UsageError(opening(options) +
                                   "it has no map blocks; allowed: at least one");
        if (survey.damaged == survey.looked_at)
            throw util::Error(opening(options) +
                              "none of its map blocks can be read; the first reason: " +
                              m_damage.lines().front());
        m_info.title = m_files.title;
        m_info.bounds = survey.bounds;
        m_info.framed = survey.framed;
        m_info.levels = levels_for(m_info.bounds);
        m_index = std::move(survey.index);
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::vector<std::string> damage() const override { return m_damage.lines(); }

protected:
    [[nodiscard]] FineColumn make_column(std::int32_t bx, std::int32_t bz) override {
        const BlockIndex::Heights heights = m_index.heights(bx, bz);
        FineColumn out;
        if (heights.begin == heights.end)
            return out;
        out.by_begin = floor_div(heights.begin, BoxBlocks::kHigh);
        const std::int32_t by_end = floor_div(heights.end - 1, BoxBlocks::kHigh) + 1;
        MapBlockReader reader;
        for (std::int32_t by = out.by_begin; by < by_end; ++by)
            out.boxes.push_back(make_box({0, bx, by, bz}, reader));
        return out;
    }

    [[nodiscard]] bool may_hold_column(int level, std::int32_t bx, std::int32_t bz) const override {
        return m_index.holds(level, bx, bz);
    }

private:
    // The blocks around matter only where the box holds anything, and only those that share a face
    // with it.
    std::shared_ptr<const voxel::Box> make_box(const BoxKey& key, MapBlockReader& reader) {
        BoxBlocks blocks;
        bool holds_any = false;
        const auto load = [&](int sides) {
            for (int y = -1; y <= BoxBlocks::kHigh; ++y) {
                for (int z = -1; z <= BoxBlocks::kAcross; ++z) {
                    for (int x = -1; x <= BoxBlocks::kAcross; ++x) {
                        if (BoxBlocks::sides_passed(x, y, z) != sides)
                            continue;
                        blocks.at(x, y, z) =
                            block({key.bx * BoxBlocks::kAcross + x, key.by * BoxBlocks::kHigh + y,
                                   key.bz * BoxBlocks::kAcross + z},
                                  reader);
                        holds_any = holds_any || blocks.at(x, y, z) != nullptr;
                    }
                }
            }
        };
        load(0);
        if (!holds_any)
            return nullptr;
        load(1);
        return box_of(blocks, key);
    }

    // nullptr: air, because the block does not exist, or is damaged.
    std::shared_ptr<const NodeBlock> block(const BlockPlace& place, MapBlockReader& reader) {
        const BlockIndex::Heights heights = m_index.heights(floor_div(place.x, BoxBlocks::kAcross),
                                                            floor_div(place.z, BoxBlocks::kAcross));
        if (place.y < heights.begin || place.y >= heights.end)
            return nullptr;
        return m_blocks.get(
            place, [&] { return read(place, reader); },
            [](const auto& made) { return made ? made->memory_bytes() : 0; });
    }

    std::shared_ptr<const NodeBlock> read(const BlockPlace& place, MapBlockReader& reader) {
        try {
            const std::vector<std::uint8_t> blob = m_database.read(place);
            return blob.empty() ? nullptr : node_block_of(reader.read(blob), m_appearances);
        } catch (const util::Error& e) {
            m_damage.add(name_of(place) + ": " + e.what());
            return nullptr;
        }
    }

    const WorldFiles m_files;
    MapDatabase m_database;
    NodeAppearances m_appearances;
    worlds::DamageLog m_damage;
    voxel::WorldInfo m_info;
    BlockIndex m_index;
    util::Cache<BlockPlace, NodeBlock, BlockPlaceHash> m_blocks;
};

}  // namespace

std::unique_ptr<voxel::World> open_luanti_world(const LuantiWorldOptions& options,
                                                const minecraft::BlockTable& nodes) {
    if (options.memory_bytes < kMinMemoryBytes)
        throw util::UsageError(opening(options) + std::to_string(options.memory_bytes >> 20) +
                               " MiB of memory; allowed: at least " +
                               std::to_string(kMinMemoryBytes >> 20));
    if (options.max_surveyed == 0)
        throw util::UsageError(opening(options) +
                               "looks through 0 map blocks; allowed: at least 1");
    return std::make_unique<LuantiWorld>(options, nodes);
}

}  // namespace terravox::luanti
