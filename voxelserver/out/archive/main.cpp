#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

#include "common/util/command_line.hpp"
#include "common/util/program.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"
#include "voxelserver/out/archive/archive_files.hpp"
#include "voxelserver/out/archive/merge.hpp"
#include "voxelserver/out/archive/patch.hpp"
#include "voxelserver/out/archive/split.hpp"
#include "voxelserver/out/archive/stac_command.hpp"
#include "voxelserver/out/archive/verify.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace {

using namespace terravox;

constexpr std::uint64_t kSteps = 1000;  ///< of meters whose work is counted in bytes

struct Arguments {
    std::string file;                 ///< of patch and split
    std::vector<std::string> files;   ///< of info and verify: one, or the parts of one
    std::vector<std::string> others;  ///< shards or parts of merge, changes of patch
    std::string out;                  ///< of all but info and verify; empty: as the option says
    int max_mib = 0;                  ///< of split
    bool overwrite = false;
    bool json = false;
    bool only_checksums = false;  ///< of verify
    bool quiet = false;
    int threads = 0;
};

std::vector<std::filesystem::path> list_paths(const std::vector<std::string>& names) {
    return {names.begin(), names.end()};
}

archive_tools::ArchiveFiles list_files(const Arguments& arguments) {
    return archive_tools::ArchiveFiles(
        archive_tools::in_order_of_numbers(list_paths(arguments.files)));
}

