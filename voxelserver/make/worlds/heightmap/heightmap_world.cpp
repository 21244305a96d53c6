#include "voxelserver/make/worlds/heightmap/heightmap_world.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <span>
#include <string>

#include "common/geo/gdal_files.hpp"
#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/data/grid/frame.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"
#include "voxelserver/make/worlds/heightmap/heightmap_columns.hpp"

namespace terravox::heightmap {
namespace {

namespace fs = std::filesystem;
using voxel::Box;
using voxel::BoxKey;

/// The combined properties of the rasters.
struct Survey {
    std::vector<HeightGrid::File> files;  ///< by precedence
    HeightFile::Outline outline;
    HeightFile::Range range;
    geo::Crs crs;
    std::string attribution;
};

std::optional<geo::Crs> find_crs(const HeightmapOptions& options) {
    return options.crs ? std::optional(geo::Crs::from_text(*options.crs)) : std::nullopt;
}

/// A raster as described by itself, before it is known how it will be read.
struct Found {
    Reading reading;
    double cell_m = 0;
    bool north_up = true;
    geo::Crs crs;
    std::array<double, 2> middle{};
};

std::vector<Found> find_rasters(const HeightmapOptions& options) {
    if (options.rasters.empty())
        throw util::UsageError(
            "open a heightmap: no raster given; allowed: one or more rasters of heights");
    std::vector<Found> found;
    for (const fs::path& path : options.rasters) {
        const Reading reading{path, find_crs(options), std::nullopt, options.height_unit_m};
        const HeightFile file(reading);
        const HeightFile::Outline o = file.outline();
        found.push_back({reading,
                         file.cell_m(),
                         file.north_up(),
                         file.crs(),
                         {(o.west + o.east) / 2, (o.south + o.north) / 2}});
    }
    const auto millimetres = [](const Found& f) { return std::llround(f.cell_m * 1000); };
    std::sort(found.begin(), found.end(), [&](const Found& a, const Found& b) {
        return millimetres(a) != millimetres(b) ? millimetres(a) < millimetres(b)
                                                : a.reading.path < b.reading.path;
    });
    found.erase(std::unique(found.begin(), found.end(),
                            [](const Found& a, const Found& b) {
                                return a.reading.path == b.reading.path;
                            }),
                found.end());
    return found;
}

/// Inspects all rasters: those in another CRS than the first, in degrees, or turned, will be warped
/// as they are read.
Survey survey(const HeightmapOptions& options) {
    constexpr double kMaxCells = 16e6;  // to read for the lowest and highest: a second
    const std::vector<Found> found = find_rasters(options);
    const Found& first = found.front();
    Survey out{{}, {}, {}, grid::voxel_crs_for(first.crs, first.middle[0], first.middle[1]), {}};
    bool any = false;
    for (const Found& f : found) {
        HeightGrid::File file{f.reading, {}};
        if (!f.north_up || !f.crs.same_horizontal(out.crs))
            file.reading.warped_to = out.crs;
        HeightFile opened(file.reading);
        file.outline = opened.outline();
        const auto range = opened.rough_range(kMaxCells / static_cast<double>(found.size()));
        if (out.attribution.empty())
            out.attribution = opened.copyright();
        if (!range) {
            if (found.size() == 1)
                throw util::Error(
                    "open the heightmap {}: no heights in it, none between -12000 m and 10000 m",
                    f.reading.path.string());
            util::log_warn("heightmap {}: no heights in it", f.reading.path.string());
            continue;
        }
        if (!range->exact && opened.overviews() == 0)
            util::log_info(
                "heightmap {}: no overviews; gdaladdo -r average makes far views of it faster",
                f.reading.path.string());
        out.files.push_back(file);
        const HeightFile::Outline& o = file.outline;
        if (!any) {
            out.outline = o;
            out.range = *range;
        }
        out.outline = {std::min(out.outline.west, o.west), std::min(out.outline.south, o.south),
                       std::max(out.outline.east, o.east), std::max(out.outline.north, o.north)};
        out.range = {std::min(out.range.low_m, range->low_m),
                     std::max(out.range.high_m, range->high_m), out.range.exact && range->exact};
        any = true;
    }
    if (!any)
        throw util::Error("open the heightmap: no heights in any of {} rasters", found.size());
    return out;
}

class HeightmapWorld final : public voxel::World {
public:
    HeightmapWorld(const HeightmapOptions& options, Survey found)
        : m_options(options),
          m_middle{(found.outline.west + found.outline.east) / 2,
                   (found.outline.south + found.outline.north) / 2},
          m_frame(found.crs, options.voxel_m, m_middle[0], m_middle[1]),
          m_grid(found.files, m_frame, options.threads),
          m_columns(options.memory_bytes / 4) {
        describe(found);
        if (!options.orthophotos.empty())
            photos(0).warn_of_outside({m_info.bounds.min[0], m_info.bounds.min[2],
                                       m_info.bounds.max[0], m_info.bounds.max[2]});
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        voxel::check_level(m_info, key.level);
        if (m_stopped)
            throw util::Error("make box {}: interrupted", to_string(key));
        if (!boxes_over(m_info.bounds, key.level).contains(key))
            return nullptr;
        const auto columns = m_columns.get(
            {key.level, key.bx, 0, key.bz}, [&] { return make_columns(key.level, key.bx, key.bz); },
            [](const auto& made) { return made->memory_bytes(); });
        return make_box(key, *columns);
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        voxel::check_level(m_info, level);
        return voxel::column_of_bounds(m_info.bounds, level, bx, bz);
    }

