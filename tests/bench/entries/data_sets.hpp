#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "tests/bench/bench.hpp"
#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"

namespace terravox::bench {

/// Survey files of the shared test data that several entries use.
struct DataSet {
    std::string id;
    std::string facts;
    std::vector<std::string> files;        ///< relative to the shared test data
    std::vector<std::string> orthophotos;  ///< the same
    std::string crs, classes;              ///< what the files do not state; empty: they do
    double voxel_m = 1;

    [[nodiscard]] std::vector<std::filesystem::path> paths(const Context& context) const;
    [[nodiscard]] std::vector<std::filesystem::path> orthophoto_paths(const Context& context) const;
    /// Why the set cannot be used; empty when all its files are there.
    [[nodiscard]] std::string missing(const Context& context) const;
};

[[nodiscard]] const DataSet& delft();        ///< two files of a Dutch town
[[nodiscard]] const DataSet& montpellier();  ///< six 50 m squares, one with an orthophoto
[[nodiscard]] const DataSet& square();       ///< one full square of 1 km

/// Bare LASzip decoding of some files: no use of them can be faster.
class DecodeFloor {
public:
    /// Reads the headers. @throws Error
    explicit DecodeFloor(const std::vector<std::filesystem::path>& files);
    [[nodiscard]] std::uint64_t points() const noexcept { return m_points; }
    /// Decodes everything and drops it; ranges of all files are shared out among the threads.
    /// @return wall seconds @throws Error
    [[nodiscard]] double seconds(int threads) const;

private:
    struct Piece {
        std::size_t file;
        lidar::PointRange range;
    };
    std::vector<lidar::LasInfo> m_files;
    std::vector<Piece> m_pieces;
    std::uint64_t m_points = 0;
};

/// A world with the clocks that it writes to.
struct OpenWorld {
    std::unique_ptr<util::StageTimes> times;
    std::unique_ptr<voxelize::LidarWorld> world;
};
[[nodiscard]] OpenWorld open_data_set(const DataSet& set, const Context& context, int threads);

/// The level-0 boxes that may hold anything, column by column.
[[nodiscard]] std::vector<voxel::BoxKey> box_keys(voxel::World& world);

}  // namespace terravox::bench
