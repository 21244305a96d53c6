#pragma once

#include <string>

#include "voxelserver/store/grabber_store.hpp"
#include "voxelserver/voxelize/points/options.hpp"

namespace terravox::voxelize {

/// Takes files, class table and CRS from a store, where the user named none.
/// @param options of a world without files
/// @throws UsageError when the store has no square yet, or squares of several class tables or CRSs
void take_from_store(const store::GrabberStore& store, LidarWorldOptions& options);

/// All distinct licences (attributions) of the squares, one after the other.
struct Terms {
    std::string licence;
    std::string attribution;
};
[[nodiscard]] Terms terms_of(const store::GrabberStore& store);

}  // namespace terravox::voxelize
