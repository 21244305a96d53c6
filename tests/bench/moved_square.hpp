#pragma once

#include <filesystem>

namespace terravox::bench {

/// Copies a LAS or LAZ file to another place: only the offsets and bounds in its header change, so
/// it costs a copy and decodes as the original. Does nothing where the copy is there already, with
/// the same size. @throws Error for a file that is no LAS or cannot be copied
void copy_moved(const std::filesystem::path& from, const std::filesystem::path& to, double east_m,
                double north_m);

}  // namespace terravox::bench
