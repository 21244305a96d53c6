#include "tests/bench/accuracy/holdout.hpp"

#include <cmath>
#include <map>

#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/lidar/las_writer.hpp"

namespace terravox::bench {
namespace {

constexpr std::uint8_t kGroundClass = 2;

/// Ground heights by column, read from the world a patch at a time.
class GroundLookup {
public:
    explicit GroundLookup(voxelize::LidarWorld& world) : m_world(world) {}
    /// @return the ground of a column in voxels, NaN where it is not known
    double at(std::int32_t x, std::int32_t z) {
        const std::pair key{voxel::floor_div(x, voxel::kBoxSizeX),
                            voxel::floor_div(z, voxel::kBoxSizeZ)};
        auto patch = m_patches.find(key);
        if (patch == m_patches.end())
            patch = m_patches.emplace(key, m_world.ground_heights(key.first, key.second)).first;
        const std::int32_t dx = x - key.first * voxel::kBoxSizeX;
        const std::int32_t dz = z - key.second * voxel::kBoxSizeZ;
        return patch->second[static_cast<std::size_t>(dz * voxel::kBoxSizeX + dx)];
    }

private:
    voxelize::LidarWorld& m_world;
    std::map<std::pair<std::int32_t, std::int32_t>, std::vector<float>> m_patches;
};

}  // namespace

std::vector<HeldOut> hold_out_ground(const std::vector<std::filesystem::path>& files,
                                     const std::filesystem::path& folder, int nth) {
    std::vector<HeldOut> out;
    std::uint64_t ground = 0;
    for (const auto& file : files) {
        const lidar::LasInfo info = lidar::read_las_info(file);
        lidar::LasWriterOptions options;
        options.point_format = info.has_colour() ? 7 : 6;  // those hold every class
        options.scale = info.scale;
        options.offset = info.offset;
        lidar::LasWriter writer(folder / file.filename(), options);
        lidar::read_las_points(info, {0, info.point_count}, [&](const pointcloud::Point& p) {
            if (p.classification == kGroundClass &&
                ++ground % static_cast<std::uint64_t>(nth) == 0) {
                out.push_back({p.x, p.y, p.z});
                return;
            }
            lidar::LasWritePoint kept;
            kept.x = p.x;
            kept.y = p.y;
            kept.z = p.z;
            kept.classification = p.classification;
            kept.rgb = p.rgb;
            kept.return_number = std::max<std::uint8_t>(1, p.return_number);
            kept.return_count = std::max(kept.return_number, p.return_count);
            writer.write(kept);
        });
        writer.close();
    }
    return out;
}

Errors predict_held_out(voxelize::LidarWorld& world, const std::vector<HeldOut>& points,
                        std::size_t& without) {
    const double units = world.info().crs_units_per_voxel;
    const double voxel_m = world.info().voxel_m;
    GroundLookup ground(world);
    Errors out;
    without = 0;
    for (const HeldOut& point : points) {
        const double x = point.x / units - 0.5,
                     z = -point.y / units - 0.5;  // centres of columns at whole numbers
        const auto column = static_cast<std::int32_t>(std::floor(x));
        const auto row = static_cast<std::int32_t>(std::floor(z));
        const double fx = x - column;
        const double fz = z - row;
        const double north = std::lerp(ground.at(column, row), ground.at(column + 1, row), fx);
        const double south =
            std::lerp(ground.at(column, row + 1), ground.at(column + 1, row + 1), fx);
        const double height_m = std::lerp(north, south, fz) * voxel_m;
        if (std::isnan(height_m))
            ++without;
        else
            out.add(height_m - point.height_m);
    }
    return out;
}

}  // namespace terravox::bench
