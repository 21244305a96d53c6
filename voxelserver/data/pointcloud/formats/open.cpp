#include "voxelserver/data/pointcloud/formats/open.hpp"

#include <array>

#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/data/pointcloud/formats/list.hpp"

namespace terravox::pointcloud {
namespace {

using Open = std::unique_ptr<const PointSource> (*)(const std::filesystem::path& path);

template <PointFormat... Each>
constexpr std::array<Open, sizeof...(Each)> openers_of(const std::tuple<Each...>& /*formats*/) {
    return {Each::open...};
}

constexpr auto kOpeners = openers_of(Formats());

}  // namespace

std::unique_ptr<const PointSource> open_point_source(const std::filesystem::path& file) {
    return kOpeners[format_of(file)](file);
}

}  // namespace terravox::pointcloud
