#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/out/country/plan.hpp"

namespace terravox::country {

/// Where the archive of a plan goes, as `country run` has noted it before it began: so that a later
/// call can tell an archive that is finished from one that was there before.
struct Target {
    std::string plan;  ///< Plan::id()
    std::filesystem::path archive;
    std::string before;  ///< state of the file when the run began; empty: there was none
    std::string after;   ///< the same of the finished one; empty: not known
    /// Of an archive that is being patched: Plan::id() of the data that it had; else empty.
    std::string patched;
    /// The archive has been patched since its shards were joined: what it lacks stands in the
    /// archive, not in the shards.
    bool is_patched = false;
};
void write_target(const PlanFolder& folder, const Target& target);
/// @return nullopt when there is none, or it is damaged
[[nodiscard]] std::optional<Target> read_target(const PlanFolder& folder);

/// Help of the option that names it.
inline constexpr const char* kConfirmedArchive =
    "the archive of the plan's last run, which has to be named where it lies neither in the plan's "
    "folder nor beside it";
/// Where a run or a patch goes on to write. A plan may be a stranger's, and its run.json then names
/// any file of this user: what lies neither in the plan's folder nor beside it, or is not named
/// like a box archive, has to be named again.
/// @param named by the user; empty: nothing
/// @param attempt begins messages
/// @return Target::archive
/// @throws UsageError when it has to be named, or another one is
[[nodiscard]] std::filesystem::path confirmed_archive(const PlanFolder& folder,
                                                      const Target& target,
                                                      const std::filesystem::path& named,
                                                      const std::string& attempt);

/// Size, time and number of a file; empty: there is none.
[[nodiscard]] std::string state_of_file(const std::filesystem::path& file);

/// Whether the archive of the plan is finished under this name.
/// @param archive absolute
[[nodiscard]] bool is_joined(const PlanFolder& folder, const Plan& plan,
                             const std::filesystem::path& archive);

/// The finished archive of a plan where it was patched since its shards were joined; else nullopt.
[[nodiscard]] std::optional<std::filesystem::path> patched_archive(const PlanFolder& folder,
                                                                   const Plan& plan);

/// What an archive lacks.
struct JoinReport {
    std::uint64_t boxes = 0;
    std::uint64_t holes = 0;           ///< boxes, of the finest level
    std::vector<std::string> reasons;  ///< of holes and damage, a line each, the first some
    std::uint64_t damage = 0;
    [[nodiscard]] bool is_whole() const noexcept { return holes == 0 && damage == 0; }
};
/// What the finished archive of a plan lacks: as its shards say, or itself where it was patched
/// since.
/// @throws Error when an archive that was patched cannot be read
[[nodiscard]] JoinReport make_report(const PlanFolder& folder, const Plan& plan);

/// Joins the shards to the archive, and notes that it is done. The shards stay.
/// @param threads 0: one for each core
/// @param progress called with bytes done and all of them; may throw, which ends it
/// @throws Error when a shard is missing or damaged, or the archive cannot be written
JoinReport join(const PlanFolder& folder, const Plan& plan, const std::filesystem::path& archive,
                int threads, const std::function<void(std::uint64_t, std::uint64_t)>& progress);

}  // namespace terravox::country
