#include "voxelserver/out/country/patch.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "voxelserver/make/voxelize/world/dependent_columns.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"
#include "voxelserver/out/country/inputs.hpp"
#include "voxelserver/out/country/join.hpp"
#include "voxelserver/out/country/plan.hpp"
#include "voxelserver/out/country/workload.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::country {
namespace {

namespace fs = std::filesystem;
using Kind = FileChange::Kind;

std::vector<exports::ColumnAt> columns_at(const std::vector<grid::PatchKey>& patches) {
    std::vector<exports::ColumnAt> out;
    for (const grid::PatchKey& at : patches)
        out.push_back({at.px, at.pz});
    return out;
}

/// The caller has the lock of the plan.
class CountryPatch {
public:
    CountryPatch(const PlanFolder& folder, const PatchOptions& options)
        : m_folder(folder), m_options(options), m_old(read_plan(folder)), m_plan(m_old) {}

    PatchOutcome run() {
        check_program(m_old, attempt());
        find_archive();
        find_changes();
        if (m_outcome.changes.empty()) {
            if (!m_interrupted_id.empty())
                refuse_other_data();
            leave_as_it_is();
            return std::move(m_outcome);
        }
        if (m_options.on_changes)
            m_options.on_changes(m_outcome.changes);
        make_and_put_in();
        m_outcome.missing = m_plan.missing;
        return std::move(m_outcome);
    }

private:
    [[nodiscard]] std::string attempt() const {
        return "patch the country of " + m_folder.path().string();
    }

    void find_archive() {
        const std::optional<Target> target = read_target(m_folder);
        if (target)
            (void)confirmed_archive(m_folder, *target, m_options.archive, attempt());
        m_goes_on = target && target->patched == m_old.id();
        if (!m_goes_on && (!target || !is_joined(m_folder, m_old, target->archive)))
            throw util::UsageError(attempt() +
                                   ": its archive is not finished, or is another one than its run "
                                   "has written; allowed: after terravox country run, which says "
                                   "where it goes");
        m_outcome.archive = target->archive;
        m_target = *target;
        if (m_goes_on && state_of_file(target->archive) != target->before)
            m_interrupted_id = target->plan;
    }

    /// No square has changed. What the archive lacks is said again, as by country run.
    void leave_as_it_is() {
        if (m_goes_on)  // a patch had begun, and its data were taken back
            write_target(m_folder, {m_old.id(), m_target.archive, "", m_target.before, "", true});
        const JoinReport lacks = make_report(m_folder, m_old);
        m_outcome.report.holes = lacks.holes;
        m_outcome.damage = lacks.reasons;
        m_outcome.missing = m_old.missing;
    }

    /// The archive has the data of a patch that was interrupted at its end: only these can go on.
    [[noreturn]] void refuse_other_data() const {
        throw util::Error(attempt() +
                          ": a patch was interrupted, and the data have changed again since; plan "
                          "again");
    }

    void find_changes() {
        // What could not be read then may be there now.
        m_plan.world.left_out.clear();
        const InputChanges changes = compare_inputs(m_old, m_plan.world);
        if (!changes.images.empty())
            throw util::Error(attempt() + ": " + to_text(changes.images.front()) +
                              "; squares can be patched, photographs cannot: plan again");
        std::map<fs::path, PlannedFile> planned;
        for (const PlannedFile& file : m_old.squares)
            planned.emplace(file.file.lexically_normal(), file);
        for (const FileChange& change : changes.squares) {
            if (change.kind != Kind::kNew)
                m_before.push_back({change.file.lexically_normal(), identity_then(change.file)});
            if (change.kind == Kind::kGone) {
                planned.erase(change.file.lexically_normal());
            } else if (!take(change, planned)) {
                continue;
            }
            m_outcome.changes.push_back(to_text(change));
        }
        m_plan.squares.clear();
        for (auto& [path, file] : planned)
            m_plan.squares.push_back(std::move(file));
        if (m_plan.squares.empty())
            throw util::Error(attempt() + ": all of its squares are gone; plan again");
    }

