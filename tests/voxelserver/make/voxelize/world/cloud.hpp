#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/stage_times.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/place.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"

namespace terravox::test {

inline std::int32_t voxel_x(double east) {
    return static_cast<std::int32_t>(std::floor(kEast0 + east));
}
inline std::int32_t voxel_z(double north) {
    return static_cast<std::int32_t>(std::floor(-(kNorth0 + north)));
}

/// A survey made up in a test: points by metres east and north of a corner.
class Cloud {
public:
    explicit Cloud(double east0 = kEast0, double north0 = kNorth0)
        : m_east0(east0), m_north0(north0) {}

    struct Point {
        double east;
        double north;
        double height;
        std::uint8_t source_class;
        std::array<std::uint16_t, 3> rgb{};
        std::uint16_t intensity = 0;
        std::uint16_t line = 0;  ///< of the flight
    };
    void add(const Point& point) { m_points.push_back(point); }
    void add(double east, double north, double height, int source_class,
             std::array<std::uint16_t, 3> rgb = {}) {
        m_points.push_back({east, north, height, static_cast<std::uint8_t>(source_class), rgb});
    }
    /// A point on every grid place of `step_m`, off the voxel borders, where `height_at` gives a
    /// height.
    template <class HeightAt>
    void cover(double east0, double north0, double east1, double north1, double step_m,
               int source_class, const HeightAt& height_at) {
        for (double n = north0 + step_m / 2; n < north1; n += step_m)
            for (double e = east0 + step_m / 2; e < east1; e += step_m)
                if (const double h = height_at(e, n); !std::isnan(h))
                    add(e, n, h, source_class);
    }
    [[nodiscard]] const std::vector<Point>& points() const noexcept { return m_points; }

    /// @param crs empty = none in the file; the points are written as they are
    void write(const std::filesystem::path& file, const std::string& crs = kCrs, int format = 6,
               const std::function<bool(const Point&)>& keep = {}) const {
        lidar::LasWriterOptions options;
        options.point_format = format;
        options.scale = {0.001, 0.001, 0.001};
        options.offset = {m_east0, m_north0, 0};
        if (!crs.empty())
            options.wkt = geo::Crs::from_text(crs).wkt();
        lidar::LasWriter writer(file, options);
        for (const Point& p : m_points) {
            if (keep && !keep(p))
                continue;
            lidar::LasWritePoint out;
            out.x = m_east0 + p.east;
            out.y = m_north0 + p.north;
            out.z = p.height;
            out.classification = p.source_class;
            out.rgb = p.rgb;
            out.intensity = p.intensity;
            out.point_source = p.line;
            writer.write(out);
        }
        writer.close();
    }

private:
    double m_east0;
    double m_north0;
    std::vector<Point> m_points;
};

/// A world with voxels by absolute coordinates.
class OpenWorld {
public:
    explicit OpenWorld(const voxelize::LidarWorldOptions& options)
        : m_world(voxelize::open_lidar_world(options, m_times)) {}
    explicit OpenWorld(const std::filesystem::path& input, const std::string& classes = "asprs")
        : OpenWorld(with(input, classes)) {}

    static voxelize::LidarWorldOptions with(const std::filesystem::path& input,
                                            const std::string& classes = "asprs") {
        voxelize::LidarWorldOptions options;
        options.files = {input};
        options.classes = classes;
        options.threads = 2;
        return options;
    }

    [[nodiscard]] std::optional<voxel::VoxelAttr> at(std::int32_t x, std::int32_t y,
                                                     std::int32_t z) {
        const voxel::BoxKey key{0, x >> 6, y >> 8, z >> 6};
        auto found = m_boxes.find(key);
        if (found == m_boxes.end())
            found = m_boxes.emplace(key, m_world->box(key)).first;
        return found->second ? found->second->voxel(x & 63, y & 255, z & 63) : std::nullopt;
    }
    [[nodiscard]] voxel::Material material(std::int32_t x, std::int32_t y, std::int32_t z) {
        const auto v = at(x, y, z);
        return v ? v->material : voxel::Material::kAir;
    }
    /// The highest voxel of a column that `wanted` accepts.
    template <class Wanted>
    [[nodiscard]] std::optional<std::int32_t> highest(std::int32_t x, std::int32_t z,
                                                      const Wanted& wanted) {
        for (std::int32_t y = info().bounds.max[1]; y >= info().bounds.min[1]; --y)
            if (const auto v = at(x, y, z); v && wanted(*v))
                return y;
        return std::nullopt;
    }
    [[nodiscard]] std::optional<std::int32_t> top(std::int32_t x, std::int32_t z) {
        return highest(x, z, [](const voxel::VoxelAttr&) { return true; });
    }
    [[nodiscard]] std::optional<voxel::VoxelAttr> top_voxel(std::int32_t x, std::int32_t z) {
        const auto y = top(x, z);
        return y ? at(x, *y, z) : std::nullopt;
    }
    [[nodiscard]] const voxel::WorldInfo& info() const { return m_world->info(); }
    [[nodiscard]] voxelize::LidarWorld& world() { return *m_world; }

private:
    util::StageTimes m_times;
    std::unique_ptr<voxelize::LidarWorld> m_world;
    std::map<voxel::BoxKey, std::shared_ptr<const voxel::Box>> m_boxes;
};

/// The keys of all boxes over a world's bounds, in a fixed order.
inline std::vector<voxel::BoxKey> all_keys(const voxel::WorldInfo& info, int level) {
    std::vector<voxel::BoxKey> out;
    const auto range = voxel::boxes_over(info.bounds, level);
    for (auto bx = range.min.bx; bx < range.max.bx; ++bx)
        for (auto by = range.min.by; by < range.max.by; ++by)
            for (auto bz = range.min.bz; bz < range.max.bz; ++bz)
                out.push_back({level, bx, by, bz});
    return out;
}

using Checksums = std::map<voxel::BoxKey, std::uint64_t>;

/// What all boxes of the given keys hold; 0 = air.
inline Checksums checksums(voxel::World& world, const std::vector<voxel::BoxKey>& keys) {
    Checksums out;
    for (const auto& key : keys) {
        const auto box = world.box(key);
        out[key] = box ? box->checksum() : 0;
    }
    return out;
}

}  // namespace terravox::test
