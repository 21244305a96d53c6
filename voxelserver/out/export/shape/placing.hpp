#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

/// The voxel whose lowest north-western corner is the origin of a shape's file: the middle of the
/// part, at its bottom. Coordinates stay small there (32-bit floats), and the shape stands on the
/// ground grid of the program that opens it.
[[nodiscard]] std::array<std::int32_t, 3> origin_of(const Part& part) noexcept;

/// Metadata of the source world, in a fixed order, for formats that can store it; empty values are
/// left out.
/// @param axes describes the axes of the file
[[nodiscard]] std::vector<std::pair<std::string, std::string>> facts_of(const Job& job,
                                                                        const std::string& axes);

/// Commits a file and its side-car FILE.georef.json, both or, on a full disk, neither, and reports
/// the file to the job. The side-car uses x east, y up, z south, as everywhere: of a file with z
/// up, x = X, y = Z, z = -Y.
/// @throws Error
void finish_file(Job& job, util::AtomicFile& file);

/// For a part without a single voxel to write.
/// @throws Error, always
[[noreturn]] void fail_for_nothing(const Job& job);

}  // namespace terravox::exports
