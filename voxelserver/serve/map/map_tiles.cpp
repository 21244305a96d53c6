#include "voxelserver/serve/map/map_tiles.hpp"

#include <algorithm>
#include <array>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/linear_light.hpp"
#include "common/voxel/box.hpp"
#include "voxelserver/serve/map/pixels.hpp"

namespace terravox::map {
namespace {

constexpr int kSide = kTileBoxes * voxel::kBoxSizeX;  ///< pixels
constexpr int kRingSide = kTileBoxes + 2;
const ColumnTop kNothing;

/// The tile's box columns and the ring around them; indices from -1 to kTileBoxes.
class Patchwork {
public:
    Patchwork(TopSource& source, const voxel::InputExtent& world, std::int32_t x, std::int32_t z,
              bool make, FinestTile& out)
        : m_source(source),
          m_world(world),
          m_bx(std::int64_t{x} * kTileBoxes),
          m_bz(std::int64_t{z} * kTileBoxes),
          m_make(make),
          m_out(out) {}

    void fetch(int dx, int dz) {
        const std::int64_t bx = m_bx + dx;
        const std::int64_t bz = m_bz + dz;
        if (bx < m_world.min_bx || bx >= m_world.max_bx || bz < m_world.min_bz ||
            bz >= m_world.max_bz)
            return;
        const Top top =
            m_source.top(static_cast<std::int32_t>(bx), static_cast<std::int32_t>(bz), m_make);
        m_out.complete = m_out.complete && top.known;
        if (!top.known)
            return;
        const auto x = static_cast<std::int32_t>(bx);
        const auto z = static_cast<std::int32_t>(bz);
        m_out.reach.add({x, z, x + 1, z + 1});
        m_out.reach.add(top.reach);
        m_tops[index(dx, dz)] = top.top;
    }
    [[nodiscard]] const BoxTop* top(int dx, int dz) const { return m_tops[index(dx, dz)].get(); }
    /// Column of the tile, x and z in [-1, kSide].
    [[nodiscard]] const ColumnTop& at(int x, int z) const {
        const BoxTop* box = top((x + 64) / 64 - 1, (z + 64) / 64 - 1);
        return box ? box->at(x & 63, z & 63) : kNothing;
    }

private:
    static std::size_t index(int dx, int dz) {
        return static_cast<std::size_t>((dz + 1) * kRingSide + dx + 1);
    }
    TopSource& m_source;
    const voxel::InputExtent& m_world;
    const std::int64_t m_bx;
    const std::int64_t m_bz;
    const bool m_make;
    FinestTile& m_out;
    std::array<std::shared_ptr<const BoxTop>, kRingSide * kRingSide> m_tops;
};

bool has_neighbour_inside(const Patchwork& tops, int dx, int dz) {
    for (int z = std::max(dz - 1, 0); z <= std::min(dz + 1, kTileBoxes - 1); ++z)
        for (int x = std::max(dx - 1, 0); x <= std::min(dx + 1, kTileBoxes - 1); ++x)
            if (tops.top(x, z))
                return true;
    return false;
}

void fetch_all(Patchwork& tops) {
    for (int dz = 0; dz < kTileBoxes; ++dz)
        for (int dx = 0; dx < kTileBoxes; ++dx)
            tops.fetch(dx, dz);
    for (int dz = -1; dz <= kTileBoxes; ++dz)
        for (int dx = -1; dx <= kTileBoxes; ++dx) {
            const bool inside = dx >= 0 && dx < kTileBoxes && dz >= 0 && dz < kTileBoxes;
            if (!inside && has_neighbour_inside(tops, dx, dz))
                tops.fetch(dx, dz);
        }
}

void shade_box(const Patchwork& tops, int box_x, int box_z, std::vector<Rgba8>& pixels) {
    for (int z = box_z * 64; z < box_z * 64 + 64; ++z)
        for (int x = box_x * 64; x < box_x * 64 + 64; ++x) {
            TopWindow window{};
            for (int i = 0; i < 9; ++i)
                window[static_cast<std::size_t>(i)] = &tops.at(x + i % 3 - 1, z + i / 3 - 1);
            pixels[static_cast<std::size_t>(z * kSide + x)] = shaded_pixel(window);
        }
}

}  // namespace

FinestTile make_finest_tile(TopSource& source, const voxel::InputExtent& world, std::int32_t x,
                            std::int32_t z, bool make) {
    FinestTile out;
    Patchwork tops(source, world, x, z, make, out);
    fetch_all(tops);
    for (int dz = 0; dz < kTileBoxes; ++dz)
        for (int dx = 0; dx < kTileBoxes; ++dx)
            if (tops.top(dx, dz)) {
                if (out.pixels.empty())
                    out.pixels.resize(std::size_t{kSide} * kSide);
                shade_box(tops, dx, dz, out.pixels);
            }
    return out;
}

namespace {

voxel::InputExtent list_box_columns(const voxel::WorldInfo& info) {
    if (info.bounds.empty())
        return {};
    const auto range = voxel::boxes_over(info.bounds, 0);
    return {range.min.bx, range.min.bz, range.max.bx, range.max.bz};
}

/// Colours are weighted by alpha, so that transparent pixels do not contribute.
Rgba8 measure_mean(const std::array<Rgba8, 4>& four) {
    std::uint32_t alpha = 0;
    std::array<std::uint32_t, 3> sums{};
    for (const Rgba8& p : four) {
        alpha += p.a;
        sums[0] += util::to_linear(p.r) * p.a;
        sums[1] += util::to_linear(p.g) * p.a;
        sums[2] += util::to_linear(p.b) * p.a;
    }
    if (alpha == 0)
        return {};
    const auto channel = [&](std::size_t i) {
        return util::to_srgb((sums[i] + alpha / 2) / alpha);
    };
    return {channel(0), channel(1), channel(2), static_cast<std::uint8_t>((alpha + 2) / 4)};
}

/// Downsamples one picture into a quarter of another.
/// @param quarter bit 0: east, bit 1: south
void put_quarter(const std::vector<Rgba8>& from, int quarter, std::vector<Rgba8>& to) {
    const int x0 = (quarter & 1) * kTilePx / 2;
    const int z0 = (quarter >> 1) * kTilePx / 2;
    for (int z = 0; z < kTilePx / 2; ++z)
        for (int x = 0; x < kTilePx / 2; ++x) {
            const auto at = [&](int dx, int dz) {
                return from[static_cast<std::size_t>((2 * z + dz) * kTilePx + 2 * x + dx)];
            };
            to[static_cast<std::size_t>((z0 + z) * kTilePx + x0 + x)] =
                measure_mean({at(0, 0), at(1, 0), at(0, 1), at(1, 1)});
        }
}

}  // namespace

MapTiles::MapTiles(const voxel::WorldInfo& info, TopSource& source, std::size_t limit_bytes)
    : m_zooms(std::clamp(info.levels, 1, voxel::kMaxLevel + 1)),
      m_world(list_box_columns(info)),
      m_source(source),
      m_pixels(limit_bytes / 4 * 3),
      m_pngs(limit_bytes / 4) {}

std::size_t MapTiles::KeyHash::operator()(const Key& key) const noexcept {
    return static_cast<std::size_t>(
        voxel::morton_encode(key.area.x, key.area.zooms_out, key.area.z) * 31 + key.version);
}

bool MapTiles::in_world(int zooms_out, std::int64_t x, std::int64_t z) const noexcept {
    const std::int64_t side = std::int64_t{kTileBoxes}
                              << zooms_out;  // |x| <= 2^31 and side <= 2^22: no overflow
    return !m_world.empty() && x * side < m_world.max_bx && (x + 1) * side > m_world.min_bx &&
           z * side < m_world.max_bz && (z + 1) * side > m_world.min_bz;
}

Tile MapTiles::get(int z, std::int32_t x, std::int32_t y) {
    if (z < 0 || z >= m_zooms)
        throw util::UsageError("map tile of zoom " + std::to_string(z) + "; allowed: 0 to " +
                               std::to_string(m_zooms - 1));
    const TileArea area{m_zooms - 1 - z, x, y};
    if (!in_world(area.zooms_out, x, y))
        return {nullptr, true, {}};
    Work work;
    work.make = area.zooms_out < kZoomsMade;
    const std::uint64_t version = m_source.version(area);
    const PicturePtr made = picture_on_new_thread(area, work);
    return {png(area, *made, version), made->complete, made->reach};
}

// A picture is made of those of the zooms below, down to the finest: that takes more stack than the
// threads of a server have. What is kept is found without a thread.
MapTiles::PicturePtr MapTiles::picture_on_new_thread(const TileArea& area, Work& work) {
    if (auto found = m_pixels.find({area, kWhole}))
        return found;
    const auto make = [&] { return picture(area, work); };
    return thread::on_new_thread(make, []() -> PicturePtr {
        throw util::Error("draw a map tile: the system gives no thread");
    });
}

MapTiles::PicturePtr MapTiles::picture(const TileArea& area, Work& work) {
    const auto measure_bytes = [](const PicturePtr& p) {
        return sizeof(Picture) + p->pixels.size() * sizeof(Rgba8);
    };
    if (work.make) {
        const auto make = [&] {
            auto seen = m_pixels.find({area, kSeenWhole});
            return seen ? seen : compose(area, work);
        };
        return m_pixels.get({area, kWhole}, make, measure_bytes);
    }
    if (auto found = m_pixels.find({area, kWhole}))
        return found;
    if (auto found = m_pixels.find({area, kSeenWhole}))
        return found;
    // Read before querying the source: if a column becomes available meanwhile, the picture is
    // outdated, but not wrong.
    const std::uint64_t version = m_source.version(area);
    if (version == 0)
        return std::make_shared<const Picture>(Picture{{}, false, false, {}});
    if (auto found = m_pixels.find({area, version}))
        return found;
    if (work.tiles_left <= 0)
        return std::make_shared<const Picture>(Picture{{}, false, true, {}});
    const PicturePtr made = compose(area, work);
    return made->cut ? made
                     : m_pixels.get(
                           {area, made->complete ? kSeenWhole : version}, [&] { return made; },
                           measure_bytes);
}

MapTiles::PicturePtr MapTiles::compose(const TileArea& area, Work& work) {
    --work.tiles_left;
    return area.zooms_out == 0 ? finest(area, work) : mean_of_four(area, work);
}

MapTiles::PicturePtr MapTiles::finest(const TileArea& area, const Work& work) {
    FinestTile tile = make_finest_tile(m_source, m_world, area.x, area.z, work.make);
    return std::make_shared<const Picture>(
        Picture{std::move(tile.pixels), tile.complete, false, tile.reach});
}

MapTiles::PicturePtr MapTiles::mean_of_four(const TileArea& area, Work& work) {
    auto out = std::make_shared<Picture>();
    for (int quarter = 0; quarter < 4; ++quarter) {
        const std::int64_t x = 2 * std::int64_t{area.x} + (quarter & 1);
        const std::int64_t z = 2 * std::int64_t{area.z} + (quarter >> 1);
        if (!in_world(area.zooms_out - 1, x, z))
            continue;
        const PicturePtr part = picture(
            {area.zooms_out - 1, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)}, work);
        out->complete = out->complete && part->complete;
        out->cut = out->cut || part->cut;
        out->reach.add(part->reach);
        if (part->pixels.empty())
            continue;
        if (out->pixels.empty())
            out->pixels.resize(std::size_t{kTilePx} * kTilePx);
        put_quarter(part->pixels, quarter, out->pixels);
    }
    return out;
}

// `version` was read before the picture was made, so a picture may be newer than its version and is
// then encoded once more than necessary.
std::shared_ptr<const std::string> MapTiles::png(const TileArea& area, const Picture& picture,
                                                 std::uint64_t version) {
    if (picture.pixels.empty())
        return nullptr;
    const auto make = [&] {
        return std::make_shared<const std::string>(to_png(picture.pixels, kTilePx, kTilePx));
    };
    if (picture.cut)
        return make();
    return m_pngs.get({area, picture.complete ? kWhole : version}, make,
                      [](const auto& text) { return sizeof *text + text->size(); });
}

}  // namespace terravox::map
