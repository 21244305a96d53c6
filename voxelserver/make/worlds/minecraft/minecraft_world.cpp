#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"

#include <algorithm>
#include <unordered_set>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/util/handle_pool.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "common/voxel/side_car.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_survey.hpp"
#include "voxelserver/make/worlds/minecraft/voxel_chunk.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::minecraft {
namespace {

using voxel::BoxKey;
using voxel::FineColumn;
using voxel::floor_div;

constexpr std::size_t kMinMemoryBytes = std::size_t{16} << 20;
constexpr std::int32_t kChunksAcross = voxel::kBoxSizeX / 16;

// The beginning of messages.
std::string opening(const MinecraftWorldOptions& options) {
    return "open the Minecraft world " + options.path.string() + ": ";
}

voxel::SideCar side_car_in(const WorldFolder& folder) {
    if (!folder.side_car())
        return {};
    const std::string origin = (folder.path() / joined(folder.root(), "terravox.json")).string();
    voxel::SideCar car = voxel::side_car_from_json(*folder.side_car(), origin);
    for (const std::int32_t offset : car.offset)
        if (offset % 16 != 0)
            throw util::Error(
                "read the side-car {}: offset {}; allowed for a Minecraft world: multiples of 16",
                origin, offset);
    return car;
}

BlockTable with_overlay(BlockTable table, const voxel::SideCar& car) {
    if (!car.blocks.empty())
        table.overlay(car.blocks);
    return table;
}

/// Chunks are decoded once for all the boxes that they touch, and kept under a byte limit.
class MinecraftWorld final : public voxel::PyramidWorld {
public:
    MinecraftWorld(const MinecraftWorldOptions& options, const BlockTable& blocks)
        : PyramidWorld(options.memory_bytes / 8 * 4),
          m_folder(options.path, options.memory_bytes / 8),
          m_car(side_car_in(m_folder)),
          m_store(m_folder, m_folder.dimension(options.dimension), options.threads),
          m_block_appearances(with_overlay(blocks, m_car)),
          m_chunks(options.memory_bytes / 8 * 3) {
        for (const std::string& line : m_folder.damage())
            m_damage.add(line);
        for (const std::string& line : m_store.damage())
            m_damage.add(line);
        const ChunkSurvey survey = survey_chunks(m_store, m_block_appearances, m_damage,
                                                 options.threads, options.max_surveyed);
        if (m_store.chunks().empty() && m_store.damage().empty())
            throw util::UsageError("{}no chunks in its dimension {}", opening(options),
                                   options.dimension);
        if (survey.readable == 0)
            throw util::Error("{}none of its chunks can be read; the first reason: {}",
                              opening(options), m_damage.lines().front());
        set_info(survey);
        set_columns(survey);
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::vector<std::string> damage() const override { return m_damage.lines(); }

protected:
    [[nodiscard]] FineColumn make_column(std::int32_t bx, std::int32_t bz) override {
        ChunkPatch patch;
        const ChunkPlace first{bx * kChunksAcross - m_car.offset[0] / 16,
                               bz * kChunksAcross - m_car.offset[2] / 16};
        for (std::int32_t i = 0; i < 36; ++i)
            patch[static_cast<std::size_t>(i)] = chunk({first.x + i % 6 - 1, first.z + i / 6 - 1});
        const voxel::BoxRange range = voxel::boxes_over(m_info.bounds, 0);
        FineColumn out;
        out.by_begin = range.min.by;
        for (std::int32_t by = range.min.by; by < range.max.by; ++by)
            out.boxes.push_back(to_box(patch, {0, bx, by, bz}, m_car.offset[1]));
        return out;
    }

    [[nodiscard]] bool may_hold_column(int level, std::int32_t bx, std::int32_t bz) const override {
        return m_columns[static_cast<std::size_t>(level)].contains({bx, bz});
    }

private:
    using Columns = std::unordered_set<ChunkPlace, ChunkPlaceHash>;  // columns of boxes, not chunks

    void set_info(const ChunkSurvey& survey) {
        m_info = m_car.world;
        if (m_info.title.empty())
            m_info.title = m_folder.title();
        if (survey.places.empty() || survey.min_y >= survey.max_y)
            return;
        ChunkArea all{survey.places.front(), survey.places.front()};
        for (const ChunkPlace& place : survey.places) {
            all.min = {std::min(all.min.x, place.x), std::min(all.min.z, place.z)};
            all.max = {std::max(all.max.x, place.x + 1), std::max(all.max.z, place.z + 1)};
        }
        m_info.bounds = measure_bounds(all, survey);
        if (const auto part = main_part(survey.places))
            m_info.framed = measure_bounds(*part, survey);
        m_info.levels = levels_for(m_info.bounds);
    }

    voxel::VoxelBounds measure_bounds(const ChunkArea& area,
                                      const ChunkSurvey& survey) const noexcept {
        const auto& o = m_car.offset;
        return {{area.min.x * 16 + o[0], survey.min_y + o[1], area.min.z * 16 + o[2]},
                {area.max.x * 16 + o[0], survey.max_y + o[1], area.max.z * 16 + o[2]}};
    }

    void set_columns(const ChunkSurvey& survey) {
        m_columns.resize(static_cast<std::size_t>(m_info.levels));
        for (const ChunkPlace& place : survey.places)
            m_columns[0].insert({floor_div(place.x + m_car.offset[0] / 16, kChunksAcross),
                                 floor_div(place.z + m_car.offset[2] / 16, kChunksAcross)});
        for (std::size_t level = 1; level < m_columns.size(); ++level)
            for (const ChunkPlace& finer : m_columns[level - 1])
                m_columns[level].insert({floor_div(finer.x, 2), floor_div(finer.z, 2)});
    }

    // nullptr: air, because the chunk does not exist, or is damaged.
    std::shared_ptr<const VoxelChunk> chunk(const ChunkPlace& place) {
        const ChunkRef* ref = m_store.find(place);
        if (ref == nullptr)
            return nullptr;
        return m_chunks.get(
            place, [&] { return read(*ref); },
            [](const auto& made) { return made ? made->memory_bytes() : 0; });
    }

    std::shared_ptr<const VoxelChunk> read(const ChunkRef& ref) {
        const auto tools = m_tools.borrow(
            [&] { return std::make_unique<ChunkTools>(m_store, m_block_appearances); });
        try {
            VoxelChunk made = tools->maker.make(tools->reader.read(ref, m_damage));
            if (made.sections.empty())
                return nullptr;
            report_if_outside(ref, made);
            return std::make_shared<const VoxelChunk>(std::move(made));
        } catch (const util::Error& e) {
            m_damage.add(m_store.to_name(ref) + ": " + e.what());
            return nullptr;
        }
    }

    // The heights of a large world are estimated from a part of its chunks.
    void report_if_outside(const ChunkRef& ref, const VoxelChunk& chunk) {
        const voxel::BoxRange range = voxel::boxes_over(m_info.bounds, 0);
        const std::int64_t lo = std::int64_t{chunk.first_y} * 16;
        const std::int64_t hi = lo + static_cast<std::int64_t>(chunk.sections.size()) * 16;
        const std::int64_t lift = m_car.offset[1];
        const std::int64_t low = std::int64_t{range.min.by} * voxel::kBoxSizeY;
        const std::int64_t high = std::int64_t{range.max.by} * voxel::kBoxSizeY;
        if (lo + lift < low || hi + lift > high)
            m_damage.add(m_store.to_name(ref) + ": blocks at y = " + std::to_string(lo) + " to " +
                         std::to_string(hi) + " reach outside the world's heights, " +
                         std::to_string(low - lift) + " to " + std::to_string(high - lift));
    }

    WorldFolder m_folder;
    voxel::SideCar m_car;
    ChunkStore m_store;
    BlockAppearanceCache m_block_appearances;
    worlds::DamageLog m_damage;
    voxel::WorldInfo m_info;
    std::vector<Columns> m_columns;  ///< by level: those that may hold anything
    util::Cache<ChunkPlace, VoxelChunk, ChunkPlaceHash> m_chunks;
    util::HandlePool<std::unique_ptr<ChunkTools>> m_tools;
};

}  // namespace

std::unique_ptr<voxel::World> open_minecraft_world(const MinecraftWorldOptions& options,
                                                   const BlockTable& blocks) {
    if (options.memory_bytes < kMinMemoryBytes)
        throw util::UsageError("{}{} MiB of memory; allowed: 16 at least", opening(options),
                               options.memory_bytes >> 20);
    if (options.max_surveyed == 0)
        throw util::UsageError(opening(options) + "looks through 0 chunks; allowed: 1 at least");
    return std::make_unique<MinecraftWorld>(options, blocks);
}

}  // namespace terravox::minecraft
