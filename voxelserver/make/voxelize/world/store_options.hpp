#pragma once

#include "voxelserver/data/store/grabber_store.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"

namespace terravox::voxelize {

/// Takes from a store its files with the CRS of each, and where the user named none, the class
/// table, orthophotos and a title, of the source or of the store; all distinct licences and
/// attributions of what is taken, one after the other.
/// @param options of a world without files
/// @throws UsageError when the store has no square yet, or squares of several class tables
void take_from_store(const store::GrabberStore& store, LidarWorldOptions& options);

}  // namespace terravox::voxelize
