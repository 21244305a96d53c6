#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "voxelserver/export/core/job.hpp"

namespace terravox::exports {

/// The voxel whose lowest north-western corner is the origin of a shape's file: the middle of the
/// part, at its bottom. Numbers stay small there (32-bit floats), and the shape stands on the grid
/// of whatever opens it.
[[nodiscard]] std::array<std::int32_t, 3> origin_of(const Part& part) noexcept;

/// What a file says of the world it was made from, in a fixed order; empty things are left out. For
/// formats with room for such.
/// @param axes what the axes of the file are, in words
[[nodiscard]] std::vector<std::pair<std::string, std::string>> facts_of(const Job& job,
                                                                        const std::string& axes);

/// Commits a file and its side-car FILE.georef.json, both or, on a full disk, neither, and tells
/// the job. The side-car counts x east, y up, z south, as everywhere: of a file with z up, x = X, y
/// = Z, z = -Y. @throws Error
void finish_file(Job& job, util::AtomicFile& file);

/// For a part without a single voxel to write. @throws Error, always
[[noreturn]] void fail_for_nothing(const Job& job);

}  // namespace terravox::exports
