#include "raytracer/apps/commands/country/country_command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/country/plan_outputs.hpp"
#include "voxelserver/out/country/plan.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;

struct PlanArguments {
    WorldArguments world;
    ScriptArguments scripts;
    std::string out;
    std::string area;
    std::string heights;
    int shards = 0;
    int sample = 6;
    int memory_mib = 448;  ///< many tasks share a machine
    int scratch_mib = 2048;
    bool overwrite = false;
    bool json = false;
    bool quiet = false;
};

/// The folder of the plan; made, and empty of other plans.
country::PlanFolder make_folder(const PlanArguments& args) {
    std::error_code failed;
    fs::create_directories(args.out, failed);
    if (failed)
        throw util::Error("make the folder of the plan " + args.out + ": " + failed.message());
    const country::PlanFolder folder{args.out};
    if (!args.overwrite && fs::exists(folder.plan(), failed))
        throw util::UsageError("write the plan " + args.out +
                               ": there is one already; allowed: another folder, or --overwrite");
    if (util::FileLock::is_taken(folder.run_lock()))
        throw util::Error("write the plan " + args.out + ": " +
                          util::FileLock::holder(folder.run_lock()) +
                          " runs the one that is there");
    return folder;
}

/// A plan that is refused leaves no empty folders, and no indices that its sample has made.
class EmptyFolders {
public:
    explicit EmptyFolders(const country::PlanFolder& folder) : m_folder(folder) {
        std::error_code failed;
        m_had_chunks = fs::exists(folder.chunks(), failed) || failed;
    }
    ~EmptyFolders() {
        std::error_code ignored;
        if (!m_had_chunks && !m_is_planned)
            fs::remove_all(m_folder.chunks(), ignored);
        fs::remove(m_folder.scratch(), ignored);
        fs::remove(m_folder.path(), ignored);
    }
    void set_planned() noexcept { m_is_planned = true; }
    EmptyFolders(const EmptyFolders&) = delete;
    EmptyFolders& operator=(const EmptyFolders&) = delete;

private:
    const country::PlanFolder& m_folder;
    bool m_had_chunks = false;
    bool m_is_planned = false;
};

country::PlanOptions make_options(const PlanArguments& args) {
    WorldArguments world = args.world;
    world.fields.emplace_back("world.memory_mib", std::to_string(args.memory_mib));
    country::PlanOptions out;
    out.world = world.options(world.scene());
    out.world.cache_dir.clear();
    out.area = list_numbers("country plan", "--area", args.area, 4,
                            "west,south,east,north in the CRS of the data");
    out.heights =
        list_numbers("country plan", "--heights", args.heights, 2, "lowest,highest in metres");
    out.shards = args.shards;
    out.sample = static_cast<std::size_t>(args.sample);
    out.scratch_bytes = static_cast<std::uint64_t>(args.scratch_mib) << 20;
    return out;
}

util::ExitCode run_plan(const PlanArguments& args) {
    util::set_up_log(args.quiet ? "error" : args.world.log_level);
    if (!args.world.cache.empty())
        throw util::UsageError("plan the country: --cache " + args.world.cache +
                               "; allowed: without it, tasks keep decoded squares in their scratch "
                               "folders (--scratch-mib)");
    if (!args.world.additions.empty())
        throw util::UsageError(
            "plan the country: --add " + args.world.additions.front() +
            "; allowed: without it, planned objects are put into the finished archive when it is "
            "rendered");
    args.scripts.check();
    country::PlanOptions options = make_options(args);
    const country::PlanFolder folder = make_folder(args);
    EmptyFolders unused(folder);
    const country::ScratchFolder scratch(folder.scratch() / "sample");
    options.scratch = scratch.path();
    options.world.known_squares = folder.known_squares();
    options.world.chunk_indices = folder.chunks();
    exports::Meter meter("sample", options.sample, args.quiet);
    std::size_t shown = 0;
    const auto [plan, known_squares] =
        country::make_plan(options, [&](std::size_t done, std::size_t) {
            meter.add(done - shown);
            shown = done;
        });
    meter.finish();
    country::write_plan(folder, plan);
    unused.set_planned();
    util::write_file_atomically(folder.known_squares(), known_squares, util::Links::kReplace);
    args.scripts.write(folder, plan, args.out);
    const std::string said = args.json ? to_json(plan, args.out) + "\n" : to_text(plan);
    std::fputs(said.c_str(), stdout);
    for (const country::MissingSquare& square : plan.missing)
        util::log_error("missing: {}: {}", util::printable(square.name),
                        util::printable(square.reason));
    return plan.missing.empty() ? util::ExitCode::kDone : util::ExitCode::kHoles;
}

std::function<util::ExitCode()> add_country_plan(CLI::App& country) {
    auto args = std::make_shared<PlanArguments>();
    CLI::App* const command = country.add_subcommand(
        "plan",
        "Look at all data, measure some places, and write a plan: what is made, in which shards, "
        "and what that takes");
    command
        ->add_option("inputs", args->world.inputs,
                     "LiDAR files, folders of them, or the grabber's store")
        ->required();
    command->add_option("-o,--output", args->out, "folder for the plan, its shards and logs")
        ->required();
    command
        ->add_option("--shards", args->shards,
                     "number of tasks; default: so many that each takes about a quarter of an hour")
        ->check(CLI::Range(1, country::kMaxShards));
    command->add_option("--area", args->area, "west,south,east,north in the CRS of the data");
    command->add_option("--heights", args->heights, "lowest,highest in metres");
    command
        ->add_option("--sample", args->sample,
                     "number of columns of boxes to measure; more: a better estimate, later")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str();
    command
        ->add_option("--memory-mib", args->memory_mib,
                     "limit of what a task keeps of its data in memory, MiB")
        ->check(CLI::Range(64, 1 << 20))
        ->capture_default_str();
    command
        ->add_option("--scratch-mib", args->scratch_mib,
                     "limit of decoded squares that a task keeps on disk, MiB")
        ->check(CLI::Range(64, 1 << 24))
        ->capture_default_str();
    command->add_flag("--overwrite", args->overwrite,
                      "plan anew; shards that fit the new plan are kept");
    command->add_flag("--json", args->json, "print the estimate as JSON");
    command->add_flag("-q,--quiet", args->quiet, "print the estimate and errors only");
    args->scripts.add_to(*command);
    add_opening_arguments(
        *command, args->world,
        {"world.crs", "world.classes", "world.mark_unknown", "world.vertical_unit",
         "world.settings", "world.steps", "world.photo", "world.voxel_m", "processing.threads"});
    return [args] { return run_plan(*args); };
}

}  // namespace

std::function<util::ExitCode()> add_country_command(CLI::App& app) {
    CLI::App* const group = app.add_subcommand(
        "country",
        "Make the box archive of a large area in shards, on this machine or on a cluster");
    group->require_subcommand(1);
    group->footer(
        "The archive is the one that `terravox convert` writes, byte for byte. Whatever is killed: "
        "the same command goes on, and nothing that is finished is made again.\n"
        "Exit code 3: done, but some places are missing; they are named.");
    const auto plan = add_country_plan(*group);
    const auto runs = add_country_runs(*group);
    return [=] { return group->got_subcommand("plan") ? plan() : runs(); };
}

}  // namespace terravox::commands
