#include "voxelserver/serve/gkot/gkot_reply.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace terravox::gkot {

std::uint32_t block_word(voxel::Material material) noexcept {
    const voxel::OldBlock block = voxel::find_traits(material).old_block;
    return std::uint32_t{block.data} << 8 | block.id;
}

namespace {

/// Lowest and highest top of a box column, in voxels.
struct Tops {
    std::int32_t low = 0;
    std::int32_t high = 0;
};

// As a reply would contain them, so that "the top" means the same in both.
std::optional<Tops> tops_around(const voxel::VoxelBounds& bounds, std::int64_t x, std::int64_t z,
                                const FetchBox& fetch) {
    std::optional<Tops> out;
    for (const std::int64_t top : column_tops(bounds, x, z, fetch)) {
        if (top == kNoTop)
            continue;
        const auto y = static_cast<std::int32_t>(top);
        if (!out)
            out = {y, y};
        out->low = std::min(out->low, y);
        out->high = std::max(out->high, y);
    }
    return out;
}

void append_number(std::string& out, const char* name, double value) {
    // The longest number has 309 digits before the decimal point; the shortest round-trip form has
    // few after it.
    char text[512];
    const auto end = std::to_chars(text, text + sizeof text, value + 0.0, std::chars_format::fixed)
                         .ptr;  // + 0.0: avoids "-0"
    out += (out.size() > 1 ? ",\"" : "\"") + std::string(name) + "\":" + std::string(text, end);
}

}  // namespace

std::int64_t find_voxel(double value, double unit) noexcept {
    // 2^53: beyond any world, and integers are still exact.
    constexpr double kMax = 9007199254740992.0;
    return static_cast<std::int64_t>(std::clamp(std::floor(value / unit), -kMax, kMax));
}

double find_height(std::int64_t y, double voxel_m) noexcept {
    double height = static_cast<double>(y) * voxel_m;
    while (find_voxel(height, voxel_m) < y)
        height = std::nextafter(height, std::numeric_limits<double>::infinity());
    return height;
}

Origin find_origin(const voxel::WorldInfo& info, const OriginRequest& request,
                   const FetchBox& fetch) {
    Origin out;
    out.tmx = request.tmx;
    out.tmy = request.tmy;
    if (info.bounds.empty())
        return out;
    const double unit = info.crs_units_per_voxel;
    const auto tops = tops_around(info.bounds, find_voxel(request.tmx, unit),
                                  find_voxel(-request.tmy, unit), fetch);
    out.tmz = out.zmin = find_height(tops ? tops->low : info.bounds.min[1], info.voxel_m);
    out.zmax = find_height(tops ? tops->high : info.bounds.max[1] - 1, info.voxel_m);
    out.zrange = out.zmax - out.zmin;
    return out;
}

std::string to_json(const Origin& origin) {
    std::string out = "{";
    append_number(out, "tmx", origin.tmx);
    append_number(out, "tmy", origin.tmy);
    append_number(out, "tmz", origin.tmz);
    append_number(out, "zmin", origin.zmin);
    append_number(out, "zmax", origin.zmax);
    append_number(out, "zrange", origin.zrange);
    return out + "}";
}

namespace {

using voxel::Box;
using voxel::TreeCell;

/// Boxes along one axis, half-open.
struct Span {
    std::int32_t begin = 0;
    std::int32_t end = 0;
};

// The boxes of `size` voxels, among those from `begin` to `end`, that intersect [from, from +
// length). Compares before adding anything, since `from` may be any number.
Span boxes_met(std::int64_t from, std::int32_t length, std::int64_t size, std::int32_t begin,
               std::int32_t end) {
    if (from >= end * size || from <= begin * size - length)
        return {};
    const std::int64_t first = std::max(from, begin * size);
    const std::int64_t last = std::min(from + length, end * size) - 1;
    static_assert((-1 >> 1) == -1);  // so that shifts and floor agree
    const int shift = std::countr_zero(static_cast<std::uint64_t>(size));
    return {static_cast<std::int32_t>(first >> shift),
            static_cast<std::int32_t>((last >> shift) + 1)};
}

/// Writes the voxels of boxes into the words of a region.
class Filler {
public:
    Filler(const Region& region, std::vector<std::uint32_t>& out) : m_region(region), m_out(out) {}

