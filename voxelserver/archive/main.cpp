#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "common/util/printable.hpp"
#include "common/util/program.hpp"
#include "common/util/version.hpp"
#include "voxelserver/archive/merge.hpp"
#include "voxelserver/archive/patch.hpp"
#include "voxelserver/archive/summary.hpp"
#include "voxelserver/archive/verify.hpp"
#include "voxelserver/export/core/meter.hpp"

namespace {

using namespace terravox;

struct Arguments {
    std::string file;
    std::vector<std::string> parts;  ///< shards of merge, changes of patch
    std::string out;                 ///< of merge and patch; empty: patch replaces the archive
    bool overwrite = false;
    bool json = false;
    bool only_checksums = false;  ///< of verify
    bool quiet = false;
    int threads = 0;
};

util::ExitCode info(const Arguments& arguments) {
    const archive_tools::Summary summary = archive_tools::summary_of(arguments.file);
    std::cout << (arguments.json ? archive_tools::json_of(summary) + "\n"
                                 : archive_tools::text_of(summary));
    return summary.holes() > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

std::string counted(std::uint64_t count, const std::string& one, const std::string& many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

util::ExitCode verify(const Arguments& arguments) {
    const archive_tools::Summary summary = archive_tools::summary_of(arguments.file);
    std::uint64_t records = summary.holes();
    for (const archive_tools::LevelSummary& level : summary.levels)
        records += level.boxes;
    exports::Meter meter("verify", records, arguments.quiet);
    std::uint64_t shown = 0;
    const auto progress = [&](std::uint64_t done, std::uint64_t /*total*/) {
        meter.add(done - std::exchange(shown, done));
    };
    const auto found =
        arguments.only_checksums
            ? archive_tools::verify_stored(arguments.file, arguments.threads, progress)
            : archive_tools::verify(arguments.file, arguments.threads, progress);
    meter.finish();
    for (const std::string& problem : found.first_problems)
        std::cerr << "terravox: verify " << util::printable(arguments.file) << ": "
                  << util::printable(problem) << "\n";
    if (found.problems > 0)
        throw util::Error("verify " + arguments.file + ": " +
                          counted(found.problems, "problem", "problems") + " in " +
                          counted(found.boxes, "box", "boxes"));
    std::cout << arguments.file << ": whole, " << counted(found.boxes, "box", "boxes") << ", "
              << counted(found.holes, "hole", "holes") << "\n";
    return found.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

util::ExitCode merge(const Arguments& arguments) {
    const std::filesystem::path out = arguments.out;
    if (!arguments.overwrite && std::filesystem::exists(out))
        throw util::UsageError("merge to " + out.string() +
                               ": it is there already; allowed: another name, or --overwrite");
    const std::vector<std::filesystem::path> shards(arguments.parts.begin(), arguments.parts.end());
    constexpr std::uint64_t kSteps = 1000;
    exports::Meter meter("merge", kSteps, arguments.quiet);
    std::uint64_t shown = 0;
    const auto done = archive_tools::merge(
        shards, out, arguments.threads, [&](std::uint64_t bytes, std::uint64_t total) {
            const std::uint64_t step = total == 0 ? 0 : bytes * kSteps / total;
            if (step > shown)
                meter.add(step - std::exchange(shown, step));
        });
    meter.finish();
    std::cout << arguments.out << ": " << counted(done.records - done.holes, "box", "boxes") << ", "
              << counted(done.holes, "hole", "holes") << ", of "
              << counted(shards.size(), "shard", "shards") << "\n";
    return done.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

util::ExitCode patch(const Arguments& arguments) {
    const std::filesystem::path archive = arguments.file;
    const std::filesystem::path out = arguments.out.empty() ? arguments.file : arguments.out;
    if (!arguments.out.empty() && !arguments.overwrite && std::filesystem::exists(out))
        throw util::UsageError("patch to " + out.string() +
                               ": it is there already; allowed: another name, or --overwrite");
    const std::vector<std::filesystem::path> changes(arguments.parts.begin(),
                                                     arguments.parts.end());
    constexpr std::uint64_t kSteps = 1000;
    exports::Meter meter("patch", kSteps, arguments.quiet);
    std::uint64_t shown = 0;
    const auto done = archive_tools::patch(archive, changes, out, arguments.threads,
                                           [&](std::uint64_t some, std::uint64_t all) {
                                               const std::uint64_t step = some * kSteps / all;
                                               meter.add(step - std::exchange(shown, step));
                                           });
    meter.finish();
    std::cout << out.string() << ": " << counted(done.columns, "column", "columns")
              << " of boxes replaced, " << counted(done.made, "record", "records") << " new, "
              << done.kept << " kept, " << counted(done.holes, "hole", "holes") << "\n";
    return done.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

int run(int argc, char** argv) {
    CLI::App app(
        "Box archives (.tvx): what one holds, whether it is whole, one of shards, one with "
        "changes. "
        "Exit code 3: "
        "done, but there are holes, boxes that could not be read when it was made.",
        "terravox-archive");
    app.set_version_flag("--version", std::string("terravox archive ") + kVersion);
    app.require_subcommand(1);
    Arguments arguments;
    auto* const informing = app.add_subcommand("info", "print what an archive says of itself");
    informing->add_flag("--json", arguments.json, "as JSON");
    auto* const verifying = app.add_subcommand(
        "verify", "read every box, and compare coarse boxes with those that they were made of");
    verifying->add_flag("--checksums", arguments.only_checksums,
                        "only that all bytes are those that were written: nothing is unpacked");
    for (auto* const command : {informing, verifying})
        command->add_option("file", arguments.file, "the archive, or a shard of one")->required();
    auto* const merging = app.add_subcommand(
        "merge", "join the shards of convert --shard I/N to the archive that they are parts of");
    merging->add_option("shards", arguments.parts, "all shards of one conversion")->required();
    merging->add_option("-o,--output", arguments.out, "archive to write")->required();
    merging->add_flag("--overwrite", arguments.overwrite, "write over what is there");
    auto* const patching = app.add_subcommand(
        "patch",
        "put changes, of convert --squares, into an archive; programs that read it go on with the "
        "old one");
    patching->add_option("file", arguments.file, "the archive")->required();
    patching->add_option("changes", arguments.parts, "changes, all of the same state of the data")
        ->required();
    patching->add_option("-o,--output", arguments.out,
                         "archive to write; default: it replaces the old one");
    patching->add_flag("--overwrite", arguments.overwrite, "write over what is there");
    for (auto* const command : {verifying, merging, patching}) {
        command->add_option("--threads", arguments.threads, "0: one for each core")
            ->check(CLI::Range(0, 1024));
        command->add_flag("-q,--quiet", arguments.quiet, "no progress");
    }
    if (const auto answered = util::parse_arguments(app, argc, argv))
        return *answered;
    if (*merging)
        return static_cast<int>(merge(arguments));
    if (*patching)
        return static_cast<int>(patch(arguments));
    return static_cast<int>(*informing ? info(arguments) : verify(arguments));
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] { return run(argc, argv); });
}
