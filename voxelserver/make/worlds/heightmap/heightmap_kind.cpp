#include "voxelserver/make/worlds/heightmap/heightmap_world.hpp"

#include <array>
#include <filesystem>
#include <functional>
#include <string_view>

#include "common/thread/parallel.hpp"
#include "common/util/files.hpp"
#include "common/util/text.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/imagery/image_files.hpp"

namespace terravox::worlds {
namespace {

namespace fs = std::filesystem;

bool is_raster_or_folder_of_them(const std::string& input) {
    std::error_code failed;
    if (!fs::is_directory(input, failed))
        return heightmap::is_height_raster(input);
    return util::any_file(input, heightmap::is_height_raster);
}

/// Metres to a unit of height; nullopt: that of the raster.
std::optional<double> height_unit_m(const std::string& unit) {
    if (unit == "m")
        return 1;
    if (unit == "ft")
        return 0.3048;
    if (unit == "us-ft")
        return 1200.0 / 3937;
    return std::nullopt;
}

/// A text next to rasters is one of them only if it can be read as one; any other file with such an
/// ending must be, since a damaged raster that is left out would be a gap that nobody sees.
bool belongs_to_rasters(const fs::path& file) {
    return util::lower_extension(file) != ".txt" || heightmap::is_height_raster(file);
}

std::vector<fs::path> list_rasters(const worlds::WorldOptions& options,
                                   const std::function<bool(const fs::path&)>& belongs) {
    // The usual endings of what geo::open_raster() reads, apart from pictures.
    constexpr std::array<std::string_view, 15> kEndings = {
        ".tif", ".tiff", ".asc", ".img", ".vrt", ".dem", ".hgt", ".bil",
        ".flt", ".dt0",  ".dt1", ".dt2", ".grd", ".xyz", ".txt",
    };
    return util::expand_folders({options.inputs.begin(), options.inputs.end()}, kEndings,
                                "rasters of heights", belongs);
}

/// Includes names, since of overlapping rasters the first by name counts; and all texts next to the
/// rasters, since it is computed after each box and must open no file.
voxel::Fingerprint state_of_rasters(const worlds::WorldOptions& options) {
    const auto every_file = [](const fs::path& /*file*/) { return true; };
    std::vector<fs::path> files = list_rasters(options, every_file);
    if (!options.orthophotos.empty()) {
        const std::vector<fs::path> images = imagery::orthophoto_files(options.orthophotos);
        files.insert(files.end(), images.begin(), images.end());
    }
    voxel::ByteWriter out;
    for (const fs::path& file : files) {
        out.add(file.string());
        out.add(imagery::image_identity(file));
    }
    return out.fingerprint();
}

std::unique_ptr<voxel::World> open_heightmap(const OpenRequest& request) {
    const worlds::WorldOptions& from = request.options;
    heightmap::HeightmapOptions options;
    options.rasters = list_rasters(from, belongs_to_rasters);
    options.orthophotos = from.orthophotos;
    options.voxel_m = from.voxel_m;
    if (!from.crs.empty())
        options.crs = from.crs;
    options.height_unit_m = height_unit_m(from.vertical_unit);
    options.base_m = from.base_m;
    options.memory_bytes = from.memory_bytes;
    options.threads = thread::thread_count(from.threads);
    return heightmap::open_heightmap_world(options);
}

}  // namespace

constinit const WorldKind kHeightmapKind{
    .noun = "a raster of heights",
    .input = "a raster of heights",
    .recognises = is_raster_or_folder_of_them,
    .open = open_heightmap,
    .state = state_of_rasters,
    .flags = "--crs --voxel --vertical-unit --world-base-m",
    .takes_several = true,
    .takes_orthophotos = true,
};

}  // namespace terravox::worlds
