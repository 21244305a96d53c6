#include "voxelserver/serve/module/load_module.hpp"

#include <string>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"

extern "C" terravox::module::OpenLidarWorld terravox_open_lidar_world;
extern "C" terravox::module::OpenServedWorld terravox_open_served_world;
extern "C" terravox::module::PlaceExtents terravox_place_extents;

namespace {

void check_version(const char* version) {
    if (std::string(version) == terravox::kVersion)
        return;
    throw terravox::util::Error(std::string("use the worlds module: it is of version ") +
                                terravox::kVersion + "; allowed: that of the program, " + version);
}

}  // namespace

terravox::voxelize::LidarWorld* terravox_open_lidar_world(
    const char* version, const terravox::voxelize::LidarWorldOptions& options,
    terravox::util::StageTimes& times, std::int64_t image_bytes) {
    check_version(version);
    terravox::geo::limit_gdal_cache(image_bytes);
    return terravox::voxelize::open_lidar_world(options, times).release();
}

terravox::worlds::ServedWorld* terravox_open_served_world(
    const char* version, const terravox::worlds::ServeRequest& request,
    terravox::util::StageTimes& times, const std::stop_token& stop, std::int64_t image_bytes) {
    check_version(version);
    terravox::geo::limit_gdal_cache(image_bytes);
    return terravox::worlds::open_served_world(request, times, stop).release();
}

void terravox_place_extents(const char* version, const std::string& from, const std::string& to_wkt,
                            std::span<std::optional<std::array<double, 4>>> extents) {
    check_version(version);
    const auto source = terravox::geo::Crs::from_text(from);
    const auto target = terravox::geo::Crs::from_wkt(to_wkt);
    if (source.same_horizontal(target))
        return;
    const terravox::geo::Transform transform(source, target);
    for (auto& extent : extents) {
        try {
            if (extent)
                extent = transform.around(*extent);
        } catch (const terravox::util::Error&) {
            extent.reset();
        }
    }
}