    void stop() noexcept override { m_stopped = true; }

private:
    void describe(const Survey& found) {
        const HeightFile::Outline& o = found.outline;
        const auto voxel_at = [&](double v, const char* what) {
            constexpr double kMax = 1 << 29;  // room for coarse voxels that extend beyond
            if (!(std::abs(v) < kMax))
                throw util::Error(
                    "open the heightmap {}: its {} is {:f} voxels; allowed: within +-2^29",
                    found.files.front().reading.path.string(), what, v);
            return static_cast<std::int32_t>(std::floor(v));
        };
        const std::int32_t low = voxel_at(m_frame.y(found.range.low_m), "lowest height");
        const std::int32_t high = voxel_at(m_frame.y(found.range.high_m), "highest height") + 1;
        m_base = m_options.base_m ? voxel_at(m_frame.y(*m_options.base_m), "base")
                                  : low - std::max(kBelow, (high - low) / 16);
        // Where not all cells were read there may be lower and higher ones.
        const std::int32_t room = found.range.exact ? 0 : std::max(64, (high - low) / 2);
        m_info.bounds.min = {voxel_at(m_frame.x(o.west), "western edge"),
                             std::min(m_base, low - kThinnest) - room,
                             voxel_at(m_frame.z(o.north), "northern edge")};
        m_info.bounds.max = {voxel_at(std::ceil(m_frame.x(o.east)), "eastern edge"), high + room,
                             voxel_at(std::ceil(m_frame.z(o.south)), "southern edge")};
        if (room > 0) {
            m_info.framed = m_info.bounds;
            m_info.framed.min[1] = std::min(m_base, low - kThinnest);
            m_info.framed.max[1] = high;
        }
        m_info.title = found.files.front().reading.path.stem().string();
        if (found.files.size() > 1)
            m_info.title += " and " + std::to_string(found.files.size() - 1) + " more";
        m_info.voxel_m = m_frame.voxel_m();
        m_info.crs_units_per_voxel = m_frame.units_per_voxel();
        m_info.crs = m_frame.crs().name();
        m_info.crs_wkt = m_frame.crs().wkt();
        m_info.attribution = found.attribution;
        m_info.centre = geo::map_place(m_frame.crs(), m_middle[0], m_middle[1]);
        const std::int64_t widest =
            std::max(std::int64_t{m_info.bounds.max[0]} - m_info.bounds.min[0],
                     std::int64_t{m_info.bounds.max[2]} - m_info.bounds.min[2]);
        // Orthophotos are read for voxels of up to 1000 m.
        while (m_info.levels < voxel::kMaxLevel &&
               (std::int64_t{voxel::kBoxSizeX} << (m_info.levels - 1)) < widest &&
               (m_options.orthophotos.empty() || std::ldexp(m_info.voxel_m, m_info.levels) <= 1000))
            ++m_info.levels;
    }

    /// Images for reading at voxels of a level: the frame of a coarse voxel is that of the finest,
    /// doubled level times.
    [[nodiscard]] const imagery::Orthophotos& photos(int level) {
        const std::lock_guard lock(m_photos_mutex);
        auto& at = m_photos[static_cast<std::size_t>(level)];
        if (!at) {
            const grid::Frame frame(m_frame.crs(), std::ldexp(m_frame.voxel_m(), level),
                                    m_middle[0], m_middle[1]);
            at = std::make_unique<imagery::Orthophotos>(m_options.orthophotos, frame,
                                                        std::span<const grid::NamedSquare>{},
                                                        m_photos.front().get());
        }
        return *at;
    }

