#include "voxelserver/make/voxelize/world/world_name.hpp"

#include <gdal_version.h>

#include <algorithm>

#include "common/voxel/bytes.hpp"
#include "common/voxel/file_identity.hpp"
#include "voxelserver/data/imagery/image_identity.hpp"
#include "voxelserver/data/imagery/orthophoto_files.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/lidar_files.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/points/world_title.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"

namespace terravox::voxelize {

std::string world_name(const LidarWorldOptions& options, const std::filesystem::path& opener) {
    voxel::ByteWriter out;
    out.add(kFactsMagic);
    out.add(kBoxRecipe);
    out.add(std::string_view(GDAL_RELEASE_NAME));
    if (!opener.empty())
        out.add(voxel::file_identity(opener, "worlds module"));
    const Settings settings = load_settings(options.settings, options.steps, options.photo);
    const ClassTable classes = load_class_table(options.classes);
    out.add(fingerprint_of(settings));
    out.add(palette_fingerprint(settings));
    out.add(tints_fingerprint(settings));
    out.add(fingerprint_of(classes));
    out.add(classes.crs.has_value());
    out.add(classes.crs.value_or(""));
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
        if (const auto side_file = pointcloud::side_file_of(file))
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
    return voxel::hex_of(out.fingerprint());
}

}  // namespace terravox::voxelize
