#pragma once

#include <filesystem>
#include <memory>
#include <mutex>

#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::pointcloud {

/// Opens a file of any format in the list (list.hpp).
/// @throws Error when it is missing, of no known format, or damaged
[[nodiscard]] std::unique_ptr<const PointSource> open_point_source(
    const std::filesystem::path& file);

/// A point file whose metadata are known already: it is opened when it is first asked for anything
/// else. All functions throw what open_point_source() throws, each time that opening fails.
class DeferredSource final : public PointSource {
public:
    /// @param info of the file, as an opened source has it
    explicit DeferredSource(PointCloudInfo info) : PointSource(std::move(info)) {}

    [[nodiscard]] std::vector<PointRange> parts(std::uint64_t points) const override;
    void read(std::span<const PointRange> ranges, const PointBatchSink& sink) const override;
    void read_without_echoes(std::span<const PointRange> ranges,
                             const PointBatchSink& sink) const override;
    [[nodiscard]] std::vector<Point> sample(std::size_t about) const override;
    [[nodiscard]] bool sampled_all_over() const override;
    [[nodiscard]] std::shared_ptr<const SpatialIndex> spatial_index() const override;

private:
    [[nodiscard]] const PointSource& opened() const;

    mutable std::mutex m_mutex;  ///< guards that only one thread opens the file
    mutable std::unique_ptr<const PointSource> m_opened;
};

}  // namespace terravox::pointcloud
