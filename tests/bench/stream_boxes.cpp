// terravox-bench-stream: requests every level-0 box of a LiDAR world once and reports the costs. A
// program of its own, so that its peak memory is that of the voxelizer alone.
#include <atomic>
#include <chrono>
#include <cstdio>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/program.hpp"
#include "voxelserver/voxelize/world/lidar_world.hpp"

namespace {

using namespace terravox;

constexpr std::int32_t kBlock =
    16;  ///< boxes along a block, about a square: as a client that walks over a map

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::size_t ask_block(voxel::World& world, const voxel::BoxRange& range, std::int32_t bx0,
                      std::int32_t bz0, int threads) {
    std::atomic<std::size_t> solid{0};
    thread::parallel_for(static_cast<std::size_t>(kBlock) * kBlock, threads, [&](std::size_t i) {
        const std::int32_t bx = bx0 + static_cast<std::int32_t>(i) % kBlock;
        const std::int32_t bz = bz0 + static_cast<std::int32_t>(i) / kBlock;
        if (bx >= range.max.bx || bz >= range.max.bz)
            return;
        const auto extent = world.column(0, bx, bz);
        for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by)
            if (world.box({0, bx, by, bz}))
                ++solid;
    });
    return solid;
}

int run(const voxelize::LidarWorldOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options, times);
    const double open_s = seconds_since(start);
    const auto range = voxel::boxes_over(world->info().bounds, 0);
    std::size_t boxes = 0;
    for (std::int32_t bz = range.min.bz; bz < range.max.bz; bz += kBlock)
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; bx += kBlock)
            boxes += ask_block(*world, range, bx, bz, options.threads);
    std::printf("{\"points\": %llu, \"boxes\": %zu, \"open_s\": %.3f, \"wall_s\": %.3f}\n",
                static_cast<unsigned long long>(world->stats().points), boxes, open_s,
                seconds_since(start));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] {
        util::set_up_log("error");
        CLI::App app{"Asks for every box of a LiDAR world once (part of terravox bench).",
                     "terravox-bench-stream"};
        voxelize::LidarWorldOptions options;
        std::vector<std::string> files;
        std::string crs;
        int memory_mib = 500;
        app.add_option("files", files, "LAS or LAZ files, or folders of them")->required();
        app.add_option("--crs", crs, "what the files do not say");
        app.add_option("--classes", options.classes, "id of a class table")->capture_default_str();
        app.add_option("--voxel-m", options.voxel_m, "edge of a voxel, metres")
            ->capture_default_str();
        app.add_option("--memory-mib", memory_mib, "for the world's caches")
            ->check(CLI::Range(16, 1 << 20))
            ->capture_default_str();
        app.add_option("--cache-dir", options.cache_dir, "folder for prepared squares");
        app.add_option("--threads", options.threads, "0 = one for each core")
            ->check(CLI::Range(0, 1024))
            ->capture_default_str();
        if (const auto code = util::parse_arguments(app, argc, argv))
            return *code;
        options.files.assign(files.begin(), files.end());
        if (!crs.empty())
            options.crs = crs;
        options.memory_bytes = static_cast<std::size_t>(memory_mib) << 20;
        options.threads = thread::thread_count(options.threads);
        return run(options);
    });
}