    [[nodiscard]] std::shared_ptr<const HeightmapColumns> make_columns(int level, std::int32_t bx,
                                                                       std::int32_t bz) {
        const std::int32_t x0 = bx * voxel::kBoxSizeX;
        const std::int32_t z0 = bz * voxel::kBoxSizeZ;
        const ColumnHeights heights =
            m_grid.read(level, x0 - 1, z0 - 1, HeightmapColumns::kSide, HeightmapColumns::kSide);
        imagery::Raster colours;
        const bool any = std::any_of(heights.voxels.begin(), heights.voxels.end(),
                                     [](double h) { return !std::isnan(h); });
        if (any && !m_options.orthophotos.empty())
            colours = photos(level).read(x0, z0, voxel::kBoxSizeX, voxel::kBoxSizeZ);
        auto out = std::make_shared<const HeightmapColumns>(level, heights, colours);
        if (out->highest() != HeightmapColumns::kNothing)
            check_heights(level, bx, bz, *out);
        return out;
    }

    // The bounds were fixed before all cells were read: anything beyond them cannot be shown, and
    // must not be cut off silently.
    void check_heights(int level, std::int32_t bx, std::int32_t bz,
                       const HeightmapColumns& columns) const {
        const std::int64_t high =
            (std::int64_t{columns.highest()} - 1) * (std::int64_t{1} << level);
        const std::int64_t low = std::int64_t{columns.lowest()} * (std::int64_t{1} << level);
        if (high < m_info.bounds.max[1] && low >= m_info.bounds.min[1])
            return;
        const auto metres = [&](std::int64_t y) {
            return std::to_string(static_cast<double>(y) * m_info.voxel_m);
        };
        throw util::Error(
            "make boxes {}: heights up to {} m and down to {} m; by its overviews: {} to {}; make "
            "them anew with gdaladdo",
            to_string(BoxKey{level, bx, 0, bz}), metres(high), metres(low),
            metres(m_info.bounds.min[1]), metres(m_info.bounds.max[1]));
    }

    [[nodiscard]] std::shared_ptr<const Box> make_box(const BoxKey& key,
                                                      const HeightmapColumns& columns) const {
        const std::int32_t y0 = key.by * voxel::kBoxSizeY;
        if (columns.highest() == HeightmapColumns::kNothing || columns.highest() <= y0)
            return nullptr;
        const std::int32_t base = m_base >> key.level;
        voxel::BoxBuilder builder;
        for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
            for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
                const std::int32_t top = columns.top(x, z);
                if (top != HeightmapColumns::kNothing)
                    builder.add(x, z,
                                std::min(base, top - std::max(kThinnest >> key.level, 1)) - y0,
                                top - y0, true);
            }
        return builder.build(key, [&](int x, int y, int z) {
            return columns.attr(x, z, columns.top(x, z) - 1 - (y0 + y));
        });
    }

    static constexpr std::int32_t kBelow = 8;  ///< voxels of rock below the lowest ground, at least
    static constexpr std::int32_t kThinnest = 2;  ///< voxels of ground, wherever the base is

    const HeightmapOptions m_options;
    const std::array<double, 2> m_middle;  ///< easting, northing: where the frame's scale is true
    const grid::Frame m_frame;
    HeightGrid m_grid;
    voxel::WorldInfo m_info;
    std::int32_t m_base = 0;
    util::Cache<BoxKey, HeightmapColumns, voxel::BoxKeyHash> m_columns;  ///< by = 0
    std::mutex m_photos_mutex;
    std::array<std::unique_ptr<imagery::Orthophotos>, voxel::kMaxLevel + 1> m_photos;
    std::atomic<bool> m_stopped{false};
};

}  // namespace

std::unique_ptr<voxel::World> open_heightmap_world(const HeightmapOptions& options) {
    if (!(options.voxel_m > 0 && options.voxel_m <= 1000))
        throw util::UsageError("open a heightmap: voxel_m = {:f}; allowed: above 0, up to 1000",
                               options.voxel_m);
    if (options.height_unit_m && !(*options.height_unit_m > 0 && *options.height_unit_m <= 1000))
        throw util::UsageError(
            "open a heightmap: height_unit_m = {:f}; allowed: above 0, up to 1000",
            *options.height_unit_m);
    if (options.base_m && !(std::abs(*options.base_m) <= 1e5))
        throw util::UsageError("open a heightmap: base_m = {:f}; allowed: -100000 to 100000",
                               *options.base_m);
    return std::make_unique<HeightmapWorld>(options, survey(options));
}

std::optional<std::string> fault_of_raster(const std::filesystem::path& path) {
    try {
        return fault_of_heights(*geo::open_raster(path, "look at"));
    } catch (const geo::RasterError& e) {
        return e.reason;
    } catch (const util::Error&) {
        return std::nullopt;
    }
}

bool is_height_raster(const std::filesystem::path& path) noexcept {
    try {
        const std::optional<std::string> fault = fault_of_raster(path);
        // One that lost its end was one: opening it says so. GDAL passes on the text alone.
        return fault && (fault->empty() || fault->starts_with("cut short: "));
    } catch (...) {
        return false;
    }
}

}  // namespace terravox::heightmap
