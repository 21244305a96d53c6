#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/voxel/archive/archive_index.hpp"
#include "voxelserver/out/archive/verify.hpp"

namespace terravox::archive_tools {

/// What an index names.
struct WalkedIndex {
    std::uint64_t records = 0;
    std::uint64_t bytes = 0;  ///< of records and leaves
    bool is_readable = true;  ///< the whole index
};

/// Reads all leaves; notes those that are damaged.
/// @param visit called with the number and the entries of each leaf that is whole, in order
/// @throws ChangedError
WalkedIndex walk_index(
    const voxel::archive::ArchiveIndex& index, Verification& out,
    const std::function<void(std::size_t leaf, const std::vector<voxel::archive::Entry>&)>& visit);

/// Compares the size of the file with what its header and its index name, and reads the end of a
/// shard or a change; notes what is wrong.
/// @throws ChangedError
void check_size(voxel::archive::ByteSource& source, const voxel::archive::ArchiveIndex& index,
                const WalkedIndex& walked, std::uint64_t file_bytes, Verification& out);

}  // namespace terravox::archive_tools
