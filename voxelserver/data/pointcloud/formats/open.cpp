#include "voxelserver/data/pointcloud/formats/open.hpp"

#include <array>

#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/data/pointcloud/formats/list.hpp"

namespace terravox::pointcloud {
namespace {

using Open = std::unique_ptr<const PointSource> (*)(const std::filesystem::path& path);

template <PointFormat... Each>
constexpr std::array<Open, sizeof...(Each)> list_openers(const std::tuple<Each...>& /*formats*/) {
    return {Each::open...};
}

constexpr auto kOpeners = list_openers(Formats());

}  // namespace

std::unique_ptr<const PointSource> open_point_source(const std::filesystem::path& file) {
    return kOpeners[find_format_by(file)](file);
}

const PointSource& DeferredSource::opened() const {
    const std::lock_guard lock(m_mutex);
    if (m_opened == nullptr)
        m_opened = open_point_source(info().path);
    return *m_opened;
}

std::vector<PointRange> DeferredSource::parts(std::uint64_t points) const {
    return opened().parts(points);
}

void DeferredSource::read(std::span<const PointRange> ranges, const PointBatchSink& sink) const {
    opened().read(ranges, sink);
}

void DeferredSource::read_without_echoes(std::span<const PointRange> ranges,
                                         const PointBatchSink& sink) const {
    opened().read_without_echoes(ranges, sink);
}

std::vector<Point> DeferredSource::sample(std::size_t about) const {
    return opened().sample(about);
}

bool DeferredSource::sampled_all_over() const {
    return opened().sampled_all_over();
}

std::shared_ptr<const SpatialIndex> DeferredSource::spatial_index() const {
    return opened().spatial_index();
}

}  // namespace terravox::pointcloud
