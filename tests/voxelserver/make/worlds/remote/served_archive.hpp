#pragma once

#include <algorithm>
#include <iterator>
#include <string>

#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/remote/served_boxes.hpp"

namespace terravox::test {

inline constexpr int kArchiveBoxes = 300;

/// An archive of the boxes (i, 0, 0), i from 0 to kArchiveBoxes - 1: much longer than what opening
/// reads.
inline const std::string& archive_bytes() {
    static const std::string bytes = [] {
        const TemporaryFolder folder;
        voxel::WorldInfo info;
        info.title = "far";
        info.bounds = {{0, 0, 0}, {64 * kArchiveBoxes, 512, 64}};
        info.levels = voxel::levels_for(info.bounds);
        voxel::ArchiveWriter writer(folder.path() / "a.tvx", info, 0);
        for (int i = 0; i < kArchiveBoxes; ++i)
            writer.add({0, i, 0, 0}, voxel::archive::Kind::kBox,
                       voxel::compress(*to_box({0, i, 0, 0})));
        writer.finish();
        return read_content(folder.path() / "a.tvx");
    }();
    return bytes;
}

/// @param range "FIRST-LAST"
inline Deed part_of_archive(const std::string& range) {
    const auto dash = range.find('-');
    const std::size_t first = std::stoull(range.substr(0, dash));
    const std::size_t last =
        std::min<std::size_t>(std::stoull(range.substr(dash + 1)), archive_bytes().size() - 1);
    return {.status = 206,
            .type = "application/octet-stream",
            .body = archive_bytes().substr(first, last - first + 1)};
}

}  // namespace terravox::test