    void fill(const Box& box) {
        const std::int64_t x = std::int64_t{box.key().bx} * voxel::kBoxSizeX;
        const std::int64_t z = std::int64_t{box.key().bz} * voxel::kBoxSizeZ;
        const std::int64_t y = std::int64_t{box.key().by} * voxel::kBoxSizeY;
        for (int root = 0; root < Box::kRootCount; ++root)
            children(box, box.cells()[static_cast<std::size_t>(root)],
                     {x - m_region.x, y + 64 * root - m_region.y, z - m_region.z}, 16);
    }

private:
    using Corner = std::array<std::int64_t, 3>;  ///< x, y, z relative to the region's corner

    [[nodiscard]] bool outside(const Corner& c, int side) const {
        return c[0] >= m_region.sx || c[1] >= m_region.sy || c[2] >= m_region.sz ||
               c[0] + side <= 0 || c[1] + side <= 0 || c[2] + side <= 0;
    }
    // Recurses three levels: children of 16, of 4, and voxels.
    void children(const Box& box, const TreeCell& cell, const Corner& corner, int side) {
        if (outside(corner, side * 4))
            return;
        for (std::uint64_t left = cell.mask; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const Corner child{corner[0] + (bit & 3) * side, corner[1] + (bit >> 4) * side,
                               corner[2] + (bit >> 2 & 3) * side};
            if (outside(child, side))
                continue;
            if ((cell.detail >> bit & 1) == 0)
                fill_hidden(child, side);
            else if (side > 1)
                children(box, box.cells()[cell.compute_index(bit)], child, side / 4);
            else
                word_at(child[0], child[1], child[2]) =
                    solid_word(box.attrs()[cell.compute_index(bit)].material);
        }
    }
    void fill_hidden(const Corner& c, int side) {
        const auto begin = [&](std::size_t axis) { return std::max<std::int64_t>(c[axis], 0); };
        const auto end = [&](std::size_t axis, std::int32_t size) {
            return std::min<std::int64_t>(c[axis] + side, size);
        };
        const std::uint32_t word = block_word(voxel::Material::kRock);
        for (std::int64_t y = begin(1); y < end(1, m_region.sy); ++y)
            for (std::int64_t z = begin(2); z < end(2, m_region.sz); ++z)
                std::fill_n(&word_at(begin(0), y, z), end(0, m_region.sx) - begin(0), word);
    }
    /// A solid voxel whose material is air stays solid.
    static std::uint32_t solid_word(voxel::Material material) {
        return block_word(material == voxel::Material::kAir ? voxel::Material::kUnknown : material);
    }
    std::uint32_t& word_at(std::int64_t x, std::int64_t y, std::int64_t z) {
        return m_out[static_cast<std::size_t>(x + z * m_region.sx + y * m_region.sx * m_region.sz)];
    }

    const Region& m_region;
    std::vector<std::uint32_t>& m_out;
};

/// Most significant byte first, whatever the machine's byte order.
std::uint32_t big_endian(std::uint32_t word) {
    if constexpr (std::endian::native == std::endian::big)
        return word;
    return word << 24 | (word & 0xff00) << 8 | (word >> 8 & 0xff00) | word >> 24;
}

/// Writes big-endian words sequentially.
class Words {
public:
    explicit Words(std::size_t count) : m_bytes(count * 4, '\0') {}
    void put(std::uint32_t word) { put_all(std::span<const std::uint32_t>(&word, 1)); }
    void put_all(std::span<const std::uint32_t> words) {
        // A local pointer: char may alias anything, so members would be reloaded for each word.
        char* at = m_bytes.data() + m_at;
        for (const std::uint32_t word : words) {
            const std::uint32_t bytes = big_endian(word);
            std::memcpy(at, &bytes, 4);
            at += 4;
        }
        m_at += words.size_bytes();
    }
    [[nodiscard]] std::string take() { return std::move(m_bytes); }

private:
    std::string m_bytes;
    std::size_t m_at = 0;
};

/// Local y of the topmost block of each column, -1 where there is none.
std::vector<std::int32_t> find_tops(const BoxRequest& request,
                                    const std::vector<std::uint32_t>& blocks) {
    const auto layer = static_cast<std::size_t>(request.sx) * static_cast<std::size_t>(request.sz);
    std::vector<std::int32_t> tops(layer, -1);
    for (std::int32_t y = 0; y < request.sy; ++y)
        for (std::size_t i = 0; i < layer; ++i)
            if (blocks[static_cast<std::size_t>(y) * layer + i] != 0)
                tops[i] = y;
    return tops;
}

}  // namespace

