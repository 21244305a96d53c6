#include "voxelserver/out/export/anvil/write_anvil.hpp"

#include <filesystem>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::exports::anvil {
namespace {

AnvilOptions make_options(const WriteOptions& options) {
    AnvilOptions out;
    out.title = options.title;
    return out;
}

// A Minecraft world is never overwritten: it may have been edited by players.
void check_target(const std::filesystem::path& out, const WriteOptions& options) {
    // First what a user has written: a table that is wrong makes no folder, and reads no data.
    (void)load_export_blocks(make_options(options));
    if (options.overwrite) {
        throw util::UsageError(
            "convert to " + out.string() +
            ": --overwrite; allowed: with files, not with a Minecraft world's folder");
    }
    // A conversion that was cut off is known by its journal, and that by the data.
    if (!std::filesystem::exists(out / kWorldJournal))
        check_new_world(out);
    util::check_writable(out / "level.dat");
}

}  // namespace

const Format kAnvilFormat{
    .name = "anvil",
    .extension = "",
    .folder = "a Minecraft world",
    .check_target = check_target,
    .steps = column_steps,
    .write = [](Job& job, const WriteOptions& options) { write_anvil(job, make_options(options)); },
    .has_title = true,
};

}  // namespace terravox::exports::anvil
