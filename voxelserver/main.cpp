#include <malloc.h>

#include <CLI/CLI.hpp>

#include "common/util/program.hpp"
#include "common/util/version.hpp"
#include "voxelserver/serve/server/serve.hpp"

namespace {

using namespace terravox;

int run(int argc, char** argv) {
    CLI::App app{
        "Serves voxel boxes of a world over HTTP: LiDAR data, heights, Minecraft, and others.",
        "terravox serve"};
    app.set_version_flag("--version", std::string("terravox ") + kVersion);
    serve::Options options;
    serve::add_options(app, options);
    if (const auto code = util::parse_arguments(app, argc, argv))
        return *code;
    return static_cast<int>(serve::serve(options));
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
    // Boxes are made on many request threads. With an arena for each of them, what one has freed is
    // of no use to the others: twice the memory.
    mallopt(M_ARENA_MAX, 2);
    // Large buffers go back to the system; left alone, the first of them would raise this
    // threshold.
    mallopt(M_MMAP_THRESHOLD, 8 << 20);
#endif
    return util::run_program([&] { return run(argc, argv); });
}
