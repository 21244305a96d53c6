#include "voxelserver/export/anvil/anvil_format.hpp"

#include <filesystem>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "voxelserver/export/anvil/write_anvil.hpp"

namespace terravox::exports::anvil {
namespace {

const AnvilOptions kOptions;

// A Minecraft world is never overwritten: it may have been edited by players.
void check_target(const std::filesystem::path& out, const WriteOptions& options) {
    // First what a user has written: a table that is wrong makes no folder, and reads no data.
    (void)load_export_blocks(kOptions);
    util::check_writable(out / "level.dat");
    if (options.overwrite) {
        throw util::UsageError(
            "convert to " + out.string() +
            ": --overwrite; allowed: with files, not with a Minecraft world's folder");
    }
}

}  // namespace

const Format kAnvilFormat{
    .name = "anvil",
    .extension = "",
    .folder = "a Minecraft world",
    .check_target = check_target,
    .steps = column_steps,
    .write = [](Job& job, const WriteOptions& /*options*/) { write_anvil(job, kOptions); },
};

}  // namespace terravox::exports::anvil
