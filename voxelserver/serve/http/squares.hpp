#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::http {

/// A LiDAR square as shown by the HTTP interface.
struct SquareEntry {
    std::string name, state;  ///< "wanted", "fetched", "prepared", "failed"
    std::optional<std::string> file;
    std::optional<std::string> error;
    std::optional<std::uint64_t> points;
    std::uint64_t bytes = 0;
    std::string source;
    std::string licence;
    std::string attribution;
    std::int32_t min_x = 0, min_z = 0, max_x = 0, max_z = 0;  ///< voxels of level 0, half-open
};

/// Called for each reply: must be cheap and thread-safe.
using SquaresNow = std::function<std::vector<SquareEntry>()>;

/// GeoJSON in the world's own CRS (named in the member `crs`), not in degrees, because the page
/// shows the world in that CRS.
[[nodiscard]] std::string squares_json(const std::vector<SquareEntry>& squares,
                                       const voxel::WorldInfo& info);

}  // namespace terravox::http
