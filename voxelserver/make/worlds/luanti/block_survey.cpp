#include "voxelserver/make/worlds/luanti/block_survey.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "voxelserver/make/worlds/luanti/node_block.hpp"

namespace terravox::luanti {
namespace {

constexpr std::int32_t kBlocksAcross = voxel::kBoxSizeX / kBlockVoxels;

}  // namespace

BlockIndex::BlockIndex()
    : m_heights(std::size_t{4} * kFarthestColumn * kFarthestColumn),
      m_min{kFarthestBlock, kFarthestBlock, kFarthestBlock},
      m_max{-kFarthestBlock, -kFarthestBlock, -kFarthestBlock} {
    for (std::size_t level = 0; level < m_holds.size(); ++level)
        m_holds[level].resize(m_heights.size() >> (2 * level));
}

std::size_t BlockIndex::compute_index(int level, std::int32_t bx, std::int32_t bz) noexcept {
    const std::int32_t half = kFarthestColumn >> level;
    return static_cast<std::size_t>((bz + half) * 2 * half + bx + half);
}

void BlockIndex::add(const BlockPlace& place) noexcept {
    std::int32_t bx = voxel::floor_div(place.x, kBlocksAcross);
    std::int32_t bz = voxel::floor_div(place.z, kBlocksAcross);
    Heights& heights = m_heights[compute_index(0, bx, bz)];
    const bool is_first = heights.begin == heights.end;
    heights.begin = static_cast<std::int16_t>(
        is_first ? place.y : std::min<std::int32_t>(heights.begin, place.y));
    heights.end = static_cast<std::int16_t>(
        is_first ? place.y + 1 : std::max<std::int32_t>(heights.end, place.y + 1));
    for (int level = 0; level <= kTopLevel; ++level) {
        m_holds[static_cast<std::size_t>(level)][compute_index(level, bx, bz)] = true;
        bx = voxel::floor_div(bx, 2);
        bz = voxel::floor_div(bz, 2);
    }
    m_min = {std::min(m_min.x, place.x), std::min(m_min.y, place.y), std::min(m_min.z, place.z)};
    m_max = {std::max(m_max.x, place.x), std::max(m_max.y, place.y), std::max(m_max.z, place.z)};
}

voxel::VoxelBounds BlockIndex::bounds() const noexcept {
    if (m_min.x > m_max.x)
        return {};
    const auto begin = [](std::int32_t block) { return block * kBlockVoxels; };
    const auto end = [](std::int32_t block) { return (block + 1) * kBlockVoxels; };
    return {{begin(m_min.x), begin(m_min.y), begin(m_min.z)},
            {end(m_max.x), end(m_max.y), end(m_max.z)}};
}

BlockIndex::Heights BlockIndex::heights(std::int32_t bx, std::int32_t bz) const noexcept {
    const auto fits = [](std::int32_t b) { return b >= -kFarthestColumn && b < kFarthestColumn; };
    return fits(bx) && fits(bz) ? m_heights[compute_index(0, bx, bz)] : Heights{};
}

bool BlockIndex::holds(int level, std::int32_t bx, std::int32_t bz) const noexcept {
    const int stored = std::min(level, kTopLevel);
    const std::int32_t half = kFarthestColumn >> stored;
    const auto fits = [&](std::int32_t b) { return b >= -half && b < half; };
    return fits(bx) && fits(bz) &&
           m_holds[static_cast<std::size_t>(stored)][compute_index(stored, bx, bz)];
}

namespace {

constexpr std::size_t kBatch = 64;  // blocks that one thread reads in succession

/// Places spread evenly over all that are added: every place, then every second, fourth and so on.
class Sample {
public:
    explicit Sample(std::size_t most) : m_max(most) {}

