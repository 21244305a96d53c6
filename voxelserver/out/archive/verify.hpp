#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/voxel/archive/archive_reader.hpp"
#include "voxelserver/out/archive/archive_files.hpp"

namespace terravox::archive_tools {

/// What was found wrong, and what was looked at.
struct Verification {
    std::uint64_t boxes = 0;
    std::uint64_t holes = 0;
    std::uint64_t problems = 0;
    std::vector<std::string> first_problems;  ///< the first kShownProblems, a line each
    static constexpr std::size_t kShownProblems = 20;
    void note(const std::string& problem);
};

/// Called now and then with the records that were verified, and all that there are.
using VerifyProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// Reads all of an archive, or of a shard or change: that every part of the index, every record and
/// every box has the bytes that its checksum says, lies where the index says, and is a valid box;
/// that each coarse box is what its eight children give, is a hole where one of them is, and is
/// there where they hold anything; and that the file has no bytes that nothing names.
///
/// Each box is unpacked once. Memory: 32 bytes for every eight boxes, and some boxes for each
/// thread.
/// @param threads 0: one for each core
/// @throws Error where nothing can be verified: no archive, an unfinished one, or one whose header
/// or root of the index is damaged; ChangedError when another program writes to it meanwhile
[[nodiscard]] Verification verify(const ArchiveFiles& archive, int threads = 0,
                                  const VerifyProgress& progress = {});

/// The same without unpacking boxes: what is stored is what was written, but whether that was right
/// is not looked at. Reads stretches of the index one after the other, and what each names in the
/// order of the file. Memory: 32 MiB, and 16 MiB for each thread.
[[nodiscard]] Verification verify_stored(const ArchiveFiles& archive, int threads = 0,
                                         const VerifyProgress& progress = {});
/// As verify_stored(), for an archive that is open.
/// @param bytes of its files
/// @param stretch of the index that is in memory at a time, boxes
[[nodiscard]] Verification verify_open(voxel::archive::ByteSource& archive, std::uint64_t bytes,
                                       int threads = 0, const VerifyProgress& progress = {},
                                       std::size_t stretch = std::size_t{1} << 20);

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
