#include <cpl_error.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/geo/gdal_messages.hpp"
#include "common/util/program.hpp"
#include "common/util/version.hpp"
#include "voxelserver/tools/laz/laz_commands.hpp"

namespace {

using namespace terravox;

struct Names {
    std::string from;
    std::string to;
};

void compress(const Names& names) {
    const auto done = laz::compress(names.from, names.to);
    std::printf("%s: %llu points, %.1f MB to %.1f MB\n", names.to.c_str(),
                static_cast<unsigned long long>(done.points),
                static_cast<double>(done.bytes_before) / 1e6,
                static_cast<double>(done.bytes_after) / 1e6);
}

void index(const Names& names) {
    const auto done = laz::write_lax(names.from);
    std::printf("%s: %llu cells, %llu intervals, %llu bytes\n", done.path.c_str(),
                static_cast<unsigned long long>(done.cells),
                static_cast<unsigned long long>(done.intervals),
                static_cast<unsigned long long>(done.bytes));
}

int run(int argc, char** argv) {
    CLI::App app(
        "Point cloud files: LAS to LAZ, spatial indexes, what a file holds, whether it is whole.",
        "terravox-laz");
    app.set_version_flag("--version", std::string("terravox laz ") + kVersion);
    app.require_subcommand(1);
    Names names;
    auto* const compressing = app.add_subcommand(
        "compress", "write a LAS file as LAZ, without loss, and compare what was written");
    compressing->add_option("in", names.from, "LAS file")->required();
    compressing->add_option("out", names.to, "LAZ file to write")->required();
    auto* const indexing = app.add_subcommand("index", "write a .lax spatial index next to a file");
    auto* const inspecting = app.add_subcommand("info", "print what the header says, as JSON");
    auto* const checking =
        app.add_subcommand("check", "decode every point; all must lie within the header's bounds");
    for (auto* const command : {indexing, inspecting, checking})
        command->add_option("file", names.from, "LAS or LAZ file")->required();
    if (const auto answered = util::parse_arguments(app, argc, argv))
        return *answered;
    // Messages of GDAL and PROJ about a file's CRS would be a second line.
    CPLSetErrorHandler(geo::drop_gdal_message);
    ::setenv("PROJ_DEBUG", "0", 0);
    if (*compressing)
        compress(names);
    if (*indexing)
        index(names);
    if (*inspecting)
        std::printf("%s\n", laz::info_json(names.from).c_str());
    if (*checking)
        std::printf("%s: %llu points\n", names.from.c_str(),
                    static_cast<unsigned long long>(laz::check(names.from)));
    return static_cast<int>(util::ExitCode::kDone);
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] { return run(argc, argv); });
}
