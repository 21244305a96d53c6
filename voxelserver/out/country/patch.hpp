#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "voxelserver/out/archive/patch.hpp"
#include "voxelserver/out/country/plan.hpp"

namespace terravox::country {

struct PatchOptions {
    std::filesystem::path archive;  ///< as the user named it: confirmed_archive(); empty: not
    int threads = 0;                ///< 0: one for each core
    /// As WorldOptions::memory_bytes. A square reads parts of eight others, some 250 MB for 7
    /// million points each; what does not fit is decoded more than once.
    std::size_t memory_bytes = std::size_t{2} << 30;
    bool quiet = false;
    std::stop_token stop;
    /// Called once with the changes, a line each, before anything is made of them.
    std::function<void(const std::vector<std::string>&)> on_changes;
};

/// What one call did.
struct PatchOutcome {
    std::filesystem::path archive;
    std::vector<std::string> changes;  ///< of squares, a line each; empty: nothing was done
    archive_tools::PatchReport report;
    std::vector<std::string> damage;     ///< of the data, as far as was met, a line each
    std::vector<MissingSquare> missing;  ///< of the plan, as it is now
};

/// Brings the archive of a plan up to date with its data: finds the squares that have changed, are
/// new or are gone since the plan was made, makes the boxes that depend on them, and puts these
/// into the archive, which has the bytes of a conversion anew then. The plan becomes one of the
/// data as they are. Killed at any time, the archive is the old or the new one, and the next call
/// goes on.
/// @throws UsageError when no archive of the plan is finished, or where it is has to be confirmed;
/// Error when another process runs the plan, another program made it, photographs have changed, a
/// square cannot be read, a square is gone of which the plan does not know where it lay, or the
/// archive cannot be written
PatchOutcome patch_country(const PlanFolder& folder, const PatchOptions& options);

}  // namespace terravox::country