util::ExitCode info(const Arguments& arguments) {
    const archive_tools::Summary summary = archive_tools::make_summary(list_files(arguments));
    std::cout << (arguments.json ? archive_tools::to_json(summary) + "\n"
                                 : archive_tools::to_text(summary));
    return summary.holes() > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

std::string counted(std::uint64_t count, const std::string& one, const std::string& many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

util::ExitCode verify(const Arguments& arguments) {
    const archive_tools::Summary summary = archive_tools::make_summary(list_files(arguments));
    std::uint64_t records = summary.holes();
    for (const archive_tools::LevelSummary& level : summary.levels)
        records += level.boxes;
    exports::Meter meter("verify", records, arguments.quiet);
    const auto progress = [&](std::uint64_t done, std::uint64_t all) { meter.reach(done, all); };
    const auto found =
        arguments.only_checksums
            ? archive_tools::verify_stored(list_files(arguments), arguments.threads, progress)
            : archive_tools::verify(list_files(arguments), arguments.threads, progress);
    meter.finish();
    for (const std::string& problem : found.first_problems)
        std::cerr << "terravox: verify " << util::printable(arguments.files.front()) << ": "
                  << util::printable(problem) << "\n";
    if (found.problems > 0)
        throw util::Error("verify " + arguments.files.front() + ": " +
                          counted(found.problems, "problem", "problems") + " in " +
                          counted(found.boxes, "box", "boxes"));
    std::cout << arguments.files.front() << ": whole, " << counted(found.boxes, "box", "boxes")
              << ", " << counted(found.holes, "hole", "holes") << "\n";
    return found.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

/// @param attempt "merge to"
void check_free(const std::filesystem::path& out, bool overwrite, const char* attempt) {
    std::error_code ignored;
    if (!overwrite && std::filesystem::exists(out, ignored))
        throw util::UsageError(std::string(attempt) + " " + out.string() +
                               ": it is there already; allowed: another name, or --overwrite");
}

util::ExitCode merge(const Arguments& arguments) {
    const std::filesystem::path out = arguments.out;
    check_free(out, arguments.overwrite, "merge to");
    const std::vector<std::filesystem::path> shards =
        archive_tools::in_order_of_numbers(list_paths(arguments.others));
    if (archive_tools::is_first_part(shards.front())) {
        const auto joined = archive_tools::join_parts(shards, out, arguments.threads);
        std::cout << arguments.out << ": " << counted(joined.boxes, "box", "boxes") << ", "
                  << counted(joined.holes, "hole", "holes") << ", of "
                  << counted(shards.size(), "part", "parts") << "\n";
        return joined.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
    }
    exports::Meter meter("merge", kSteps, arguments.quiet);
    const auto done = archive_tools::merge(
        shards, out, arguments.threads,
        [&](std::uint64_t bytes, std::uint64_t all) { meter.reach(bytes, all); });
    meter.finish();
    std::cout << arguments.out << ": " << counted(done.records - done.holes, "box", "boxes") << ", "
              << counted(done.holes, "hole", "holes") << ", of "
              << counted(shards.size(), "shard", "shards") << "\n";
    return done.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

util::ExitCode patch(const Arguments& arguments) {
    const std::filesystem::path archive = arguments.file;
    const std::filesystem::path out = arguments.out.empty() ? arguments.file : arguments.out;
    if (!arguments.out.empty())
        check_free(out, arguments.overwrite, "patch to");
    const std::vector<std::filesystem::path> changes = list_paths(arguments.others);
    exports::Meter meter("patch", kSteps, arguments.quiet);
    const auto done = archive_tools::patch(
        archive, changes, out, arguments.threads,
        [&](std::uint64_t some, std::uint64_t all) { meter.reach(some, all); });
    meter.finish();
    std::cout << out.string() << ": " << counted(done.columns, "column", "columns")
              << " of boxes replaced, " << counted(done.made, "record", "records") << " new, "
              << done.kept << " kept, " << counted(done.holes, "hole", "holes") << "\n";
    return done.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

util::ExitCode split(const Arguments& arguments) {
    const std::filesystem::path archive = arguments.file;
    const std::filesystem::path folder =
        arguments.out.empty() ? archive.parent_path() : std::filesystem::path(arguments.out);
    const auto there = archive_tools::parts_in(folder.empty() ? "." : folder, archive.stem());
    if (!there.empty() && !arguments.overwrite)
        throw util::UsageError("split to " + there.front().string() +
                               ": it is there already; allowed: another folder, or --overwrite");
    constexpr std::uint64_t kMib = 1 << 20;
    const auto parts =
        archive_tools::split(archive, folder, static_cast<std::uint64_t>(arguments.max_mib) * kMib);
    // Only now: of a split that failed, the old parts would be all that there is.
    for (const std::filesystem::path& old : there)
        if (std::none_of(parts.begin(), parts.end(), [&](const archive_tools::FilePart& part) {
                return part.name == old.filename();
            }))
            std::filesystem::remove(old);
    for (const archive_tools::FilePart& part : parts)
        std::cout << (parts.size() == 1 ? archive : folder / part.name).string() << "\n";
    return util::ExitCode::kDone;
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
        command
            ->add_option("files", arguments.files,
                         "the archive, its parts, or a shard or change of one")
            ->required();
    auto* const merging = app.add_subcommand(
        "merge", "join the shards of convert --shard I/N, or the parts of split, to an archive");
    merging
        ->add_option("files", arguments.others,
                     "all shards of one conversion, or all parts of one archive")
        ->required();
    merging->add_option("-o,--output", arguments.out, "archive to write")->required();
    merging->add_flag("--overwrite", arguments.overwrite, "write over what is there");
    auto* const patching = app.add_subcommand(
        "patch",
        "put changes, of convert --squares, into an archive; programs that read it go on with the "
        "old one");
    patching->add_option("file", arguments.file, "the archive")->required();
    patching->add_option("changes", arguments.others, "changes, all of the same state of the data")
        ->required();
    patching->add_option("-o,--output", arguments.out,
                         "archive to write; default: it replaces the old one");
    patching->add_flag("--overwrite", arguments.overwrite, "write over what is there");
    auto* const splitting = app.add_subcommand(
        "split", "cut an archive into files NAME-0001.part and so on, for hosts that limit files");
    splitting->add_option("file", arguments.file, "the archive; it stays")->required();
    constexpr int kMost_mib = 1 << 20;
    splitting->add_option("--max-mib", arguments.max_mib, "largest file, MiB")
        ->required()
        ->check(CLI::Range(1, kMost_mib));
    splitting->add_option("-o,--output", arguments.out,
                          "folder of the parts; default: that of the archive");
    splitting->add_flag("--overwrite", arguments.overwrite, "replace the parts that are there");
    // Only listed: go_on_as() has run it.
    archive_tools::StacArguments stac;
    auto* const describing =
        app.add_subcommand(archive_tools::kStac.name, archive_tools::kStac.description);
    describing->set_version_flag("--version", std::string("terravox ") + kVersion);
    archive_tools::add_stac_options(*describing, stac);
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
    if (*splitting)
        return static_cast<int>(split(arguments));
    return static_cast<int>(*informing ? info(arguments) : verify(arguments));
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] {
        util::go_on_as(archive_tools::kStac, argc, argv);
        return run(argc, argv);
    });
}