    /// @return false when the file was left out and still has to be
    bool take(const FileChange& change, std::map<fs::path, PlannedFile>& planned) {
        PlannedFile file{change.file, 0, 0, ""};
        const std::string reason = look_at(file);
        const auto& left_out = m_old.world.left_out;
        if (!reason.empty()) {
            if (std::find(left_out.begin(), left_out.end(), change.file) == left_out.end())
                throw util::Error(attempt() + ": " + reason + "; the archive stays as it is");
            m_plan.world.left_out.push_back(change.file);
            return false;
        }
        planned[change.file.lexically_normal()] = file;
        m_taken.insert(change.file.lexically_normal());
        std::erase_if(m_plan.missing, [&](const MissingSquare& square) {
            return square.name == change.file.stem().string();
        });
        return true;
    }

    /// The identity that a square of the plan had.
    [[nodiscard]] std::string identity_then(const fs::path& file) const {
        const auto found = std::find_if(
            m_old.squares.begin(), m_old.squares.end(), [&](const PlannedFile& square) {
                return square.file.lexically_normal() == file.lexically_normal();
            });
        return found == m_old.squares.end() ? std::string() : found->identity;
    }

    void make_and_put_in() {
        worlds::WorldOptions options = m_plan.world;
        options.threads = m_options.threads;
        options.memory_bytes = m_options.memory_bytes;
        options.known_squares = m_folder.known_squares();
        options.chunk_indices = m_folder.chunks();
        options.reads_chunk_indices = true;
        const ScratchFolder scratch(m_folder.scratch() / "patch");
        const fs::path change = scratch.path() / "change.tvx";
        std::error_code failed;
        fs::create_directories(scratch.path(), failed);
        if (failed)
            throw util::Error(attempt() + ": make the folder " + scratch.path().string() + ": " +
                              failed.message());
        std::string known;
        {
            OpenedCountry country(options, m_plan.selection());
            check_all_boxes(country);
            m_plan.fingerprint = country.fingerprint();
            m_plan.bounds = country.part().bounds;
            if (!m_interrupted_id.empty() && m_plan.id() != m_interrupted_id)
                refuse_other_data();
            known = country.world().known_squares(identities_before());
            m_plan.known_squares = fingerprint_of_known(known);
            write_change(country, change);
        }
        // What changes while it is read must not become part of an archive.
        if (const auto changes = changes_since(m_plan); !changes.empty())
            throw util::Error(attempt() + ": the data changed meanwhile: " + changes.front() +
                              "; the archive stays as it is");
        check_stop();
        put_in(change);
        // Facts of the data before, which the plan that is still there names, are all that a call
        // after an interruption up to here needs.
        util::write_file_atomically(m_folder.known_squares(), known, util::Links::kReplace);
        write_plan(m_folder, m_plan);
        const fs::path& archive = m_outcome.archive;
        write_target(m_folder, {m_plan.id(), archive, "", state_of_file(archive), "", true});
    }

    void put_in(const fs::path& change) {
        const fs::path& archive = m_outcome.archive;
        const std::string now = state_of_file(archive);
        // Of an archive that an interrupted patch has put there, the old state stays noted: a call
        // that ends here must not make it look like that of the old data.
        const std::string before = m_interrupted_id.empty() ? now : m_target.before;
        write_target(m_folder, {m_plan.id(), archive, before, "", m_old.id(), true});
        try {
            m_outcome.report =
                archive_tools::patch(archive, std::span(&change, 1), archive, m_options.threads,
                                     [&](std::uint64_t, std::uint64_t) { check_stop(); });
        } catch (...) {
            if (state_of_file(archive) == now)
                write_target(m_folder, m_target);
            throw;
        }
    }

    /// @throws Error when all boxes have to be made anew
    void check_all_boxes(const OpenedCountry& country) const {
        if (country.fingerprint_of_all_boxes() != m_old.fingerprint_of_all_boxes)
            throw util::Error(attempt() +
                              ": all of the archive has to be made anew, as the settings, the "
                              "class table, the palette, or the lowest place of all have changed; "
                              "plan again");
    }

