#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/voxel/archive/byte_source.hpp"

namespace terravox::archive_tools {

/// A file that holds a stretch of the bytes of an archive. The parts one after the other are the
/// archive.
struct FilePart {
    std::string name;  ///< without folder
    std::uint64_t bytes = 0;
};

/// NAME-0001.part: as many digits as the last of them needs, and at least four, so that names sort
/// by number.
/// @param number from 1
/// @param of how many there are
[[nodiscard]] std::string part_name(const std::string& stem, std::size_t number, std::size_t of);

/// Copies a stretch of an archive to the end of a file.
/// @throws Error when it cannot be read or written
void append_stretch(voxel::archive::ByteSource& archive, std::uint64_t begin, std::uint64_t bytes,
                    util::AtomicFile& to);

/// Cuts an archive into parts of at most so many bytes, NAME-0001.part and following, where NAME is
/// its name without ending: for hosts that limit files. The file stays. The parts appear under
/// their names once all of them are written.
/// @param folder of the parts
/// @param max_bytes above 0
/// @return the parts; the file itself, and nothing is written, where it is small enough
/// @throws Error when it is no archive, but a shard or a change of one, say, or cannot be read, or
/// a part cannot be written; ChangedError when another program writes to it meanwhile
[[nodiscard]] std::vector<FilePart> split(const std::filesystem::path& file,
                                          const std::filesystem::path& folder,
                                          std::uint64_t max_bytes);

/// The same for an archive that is open.
/// @param bytes of the archive
/// @param stem of the names of parts
[[nodiscard]] std::vector<FilePart> write_parts(voxel::archive::ByteSource& archive,
                                                std::uint64_t bytes, const std::string& stem,
                                                const std::filesystem::path& folder,
                                                std::uint64_t max_bytes);

/// Whether a file has such a name.
[[nodiscard]] bool is_part(const std::string& name, const std::string& stem);

/// Files in a folder that have the names of parts of an archive, by number.
[[nodiscard]] std::vector<std::filesystem::path> parts_in(const std::filesystem::path& folder,
                                                          const std::string& stem);

/// Files by number, where all of them are named like parts of one archive; else as they are.
[[nodiscard]] std::vector<std::filesystem::path> in_order_of_numbers(
    std::vector<std::filesystem::path> files);

}  // namespace terravox::archive_tools
