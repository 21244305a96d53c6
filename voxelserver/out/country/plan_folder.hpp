#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "voxelserver/out/country/plan.hpp"

namespace terravox::country {

/// The folder of a plan: plan.json, and what its tasks leave there (docs/formats/country-plan.md).
/// A path and nothing more; const functions do not look at the disk.
class PlanFolder {
public:
    /// @param folder that exists
    /// @throws UsageError when it does not, or its scratch() is a link
    explicit PlanFolder(const std::filesystem::path& folder);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] std::filesystem::path plan() const { return m_path / "plan.json"; }
    /// What opening has found of the squares, so that tasks need not read all of them
    /// (voxelize/points/known_squares.hpp). Without it they do.
    [[nodiscard]] std::filesystem::path known_squares() const { return m_path / "squares.known"; }
    /// Which points of the squares lie where, so that a patch reads parts of them alone.
    [[nodiscard]] std::filesystem::path chunks() const { return m_path / "chunks"; }
    /// Facts of the last `country run`: where its archive goes.
    [[nodiscard]] std::filesystem::path run() const { return m_path / "run.json"; }
    [[nodiscard]] std::filesystem::path run_lock() const { return m_path / "run.lock"; }
    [[nodiscard]] std::filesystem::path scratch() const { return m_path / "scratch"; }

    /// @param number of a shard, 1 to the number of shards
    [[nodiscard]] std::filesystem::path shard(int number) const;
    [[nodiscard]] std::filesystem::path lock(int number) const;
    [[nodiscard]] std::filesystem::path record(int number) const;  ///< how the task ended
    [[nodiscard]] std::filesystem::path log(int number) const;     ///< what it said

    /// Makes the folders for all of these.
    /// @throws Error
    void make_folders() const;

private:
    [[nodiscard]] std::filesystem::path of_task(int number, const char* ending) const;
    std::filesystem::path m_path;  ///< absolute, without links
};

/// Names the bytes of PlanFolder::known_squares(): 32 hexadecimal digits.
[[nodiscard]] std::string fingerprint_of_known(std::string_view bytes);
/// Whether the facts that are there are those of the plan (Plan::known_squares).
[[nodiscard]] bool has_known_squares_of(const PlanFolder& folder, const Plan& plan);

/// Writes plan.json, whole or not at all. Paths of the plan that were given relative to the current
/// folder are written relative to the plan's, so that both can be moved together, or mounted
/// elsewhere.
/// @throws Error
void write_plan(const PlanFolder& folder, const Plan& plan);

/// @throws UsageError when there is no plan; Error when it is damaged, of another version of the
/// format, or holds values that no plan has
[[nodiscard]] Plan read_plan(const PlanFolder& folder);

}  // namespace terravox::country
