#include <array>
#include <cmath>
#include <cstdio>

#include "common/voxel/box.hpp"
#include "tests/bench/entries/data_sets.hpp"
#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/lidar/las_writer.hpp"

namespace terravox::bench::voxelize_materials_entry {
namespace {

using voxel::Material;

/// What a surface is, coarsely: surfaces that an eye tells apart from the air.
enum class Kind : std::uint8_t { kNone, kGrass, kBare, kSealed, kTiles, kSlate, kFlat };
constexpr std::size_t kKinds = 7;
constexpr std::array<const char*, kKinds> kNames{"none",  "grass",        "bare ground", "sealed",
                                                 "tiles", "slate, metal", "flat roof"};

Kind kind_of(Material m) noexcept {
    switch (m) {
        case Material::kGrass: return Kind::kGrass;
        case Material::kGround:
        case Material::kSand: return Kind::kBare;
        case Material::kRoad:
        case Material::kConcrete: return Kind::kSealed;
        case Material::kRoof:  // drawn as tiles
        case Material::kOrangeRoof: return Kind::kTiles;
        case Material::kGreyRoof: return Kind::kSlate;
        case Material::kFlatRoof: return Kind::kFlat;
        default: return Kind::kNone;
    }
}
bool is_ground(Kind k) noexcept {
    return k == Kind::kGrass || k == Kind::kBare || k == Kind::kSealed;
}
bool is_roof(Kind k) noexcept {
    return k == Kind::kTiles || k == Kind::kSlate || k == Kind::kFlat;
}

/// The highest voxel of a column of a box column; air where there is none.
voxel::VoxelAttr top_of(const std::vector<std::shared_ptr<const voxel::Box>>& boxes, int x, int z) {
    for (auto box = boxes.rbegin(); box != boxes.rend(); ++box) {
        if (!*box)
            continue;
        for (int y = voxel::kBoxSizeY - 1; y >= 0; --y)
            if (const auto found = (*box)->voxel(x, y, z))
                return *found;
    }
    voxel::VoxelAttr air;
    air.material = Material::kAir;
    return air;
}

using Counts = std::array<std::array<std::size_t, kKinds>, kKinds>;  ///< [with][without colours]

std::vector<std::shared_ptr<const voxel::Box>> boxes_over(voxel::World& world, std::int32_t bx,
                                                          std::int32_t bz) {
    const auto extent = world.column(0, bx, bz);
    std::vector<std::shared_ptr<const voxel::Box>> out;
    for (auto by = extent.by_begin; by < extent.by_end; ++by)
        out.push_back(world.box({0, bx, by, bz}));
    return out;
}

/// Compares the surfaces of two worlds where the first one's has a measured colour.
Counts compare(voxel::World& with, voxel::World& without) {
    Counts out{};
    const auto range = voxel::boxes_over(with.info().bounds, 0);
    for (auto bz = range.min.bz; bz < range.max.bz; ++bz)
        for (auto bx = range.min.bx; bx < range.max.bx; ++bx) {
            const auto a = boxes_over(with, bx, bz);
            const auto b = boxes_over(without, bx, bz);
            for (int z = 0; z < voxel::kBoxSizeZ; ++z)
                for (int x = 0; x < voxel::kBoxSizeX; ++x) {
                    const voxel::VoxelAttr seen = top_of(a, x, z);
                    if (seen.has_colour())
                        ++out[static_cast<std::size_t>(kind_of(seen.material))]
                             [static_cast<std::size_t>(kind_of(top_of(b, x, z).material))];
                }
        }
    return out;
}

struct Agreement {
    double share = 0;     ///< of all columns
    double balanced = 0;  ///< mean over kinds of the share of the kind's columns
};
template <class Is>
Agreement agreement_of(const Counts& counts, const Is& is) {
    std::size_t all = 0;
    std::size_t equal = 0;
    double sum = 0;
    int kinds = 0;
    for (std::size_t a = 0; a < kKinds; ++a) {
        std::size_t own = 0;
        for (std::size_t b = 0; b < kKinds; ++b)
            if (is(static_cast<Kind>(a)) && is(static_cast<Kind>(b)))
                own += counts[a][b];
        if (own == 0)
            continue;
        all += own;
        equal += counts[a][a];
        sum += static_cast<double>(counts[a][a]) / static_cast<double>(own);
        ++kinds;
    }
    if (all == 0)
        return {};
    return {static_cast<double>(equal) / static_cast<double>(all), sum / kinds};
}

std::string table_of(const Counts& counts) {
    std::string out = "kind with colours x kind without, columns\n\n| with |";
    std::string line = "\n|---|";
    for (std::size_t b = 1; b < kKinds; ++b) {
        out += std::string(" ") + kNames[b] + " |";
        line += "---:|";
    }
    out += line + "\n";
    for (std::size_t a = 1; a < kKinds; ++a) {
        out += std::string("| ") + kNames[a] + " |";
        for (std::size_t b = 1; b < kKinds; ++b)
            out += " " + std::to_string(counts[a][b]) + " |";
        out += "\n";
    }
    return out;
}

/// A copy of a file without its colours.
std::filesystem::path without_colours(const std::filesystem::path& file,
                                      const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const auto path = folder / (file.stem().string() + ".laz");
    const auto info = lidar::read_las_info(file);
    lidar::LasWriterOptions options;
    options.point_format = 6;
    options.scale = info.scale;
    options.offset = info.offset;
    if (info.crs)
        options.wkt = info.crs->wkt();
    lidar::LasWriter writer(path, options);
    lidar::read_las_points(info, {0, info.point_count}, [&](const pointcloud::Point& p) {
        lidar::LasWritePoint copy;
        copy.x = p.x;
        copy.y = p.y;
        copy.z = p.z;
        copy.intensity = p.intensity;
        copy.point_source = p.line;
        copy.return_number = p.return_number;
        copy.return_count = p.return_count;
        copy.classification = p.classification;
        writer.write(copy);
    });
    writer.close();
    return path;
}

void measure(const voxelize::LidarWorldOptions& with, const voxelize::LidarWorldOptions& without,
             Readings& readings) {
    util::StageTimes times;
    const auto a = voxelize::open_lidar_world(with, times);
    const auto b = voxelize::open_lidar_world(without, times);
    const Counts counts = compare(*a, *b);
    const Agreement ground = agreement_of(counts, is_ground);
    const Agreement roofs = agreement_of(counts, is_roof);
    readings.add("ground kinds: agreement", "share", ground.share, at_least(0.7));
    readings.add("ground kinds: agreement, mean over kinds", "share", ground.balanced);
    readings.add("roofs: agreement", "share", roofs.share, at_least(0.6));
    readings.add("roofs: agreement, mean over kinds", "share", roofs.balanced);
    readings.note(table_of(counts));
}

constexpr const char* kMeasures =
    "materials guessed without colours against those from colours, where these show the surface";

Entry montpellier_entry() {
    Entry out;
    out.name = "voxelize/materials/montpellier";
    out.measures = kMeasures;
    out.work = "the square of 50 m with an orthophoto, six squares of points, voxels of 1 m";
    out.missing = [](const Context& c) { return montpellier().missing(c); };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            voxelize::LidarWorldOptions without;
            without.files = montpellier().paths(c);
            without.classes = montpellier().classes;
            without.threads = c.threads;
            voxelize::LidarWorldOptions with = without;
            with.orthophotos = montpellier().orthophoto_paths(c);
            measure(with, without, readings);
        };
    };
    return out;
}

constexpr const char* kAutzen = "pdal/laz/autzen_trim.laz";

Entry autzen_entry() {
    Entry out;
    out.name = "voxelize/materials/autzen";
    out.measures = kMeasures;
    out.work = "autzen_trim.laz, 110,000 points, 359 x 171 m, with its colours and without";
    out.missing = [](const Context& c) {
        std::error_code ignored;
        return std::filesystem::exists(c.data / kAutzen, ignored)
                   ? std::string()
                   : std::string("no ") + kAutzen + " in " + c.data.string() + " (--data)";
    };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        const auto copy = without_colours(c.data / kAutzen, c.scratch / "materials");
        return [&c, copy](Readings& readings) {
            voxelize::LidarWorldOptions with;
            with.files = {c.data / kAutzen};
            with.threads = c.threads;
            voxelize::LidarWorldOptions without = with;
            without.files = {copy};
            measure(with, without, readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{montpellier_entry(), autzen_entry()}; });

}  // namespace
}  // namespace terravox::bench::voxelize_materials_entry
