#include "voxelserver/make/worlds/minecraft/column_boxes.hpp"

#include <algorithm>
#include <bit>

#include "common/voxel/box_builder.hpp"

namespace terravox::minecraft {
namespace {

using voxel::BoxBuilder;
using voxel::kBoxSizeY;

constexpr int kSections = kBoxSizeY / 16;

// The sections of one chunk in a box, with the one below and the one above. nullptr: air.
using Stack = std::array<const VoxelSection*, kSections + 2>;

Stack stack_of(const VoxelChunk* chunk, std::int32_t first_section) noexcept {
    Stack out{};
    if (chunk == nullptr)
        return out;
    for (int i = 0; i < kSections + 2; ++i) {
        const VoxelSection* section = chunk->section(first_section - 1 + i);
        if (section != nullptr && !section->air())
            out[static_cast<std::size_t>(i)] = section;
    }
    return out;
}

bool bare(const Stack& stack) noexcept {
    return std::all_of(stack.begin(), stack.end(),
                       [](const VoxelSection* s) { return s == nullptr; });
}

/// Passes the bits of a column of voxels of one kind to the builder as runs.
class Runs {
public:
    Runs(BoxBuilder& builder, int x, int z, bool opaque) noexcept
        : m_builder(builder), m_x(x), m_z(z), m_opaque(opaque) {}
    /// The 16 voxels from y on; calls come in rising order without gaps.
    void add(int y, unsigned bits) noexcept {
        if (bits == (m_open ? 0xFFFFu : 0u))
            return;
        for (int at = 0; at < 16;) {
            // The next voxel that differs from those before it.
            const int change = std::countr_zero((m_open ? ~bits : bits) >> at);
            if (change >= 16 - at)
                return;
            at += change;
            if (m_open)
                m_builder.add(m_x, m_z, m_begin, y + at, m_opaque);
            else
                m_begin = y + at;
            m_open = !m_open;
        }
    }
    void end(int y) noexcept {
        if (m_open)
            m_builder.add(m_x, m_z, m_begin, y, m_opaque);
    }

private:
    BoxBuilder& m_builder;
    int m_x;
    int m_z;
    int m_begin = 0;
    bool m_opaque;
    bool m_open = false;
};

// For uniform sections: all bits or none.
bool uniform_opaque(const VoxelSection& section) noexcept {
    return !voxel::see_through(section.appearances.front().material);
}

void add_column(BoxBuilder& builder, const Stack& stack, int x, int z, std::size_t column,
                bool with_clear) {
    Runs opaque(builder, x, z, true), clear(builder, x, z, false);
    int y = -16;
    for (const VoxelSection* section : stack) {
        unsigned solid = 0;
        unsigned seen_through = 0;
        if (section != nullptr && section->bits) {
            solid = section->bits->opaque[column];
            seen_through = section->bits->clear[column];
        } else if (section != nullptr)
            (uniform_opaque(*section) ? solid : seen_through) = 0xFFFF;
        opaque.add(y, solid);
        if (with_clear)
            clear.add(y, seen_through);
        y += 16;
    }
    opaque.end(y);
    clear.end(y);
}

}  // namespace

std::shared_ptr<const voxel::Box> box_of(const ChunkPatch& patch, const voxel::BoxKey& key,
                                         std::int32_t lift) {
    const std::int32_t first_section = key.by * kSections - lift / 16;
    std::array<Stack, 36> stacks;
    bool any = false;
    for (std::size_t i = 0; i < patch.size(); ++i) {
        stacks[i] = stack_of(patch[i].get(), first_section);
        const std::size_t x = i % 6;
        const std::size_t z = i / 6;
        if (x > 0 && x < 5 && z > 0 && z < 5)
            any = any || std::any_of(stacks[i].begin() + 1, stacks[i].end() - 1,
                                     [](const auto* s) { return s != nullptr; });
    }
    if (!any)
        return nullptr;
    BoxBuilder builder;
    for (int cz = -1; cz < 5; ++cz)
        for (int cx = -1; cx < 5; ++cx) {
            const Stack& stack = stacks[static_cast<std::size_t>((cz + 1) * 6 + cx + 1)];
            if (bare(stack))
                continue;
            const bool inside = cx >= 0 && cx < 4 && cz >= 0 && cz < 4;
            // Of the chunks around, the row that touches the box; only opaque voxels can hide what
            // is inside.
            const int x0 = cx == -1 ? 15 : 0;
            const int x1 = cx == 4 ? 1 : 16;
            const int z0 = cz == -1 ? 15 : 0;
            const int z1 = cz == 4 ? 1 : 16;
            for (int z = z0; z < z1; ++z)
                for (int x = x0; x < x1; ++x)
                    add_column(builder, stack, cx * 16 + x, cz * 16 + z,
                               static_cast<std::size_t>(x + 16 * z), inside);
        }
    return builder.build(key, [&](int x, int y, int z) {
        const Stack& stack = stacks[static_cast<std::size_t>(((z >> 4) + 1) * 6 + (x >> 4) + 1)];
        return stack[static_cast<std::size_t>((y >> 4) + 1)]->at(
            static_cast<std::size_t>((x & 15) + 16 * (z & 15) + 256 * (y & 15)));
    });
}

}  // namespace terravox::minecraft
