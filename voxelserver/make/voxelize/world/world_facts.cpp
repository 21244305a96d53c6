#include "voxelserver/make/voxelize/world/world_facts.hpp"

#include <gdal_version.h>
#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/folders.hpp"
#include "common/voxel/fingerprint.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/data/imagery/image_files.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/points/stored_facts.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Fingerprint;

constexpr std::size_t kRectBytes = 16;
constexpr std::size_t kInputBytes = kRectBytes + 16 + 1;
constexpr std::size_t kSquareBytes = 2 * 8 + kRectBytes + 2 * 8;

// Each names the members of a value for both ways (MaybeConst).

template <class Bytes>
void visit(Bytes& bytes, MaybeConst<grid::ColumnRect> auto& r) {
    bytes.each(r.min_x, r.min_z, r.max_x, r.max_z);
}

template <class Bytes>
void visit(Bytes& bytes, MaybeConst<voxel::WorldInfo> auto& info) {
    bytes.each(info.title, info.bounds.min, info.bounds.max, info.voxel_m, info.levels, info.crs,
               info.crs_wkt, info.crs_units_per_voxel);
    bytes.maybe(info.centre,
                [&](auto& at) { bytes.each(at.lat_deg, at.lon_deg, at.convergence_deg); });
    bytes.each(info.licence, info.attribution);
    bytes.maybe(info.typical_heights, [&](auto& range) { bytes.each(range.min, range.max); });
}

template <class Bytes>
void visit(Bytes& bytes, MaybeConst<WorldFacts> auto& facts) {
    visit(bytes, facts.info);
    bytes.list(facts.islands, kRectBytes, [&](auto& r) { visit(bytes, r); });
    bytes.list(facts.squares, kSquareBytes, [&](auto& s) {
        bytes.each(s.name, s.file);
        visit(bytes, s.bounds);
        bytes.each(s.points, s.bytes);
    });
    auto& prints = facts.fingerprints;
    bytes.each(facts.orthophotos, facts.water_cell_m, prints.everywhere, prints.palette);
    for (auto* const inputs : {&prints.points, &prints.images})
        bytes.list(*inputs, kInputBytes, [&](auto& i) {
            visit(bytes, i.rect);
            bytes.each(i.fingerprint, i.coloured);
        });
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
    FactWriter out;
    visit(out, facts);
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
    FactReader head(bytes.substr(kFactsMagic.size()));
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
    FactReader in(body);
    WorldFacts out;
    visit(in, out);
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

/// All that the choice of tints depends on besides the place.
void add_tints(voxel::ByteWriter& out, const Settings& settings) {
    if (!settings.steps.colour_variation)
        return;
    if (settings.tints != kAnyTints) {
        out.add(to_fingerprint(Tints::load(settings.tints)));
        return;
    }
    for (const Tints& tints : shipped_tints()) {
        out.add(tints.id());
        out.add(to_fingerprint(tints));
        for (const Tints::Region& region : tints.regions())
            for (const double edge : region)
                out.add(edge);
    }
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
    add_tints(out, settings);
    out.add(options.mark_unknown);
    // What the names of files say.
    constexpr std::size_t kMaxSource = std::size_t{1} << 20;
    const std::filesystem::path sources = util::config_dir() / "sources";
    for (const std::string& id : util::toml_id_list(sources))
        out.add(util::read_text(sources / (id + ".toml"), kMaxSource, "read the source"));
    if (options.classes == kAnyClassTable)
        for (const ClassTable& table : shipped_class_tables()) {
            out.add(table.id);
            add_table(out, table);
        }
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