    void add(const BlockPlace& place) {
        if (m_added++ % m_stride != 0)
            return;
        m_places.push_back(place);
        if (m_places.size() <= m_max)
            return;
        m_stride *= 2;
        for (std::size_t i = 0; 2 * i < m_places.size(); ++i)
            m_places[i] = m_places[2 * i];
        m_places.resize((m_places.size() + 1) / 2);
    }
    [[nodiscard]] std::uint64_t added() const noexcept { return m_added; }
    [[nodiscard]] const std::vector<BlockPlace>& places() const noexcept { return m_places; }

private:
    std::size_t m_max;
    std::uint64_t m_added = 0;
    std::uint64_t m_stride = 1;
    std::vector<BlockPlace> m_places;
};

/// The contents of one block.
struct Facts {
    std::uint8_t version = 0;  ///< 0: damaged
    std::int8_t begin = 0;     ///< layers of the block, half-open
    std::int8_t end = 0;       ///< equal to begin: air
};

bool layer_holds(const NodeBlock& block, int y) noexcept {
    for (int z = 0; z < kBlockVoxels; ++z) {
        for (int x = 0; x < kBlockVoxels; ++x) {
            if (block.at(x, y, z).material != voxel::Material::kAir)
                return true;
        }
    }
    return false;
}

Facts collect_facts(MapDatabase& database, NodeAppearances& appearances, MapBlockReader& reader,
                    const BlockPlace& place) {
    Facts out;
    const std::vector<std::uint8_t> blob = database.read(place);
    const MapBlock& stored = reader.read(blob);
    const auto block = make_node_block(stored, appearances);
    out.version = static_cast<std::uint8_t>(stored.version);
    if (block == nullptr)
        return out;
    int begin = 0;
    while (!layer_holds(*block, begin))
        ++begin;
    int end = kBlockVoxels;
    while (!layer_holds(*block, end - 1))
        --end;
    out.begin = static_cast<std::int8_t>(begin);
    out.end = static_cast<std::int8_t>(end);
    return out;
}

std::vector<Facts> survey_blocks(MapDatabase& database, NodeAppearances& appearances,
                                 worlds::DamageLog& damage, const std::vector<BlockPlace>& places,
                                 int threads) {
    std::vector<Facts> out(places.size());
    const std::size_t batches = (places.size() + kBatch - 1) / kBatch;
    thread::parallel_for(batches, threads, [&](std::size_t batch) {
        MapBlockReader reader;
        const std::size_t end = std::min(places.size(), (batch + 1) * kBatch);
        for (std::size_t i = batch * kBatch; i < end; ++i) {
            try {
                out[i] = collect_facts(database, appearances, reader, places[i]);
            } catch (const util::Error& e) {
                damage.add(to_name(places[i]) + ": " + e.what());
            }
        }
    });
    return out;
}

/// Adds the blocks that hold anything to the index.
/// @return their bounds: x and z to whole blocks, y to the voxel
voxel::VoxelBounds add_holding(const std::vector<BlockPlace>& places,
                               const std::vector<Facts>& facts, BlockIndex& holding) {
    std::int32_t min_y = INT32_MAX;
    std::int32_t max_y = INT32_MIN;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (facts[i].begin == facts[i].end)
            continue;
        holding.add(places[i]);
        min_y = std::min(min_y, places[i].y * kBlockVoxels + facts[i].begin);
        max_y = std::max(max_y, places[i].y * kBlockVoxels + facts[i].end);
    }
    voxel::VoxelBounds out = holding.bounds();
    if (!out.empty()) {
        out.min[1] = min_y;
        out.max[1] = max_y;
    }
    return out;
}

}  // namespace

BlockSurvey survey_blocks(MapDatabase& database, NodeAppearances& appearances,
                          worlds::DamageLog& damage, int threads, std::size_t most) {
    BlockSurvey out;
    Sample sample(most);
    const std::uint64_t misplaced = database.for_each_place([&](const BlockPlace& place) {
        out.index.add(place);
        sample.add(place);
    });
    if (misplaced > 0)
        damage.add(std::to_string(misplaced) +
                   (misplaced == 1 ? " block has a key that stands for no place"
                                   : " blocks have keys that stand for no place") +
                   "; allowed: -2048 to 2047 blocks on each axis");
    const std::vector<BlockPlace>& places = sample.places();
    const std::vector<Facts> facts = survey_blocks(database, appearances, damage, places, threads);
    out.blocks = sample.added();
    out.looked_at = places.size();
    for (const Facts& block : facts) {
        if (block.version == 0) {
            ++out.damaged;
            continue;
        }
        ++out.versions[block.version];
        if (block.begin == block.end)
            ++out.empty;
    }
    BlockIndex holding;
    out.bounds = add_holding(places, facts, holding);
    if (out.complete()) {
        out.index = std::move(holding);
    } else {
        out.framed = out.bounds;
        out.bounds = out.index.bounds();
    }
    return out;
}

}  // namespace terravox::luanti
