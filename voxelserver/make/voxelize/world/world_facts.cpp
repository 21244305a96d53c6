#include "voxelserver/make/voxelize/world/world_facts.hpp"

#include <gdal_version.h>
#include <algorithm>

#include "common/util/error.hpp"
#include "common/voxel/fingerprint.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/data/imagery/image_files.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

namespace terravox::voxelize {
namespace {

using voxel::ByteReader;
using voxel::ByteWriter;
using voxel::Fingerprint;

constexpr std::size_t kRectBytes = 16;
constexpr std::size_t kInputBytes = kRectBytes + 16 + 1;
constexpr std::size_t kSquareBytes = 2 * 8 + kRectBytes + 2 * 8;

void put(voxel::ByteWriter& out, const grid::ColumnRect& r) {
    out.add(r.min_x);
    out.add(r.min_z);
    out.add(r.max_x);
    out.add(r.max_z);
}

grid::ColumnRect rect(voxel::ByteReader& in) {
    grid::ColumnRect r;
    r.min_x = in.get<std::int32_t>();
    r.min_z = in.get<std::int32_t>();
    r.max_x = in.get<std::int32_t>();
    r.max_z = in.get<std::int32_t>();
    return r;
}

void put(voxel::ByteWriter& out, const std::vector<InputFingerprints::Input>& inputs) {
    out.add(static_cast<std::uint64_t>(inputs.size()));
    for (const auto& i : inputs) {
        put(out, i.rect);
        out.add(i.fingerprint);
        out.add(static_cast<std::uint8_t>(i.coloured));
    }
}

std::vector<InputFingerprints::Input> inputs(voxel::ByteReader& in) {
    std::vector<InputFingerprints::Input> out(in.count(kInputBytes));
    for (auto& i : out) {
        i.rect = rect(in);
        i.fingerprint = in.fingerprint();
        i.coloured = in.get<std::uint8_t>() != 0;
    }
    return out;
}

void put(voxel::ByteWriter& out, const voxel::WorldInfo& info) {
    out.add(info.title);
    for (const auto& corner : {info.bounds.min, info.bounds.max})
        for (const std::int32_t v : corner)
            out.add(v);
    out.add(info.voxel_m);
    out.add(static_cast<std::int32_t>(info.levels));
    out.add(info.crs);
    out.add(info.crs_wkt);
    out.add(info.crs_units_per_voxel);
    out.add(static_cast<std::uint8_t>(info.centre.has_value()));
    out.add(info.centre ? info.centre->lat_deg : 0);
    out.add(info.centre ? info.centre->lon_deg : 0);
    out.add(info.centre ? info.centre->convergence_deg : 0);
    out.add(info.licence);
    out.add(info.attribution);
    out.add(static_cast<std::uint8_t>(info.typical_heights.has_value()));
    out.add(info.typical_heights ? info.typical_heights->min : 0);
    out.add(info.typical_heights ? info.typical_heights->max : 0);
}

voxel::WorldInfo world_info(voxel::ByteReader& in) {
    voxel::WorldInfo out;
    out.title = in.text();
    for (auto* corner : {&out.bounds.min, &out.bounds.max})
        for (std::int32_t& v : *corner)
            v = in.get<std::int32_t>();
    out.voxel_m = in.get<double>();
    out.levels = in.get<std::int32_t>();
    out.crs = in.text();
    out.crs_wkt = in.text();
    out.crs_units_per_voxel = in.get<double>();
    const bool placed = in.get<std::uint8_t>() != 0;
    const auto lat = in.get<double>();
    const auto lon = in.get<double>();
    const auto convergence = in.get<double>();
    if (placed)
        out.centre = geo::MapPlace{{lat, lon}, convergence};
    out.licence = in.text();
    out.attribution = in.text();
    const bool has_heights = in.get<std::uint8_t>() != 0;
    const auto min = in.get<std::int32_t>();
    const auto max = in.get<std::int32_t>();
    if (has_heights)
        out.typical_heights = voxel::HeightRange{min, max};
    return out;
}

}  // namespace

// Between distant files there is nothing: without this test, a coarse box would be subdivided down
// to each of its columns.
bool WorldFacts::touches_land(int level, std::int32_t bx, std::int32_t bz) const noexcept {
    const std::int64_t edge_x = std::int64_t{voxel::kBoxSizeX} << level;
    const std::int64_t edge_z = std::int64_t{voxel::kBoxSizeZ} << level;
    const std::int64_t x = bx * edge_x;
    const std::int64_t z = bz * edge_z;
    return std::any_of(islands.begin(), islands.end(), [&](const grid::ColumnRect& r) {
        return x < r.max_x && r.min_x < x + edge_x && z < r.max_z && r.min_z < z + edge_z;
    });
}

voxel::ColumnExtent WorldFacts::column(int level, std::int32_t bx, std::int32_t bz) const {
    voxel::check_level(info, level);
    if (!touches_land(level, bx, bz))
        return {};
    return voxel::column_of_bounds(info.bounds, level, bx, bz);
}

std::string to_bytes(const WorldFacts& facts) {
    voxel::ByteWriter out;
    put(out, facts.info);
    out.add(static_cast<std::uint64_t>(facts.islands.size()));
    for (const grid::ColumnRect& r : facts.islands)
        put(out, r);
    out.add(static_cast<std::uint64_t>(facts.squares.size()));
    for (const SquareInfo& s : facts.squares) {
        out.add(s.name);
        out.add(s.file.string());
        put(out, s.bounds);
        out.add(s.points);
        out.add(s.bytes);
    }
    out.add(facts.orthophotos);
    out.add(facts.water_cell_m);
    out.add(facts.fingerprints.everywhere);
    out.add(facts.fingerprints.palette);
    put(out, facts.fingerprints.points);
    put(out, facts.fingerprints.images);
    voxel::ByteWriter whole;
    whole.add(out.fingerprint());
    whole.add(kBoxRecipe);
    return std::string(kFactsMagic) + whole.bytes() + out.bytes();
}

WorldFacts facts_from_bytes(std::string_view bytes) {
    const auto fail = [](const std::string& what) {
        return util::Error("read the facts of a world: " + what);
    };
    if (!bytes.starts_with(kFactsMagic))
        throw fail("another version, or no facts");
    voxel::ByteReader head(bytes.substr(kFactsMagic.size()));
    const Fingerprint said = head.fingerprint();
    const auto recipe = head.get<std::uint32_t>();
    if (!head.ok())
        throw fail("cut short");
    if (recipe != kBoxRecipe)
        throw fail("made by box recipe " + std::to_string(recipe) +
                   "; allowed: " + std::to_string(kBoxRecipe));
    const std::string_view body =
        bytes.substr(kFactsMagic.size() + 2 * sizeof(std::uint64_t) + sizeof recipe);
    if (voxel::to_fingerprint(body) != said)
        throw fail("damaged (checksum)");
    voxel::ByteReader in(body);
    WorldFacts out;
    out.info = world_info(in);
    out.islands.resize(in.count(kRectBytes));
    for (grid::ColumnRect& r : out.islands)
        r = rect(in);
    out.squares.resize(in.count(kSquareBytes));
    for (SquareInfo& s : out.squares) {
        s.name = in.text();
        s.file = in.text();
        s.bounds = rect(in);
        s.points = in.get<std::uint64_t>();
        s.bytes = in.get<std::uint64_t>();
    }
    out.orthophotos = in.get<std::uint64_t>();
    out.water_cell_m = in.get<double>();
    out.fingerprints.everywhere = in.fingerprint();
    out.fingerprints.palette = in.fingerprint();
    out.fingerprints.points = inputs(in);
    out.fingerprints.images = inputs(in);
    // A checksum detects damage, not malice: values that would break arithmetic are rejected.
    if (!in.finished() || out.info.levels < 1 || out.info.levels > voxel::kMaxLevel)
        throw fail("damaged");
    return out;
}

namespace {

void add_table(voxel::ByteWriter& out, const ClassTable& table) {
    out.add(to_fingerprint(table));
    out.add(table.crs.has_value());
    out.add(table.crs.value_or(""));
    out.add(table.meant.crs.size());
    for (const std::string& crs : table.meant.crs)
        out.add(crs);
    for (const double edge : table.meant.extent)
        out.add(edge);
    for (const auto* codes : {&table.meant.with, &table.meant.without})
        out.add(*codes ? (*codes)->to_string() : std::string());
}

}  // namespace

std::string world_name(const LidarWorldOptions& options, const std::filesystem::path& opener) {
    voxel::ByteWriter out;
    out.add(kFactsMagic);
    out.add(kBoxRecipe);
    out.add(std::string_view(GDAL_RELEASE_NAME));
    if (!opener.empty())
        out.add(voxel::file_identity(opener, "worlds module"));
    const Settings settings = load_settings(options.settings, options.steps, options.photo);
    out.add(to_fingerprint(settings));
    out.add(palette_fingerprint(settings));
    out.add(tints_fingerprint(settings));
    out.add(options.mark_unknown);
    if (options.classes == kAnyClassTable)
        for (const ClassTable& table : shipped_class_tables())
            add_table(out, table);
    else
        add_table(out, load_class_table(options.classes));
    out.add(options.crs.has_value());
    out.add(options.crs.value_or(""));
    out.add(options.recorded_crs.size());
    for (const auto& [file, crs] : options.recorded_crs) {
        out.add(file.string());
        out.add(crs);
    }
    out.add(options.licence);
    out.add(options.attribution);
    out.add(options.vertical_unit.has_value());
    out.add(options.vertical_unit.value_or(""));
    out.add(options.voxel_m);
    const auto files = lidar_files(options);
    out.add(world_title(options));
    out.add(files.size());
    for (const auto& file : files) {
        out.add(file.string());
        out.add(voxel::file_identity(file, "point cloud"));
        if (const auto side_file = pointcloud::find_side_file(file))
            out.add(voxel::file_identity(*side_file, "side file"));
    }
    if (!options.orthophotos.empty()) {
        auto images = imagery::orthophoto_files(options.orthophotos);
        std::sort(images.begin(), images.end());
        for (const auto& image : images) {
            out.add(image.string());
            out.add(imagery::image_identity(image));
        }
    }
    return voxel::to_hex(out.fingerprint());
}

}  // namespace terravox::voxelize
