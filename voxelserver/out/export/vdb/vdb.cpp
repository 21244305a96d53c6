#include "voxelserver/out/export/vdb/vdb.hpp"

#include <dlfcn.h>
#include <algorithm>
#include <filesystem>
#include <regex>
#include <string>
#include <system_error>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/version.hpp"

namespace terravox::exports {
namespace {

constexpr const char* kWhat = "OpenVDB module";

WriteVdb* load() {
    void* const module = util::open_module(TERRAVOX_VDB_MODULE, kWhat);
    auto* const write = reinterpret_cast<WriteVdb*>(dlsym(module, kWriteVdb));
    if (write == nullptr)
        throw util::Error("load the " + std::string(kWhat) + " " +
                          util::module_file(TERRAVOX_VDB_MODULE).string() + ": it has no " +
                          kWriteVdb);
    return write;
}

}  // namespace

void write_vdb(Job& job, const VdbOptions& options) {
    static WriteVdb* const write = load();  // again when it throws
    write(kVersion, job, options);
}

namespace {

namespace fs = std::filesystem;

// Files that an earlier conversion to this .vdb may have left: the file, or the files that a large
// one is divided into.
std::vector<fs::path> earlier_files(const fs::path& out) {
    const std::regex name(R"((.*)_\d+_\d+\.vdb)");
    std::vector<fs::path> files;
    std::error_code failed;
    if (fs::exists(out, failed))
        files.push_back(out);
    const fs::path folder = out.has_parent_path() ? out.parent_path() : fs::path(".");
    for (fs::directory_iterator it(folder, failed), end; !failed && it != end;
         it.increment(failed)) {
        std::smatch match;
        const std::string file = it->path().filename().string();
        if (std::regex_match(file, match, name) && match[1] == out.stem().string())
            files.push_back(it->path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

void check_target(const fs::path& out, const WriteOptions& options) {
    if (!options.overwrite) {
        if (const auto earlier = earlier_files(out); !earlier.empty()) {
            throw util::UsageError("convert to " + out.string() + ": " + earlier.front().string() +
                                   " is there already; allowed: another name, or --overwrite");
        }
    }
    check_file_target(out, options);
}

// Removes the files of an earlier conversion that divided the world in another way: they would be
// mixed with the new ones.
void remove_unless_written(const std::vector<fs::path>& earlier, const Job& job) {
    const auto written = job.files();
    for (const fs::path& file : earlier) {
        const bool is_new = std::any_of(written.begin(), written.end(), [&](const fs::path& w) {
            return w.filename() == file.filename();
        });
        if (!is_new) {
            fs::remove(file);
            fs::remove(file.string() + ".georef.json");
        }
    }
}

void write(Job& job, const WriteOptions& options) {
    const auto earlier = earlier_files(job.out);
    write_vdb(job, {.up = options.up});
    remove_unless_written(earlier, job);
}

}  // namespace

const Format kVdbFormat{
    .name = "vdb",
    .extension = ".vdb",
    .check_target = check_target,
    .steps = column_steps,
    .write = write,
};

}  // namespace terravox::exports