    [[nodiscard]] std::vector<std::string> identities_before() const {
        std::vector<std::string> out;
        for (const auto& [file, identity] : m_before)
            out.push_back(identity);
        return out;
    }

    void write_change(OpenedCountry& country, const fs::path& out) {
        const exports::ChangedColumns columns = changed_columns(country);
        exports::Meter meter("patch", columns.replaced.size() + columns.compared.size(),
                             m_options.quiet);
        exports::Job job(country.world(), country.part(), out, country.palette(), meter);
        job.threads = m_options.threads;
        job.stop = m_options.stop;
        for (const fs::path& file : m_plan.world.left_out)
            job.left_out.push_back(file.filename().string() + " was left out: it cannot be read");
        exports::write_change(job, columns);
        meter.finish();
        m_outcome.damage = job.damage_lines();
    }

    exports::ChangedColumns changed_columns(OpenedCountry& country) const {
        const auto& squares = country.world().facts().squares;
        std::set<std::size_t> changed;
        for (std::size_t i = 0; i < squares.size(); ++i)
            if (m_taken.contains(squares[i].file.lexically_normal()))
                changed.insert(i);
        const voxelize::DependentColumns found = voxelize::columns_that_depend_on(
            country.world(), changed, m_options.threads,
            {rects_before(country.world()), has_known_squares(m_folder, m_old)});
        exports::ChangedColumns out = exports::changed_columns(
            country.part(), columns_at({found.dependent.begin(), found.dependent.end()}),
            columns_at(found.neighbours));
        if (out.replaced.empty())
            throw util::Error(attempt() +
                              ": none of the squares that have changed lies in the part that was "
                              "planned; plan again");
        return out;
    }

    /// Where the squares lay that have changed or are gone.
    [[nodiscard]] std::vector<grid::ColumnRect> rects_before(voxelize::LidarWorld& world) const {
        std::vector<grid::ColumnRect> out;
        for (const auto& [file, identity] : m_before) {
            const auto rect = world.known_bounds(identity);
            if (!rect)
                throw util::Error(attempt() + ": the plan does not know where " + file.string() +
                                  " lay (" + m_folder.known_squares().string() + "); plan again");
            if (world.shadow_patches() > 0 && bounds_now(world, file) != rect)
                throw util::Error(attempt() + ": " + file.string() +
                                  " lies elsewhere than before, or is gone, and the light of "
                                  "photographs was found from it; plan again");
            out.push_back(*rect);
        }
        return out;
    }

    [[nodiscard]] static std::optional<grid::ColumnRect> bounds_now(
        const voxelize::LidarWorld& world, const fs::path& file) {
        for (const voxelize::SquareInfo& square : world.facts().squares)
            if (square.file.lexically_normal() == file)
                return square.bounds;
        return std::nullopt;
    }

    void check_stop() const {
        if (m_options.stop.stop_requested())
            throw util::Error(attempt() + ": interrupted; the same command goes on");
    }

    const PlanFolder& m_folder;
    const PatchOptions& m_options;
    const Plan m_old;
    Plan m_plan;
    /// A square that has changed or is gone, with its identity then.
    struct SquareBefore {
        fs::path file;
        std::string identity;
    };
    std::vector<SquareBefore> m_before;
    std::set<fs::path> m_taken;    ///< squares that have changed or are new
    Target m_target;               ///< as it was noted when this call began
    bool m_goes_on = false;        ///< a patch of the same plan had begun
    std::string m_interrupted_id;  ///< of the plan whose archive is there; empty: m_old's is
    PatchOutcome m_outcome;
};

}  // namespace

PatchOutcome patch_country(const PlanFolder& folder, const PatchOptions& options) {
    const auto lock = util::FileLock::try_take(folder.run_lock());
    if (!lock)
        throw util::Error("patch the country of " + folder.path().string() + ": " +
                          util::FileLock::holder(folder.run_lock()) + " runs it");
    return CountryPatch(folder, options).run();
}

}  // namespace terravox::country