Region find_region(const voxel::WorldInfo& info, const BoxRequest& request, const FetchBox& fetch) {
    const double unit = info.crs_units_per_voxel;
    const double tmz = request.tmz ? *request.tmz : find_origin(info, request.origin, fetch).tmz;
    Region out;
    out.sx = request.sx;
    out.sy = request.sy;
    out.sz = request.sz;
    // At most 2^53 + 2^31 * 2^9: far from overflow.
    out.x = find_voxel(request.origin.tmx, unit) + std::int64_t{request.x} * request.sx;
    out.y = find_voxel(tmz, info.voxel_m) + std::int64_t{request.y} * request.sy;
    out.z = find_voxel(-request.origin.tmy, unit) + std::int64_t{request.z} * request.sz;
    return out;
}

std::vector<std::uint32_t> read_blocks(const voxel::VoxelBounds& bounds, const Region& region,
                                       const FetchBox& fetch) {
    std::vector<std::uint32_t> out(static_cast<std::size_t>(region.sx) *
                                   static_cast<std::size_t>(region.sy) *
                                   static_cast<std::size_t>(region.sz));
    if (bounds.empty())
        return out;
    const auto range = voxel::boxes_over(bounds, 0);
    const Span x = boxes_met(region.x, region.sx, voxel::kBoxSizeX, range.min.bx, range.max.bx);
    const Span y = boxes_met(region.y, region.sy, voxel::kBoxSizeY, range.min.by, range.max.by);
    const Span z = boxes_met(region.z, region.sz, voxel::kBoxSizeZ, range.min.bz, range.max.bz);
    Filler filler(region, out);
    for (std::int32_t bz = z.begin; bz < z.end; ++bz)
        for (std::int32_t bx = x.begin; bx < x.end; ++bx)
            for (std::int32_t by = y.begin; by < y.end; ++by)
                if (const auto box = fetch({0, bx, by, bz}))
                    filler.fill(*box);
    return out;
}

std::string encode_reply(const BoxRequest& request, const std::vector<std::uint32_t>& blocks) {
    const std::vector<std::int32_t> tops = find_tops(request, blocks);
    const std::int32_t highest = *std::ranges::max_element(tops);
    const auto to_unsigned = [](std::int32_t number) { return static_cast<std::uint32_t>(number); };
    Words out(6 + blocks.size() + tops.size());
    for (const std::int32_t number : {request.x, request.y, request.z, highest < 0 ? -2 : highest})
        out.put(to_unsigned(number));
    out.put(static_cast<std::uint32_t>(blocks.size()));
    out.put_all(blocks);
    out.put(static_cast<std::uint32_t>(tops.size()));
    for (const std::int32_t top : tops)
        out.put(to_unsigned(top));
    return out.take();
}

std::string box_reply(const voxel::WorldInfo& info, const BoxRequest& request,
                      const FetchBox& fetch) {
    return encode_reply(request,
                        read_blocks(info.bounds, find_region(info, request, fetch), fetch));
}

std::vector<std::int64_t> column_tops(const voxel::VoxelBounds& bounds, std::int64_t x,
                                      std::int64_t z, const FetchBox& fetch) {
    std::vector<std::int64_t> out(std::size_t{64} * 64, kNoTop);
    if (bounds.empty())
        return out;
    const auto range = voxel::boxes_over(bounds, 0);
    const std::int64_t column_x = x >> 6;
    const std::int64_t column_z = z >> 6;
    if (column_x < range.min.bx || column_x >= range.max.bx || column_z < range.min.bz ||
        column_z >= range.max.bz)
        return out;
    const auto bx = static_cast<std::int32_t>(column_x);
    const auto bz = static_cast<std::int32_t>(column_z);
    for (std::int32_t by = range.max.by - 1; by >= range.min.by; --by) {
        const auto box = fetch({0, bx, by, bz});
        if (!box)
            continue;
        bool all = true;
        const int highest = box->top() - 1;
        for (int i = 0; i < 64 * 64; ++i) {
            std::int64_t& top = out[static_cast<std::size_t>(i)];
            for (int y = highest; y >= 0 && top == kNoTop; --y)
                if (box->solid(i % 64, y, i / 64))
                    top = std::int64_t{by} * voxel::kBoxSizeY + y;
            all = all && top != kNoTop;
        }
        if (all)
            break;
    }
    return out;
}

}  // namespace terravox::gkot
