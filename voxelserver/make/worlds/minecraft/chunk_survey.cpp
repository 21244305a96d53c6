#include "voxelserver/make/worlds/minecraft/chunk_survey.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <map>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/handle_pool.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"

namespace terravox::minecraft {
namespace {

constexpr std::int32_t kCell = 8;  // chunks across: parts are connected when their cells touch

struct Cell {
    std::size_t chunks = 0;
    ChunkArea area;
    bool taken = false;
};
using Cells =
    std::map<ChunkPlace, Cell>;  // ordered, so that the first one does not depend on hashes

void add(Cell& to, std::size_t chunks, const ChunkArea& area) {
    to.area =
        to.chunks == 0
            ? area
            : ChunkArea{{std::min(to.area.min.x, area.min.x), std::min(to.area.min.z, area.min.z)},
                        {std::max(to.area.max.x, area.max.x), std::max(to.area.max.z, area.max.z)}};
    to.chunks += chunks;
}

// All cells connected with a cell.
Cell part_from(Cells& cells, Cells::iterator first) {
    Cell out;
    std::vector<Cells::iterator> open{first};
    first->second.taken = true;
    while (!open.empty()) {
        const auto at = open.back();
        open.pop_back();
        add(out, at->second.chunks, at->second.area);
        for (std::int32_t i = 0; i < 9; ++i) {
            const auto next = cells.find({at->first.x + i % 3 - 1, at->first.z + i / 3 - 1});
            if (next == cells.end() || next->second.taken)
                continue;
            next->second.taken = true;
            open.push_back(next);
        }
    }
    return out;
}

}  // namespace

std::optional<ChunkArea> main_part(std::span<const ChunkPlace> places) {
    Cells cells;
    for (const ChunkPlace& p : places)
        add(cells[{voxel::floor_div(p.x, kCell), voxel::floor_div(p.z, kCell)}], 1,
            {p, {p.x + 1, p.z + 1}});
    Cell largest;
    for (auto cell = cells.begin(); cell != cells.end(); ++cell) {
        if (cell->second.taken)
            continue;
        const Cell part = part_from(cells, cell);
        if (part.chunks > largest.chunks)
            largest = part;
    }
    if (largest.chunks == places.size())
        return std::nullopt;
    return largest.area;
}

namespace {

// Chunks that one thread reads in succession: they lie together.
constexpr std::size_t kBatch = 32;

// Heights so far. Widened by all threads; the result does not depend on their order.
class Heights {
public:
    void widen(std::int32_t lo, std::int32_t hi) noexcept {
        for (std::int32_t old = m_lo.load(); lo < old && !m_lo.compare_exchange_weak(old, lo);) {
        }
        for (std::int32_t old = m_hi.load(); hi > old && !m_hi.compare_exchange_weak(old, hi);) {
        }
    }
    [[nodiscard]] std::int32_t lo() const noexcept { return m_lo.load(); }
    [[nodiscard]] std::int32_t hi() const noexcept { return m_hi.load(); }

private:
    std::atomic<std::int32_t> m_lo{INT32_MAX};
    std::atomic<std::int32_t> m_hi{INT32_MIN};
};

// Whether a section may hold anything, without a test of each of its voxels.
bool may_hold(ChunkTools& tools, BlockAppearanceCache& block_appearances, const ChunkBlocks& blocks,
              const ChunkSection& section) {
    if (section.numeric)
        return !tools.maker.make(blocks, section).air();
    tools.appearances.resize(section.palette_size);
    block_appearances.of(
        std::span(blocks.palette).subspan(section.palette_begin, section.palette_size),
        tools.appearances);
    return std::any_of(tools.appearances.begin(), tools.appearances.end(),
                       [](const voxel::VoxelAttr& appearance) {
                           return appearance.material != voxel::Material::kAir;
                       });
}

// The layers of a section that hold anything.
struct Layers {
    int lowest = 16;
    int highest = -1;
};

Layers find_layers(const VoxelSection& section) noexcept {
    if (section.air())
        return {};
    if (!section.bits)
        return {0, 15};
    unsigned any = 0;
    for (std::size_t i = 0; i < 256; ++i)
        any |= unsigned{section.bits->opaque[i]} | section.bits->clear[i];
    if (any == 0)
        return {};
    return {std::countr_zero(any), 31 - std::countl_zero(any)};
}

// Widens the heights by the layers of a section.
// @return whether there are any
bool widen_by(ChunkTools& tools, const ChunkBlocks& blocks, const ChunkSection& section,
              Heights& heights) {
    const Layers layers = find_layers(tools.maker.make(blocks, section));
    if (layers.highest < 0)
        return false;
    heights.widen(section.y * 16 + layers.lowest, section.y * 16 + layers.highest + 1);
    return true;
}

// Only sections that may widen the heights are examined voxel by voxel. The return value does not
// depend on what other threads have found.
bool survey_chunk(ChunkTools& tools, BlockAppearanceCache& block_appearances,
                  const ChunkBlocks& blocks, Heights& heights) {
    const auto sections = blocks.sections();
    if (std::none_of(sections.rbegin(), sections.rend(), [&](const ChunkSection& s) {
            return may_hold(tools, block_appearances, blocks, s);
        }))
        return false;
    for (auto s = sections.rbegin(); s != sections.rend() && s->y * 16 + 16 > heights.hi(); ++s)
        if (widen_by(tools, blocks, *s, heights))
            break;
    for (auto s = sections.begin(); s != sections.end() && s->y * 16 < heights.lo(); ++s)
        if (widen_by(tools, blocks, *s, heights))
            break;
    return true;
}

// For a world that is not scanned completely: the heights of the sections that a chunk has, air or
// not.
void widen_by_sections(const ChunkBlocks& blocks, Heights& heights) noexcept {
    if (blocks.sections().empty())
        return;
    heights.widen(blocks.sections().front().y * 16, blocks.sections().back().y * 16 + 16);
}

}  // namespace

ChunkSurvey survey_chunks(const ChunkStore& store, BlockAppearanceCache& block_appearances,
                          worlds::DamageLog& damage, int threads, std::size_t most) {
    const auto chunks = store.chunks();
    const std::size_t count = std::min(chunks.size(), most);
    ChunkSurvey out;
    out.complete = count == chunks.size();
    std::vector<std::uint8_t> holds(count, 0);
    Heights heights;
    std::atomic<std::size_t> readable{0};
    util::HandlePool<std::unique_ptr<ChunkTools>> toolbox;
    thread::parallel_for((count + kBatch - 1) / kBatch, threads, [&](std::size_t batch) {
        const auto lease =
            toolbox.borrow([&] { return std::make_unique<ChunkTools>(store, block_appearances); });
        for (std::size_t i = batch * kBatch; i < std::min(count, (batch + 1) * kBatch); ++i) {
            // Evenly spread; all of them when the scan is complete.
            const ChunkRef& chunk = chunks[i * chunks.size() / count];
            try {
                const ChunkBlocks& blocks = lease->reader.read(chunk, damage);
                holds[i] = survey_chunk(*lease, block_appearances, blocks, heights);
                if (!out.complete)
                    widen_by_sections(blocks, heights);
                ++readable;
            } catch (const util::Error& e) {
                damage.add(store.to_name(chunk) + ": " + e.what());
            }
        }
    });
    out.readable = readable;
    for (std::size_t i = 0; i < chunks.size(); ++i)
        if (!out.complete || holds[i] != 0)
            out.places.push_back(chunks[i].place);
    if (!out.complete)
        heights.widen(-64, 320);
    if (heights.lo() < heights.hi()) {
        out.min_y = heights.lo();
        out.max_y = heights.hi();
    }
    return out;
}

}  // namespace terravox::minecraft
