#include <atomic>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "tests/bench/clocks.hpp"
#include "tests/bench/entries/square_photo.hpp"

namespace terravox::bench::voxelize_square_entry {
namespace {

constexpr double kFirstSystem_ms =
    81.7;  ///< a box of the first system, best index, one client (docs/benchmarks/voxelizing.md)

// Shares of the time of all steps, on one thread, so that they are shares of the CPU time.
void add_steps(const util::StageTimes& times, Readings& readings) {
    double sum = 0;
    for (const auto& stage : times.stages())
        sum += stage.seconds;
    for (const auto& stage : times.stages())
        readings.add("step " + stage.name + " 1t", "share", stage.seconds / sum);
}

void measure_threads(const Context& c, const DecodeFloor& floor, int threads,
                     const std::string& label, Readings& readings) {
    const auto options = square_options(c, threads);
    const auto columns = benchmark_columns();
    const Cost decode = measure_cost([&] { static_cast<void>(floor.seconds(threads)); });
    util::StageTimes times;
    std::atomic<std::size_t> solid{0};
    Cost all;
    {
        // Its end is not counted: a server's world does not end.
        std::unique_ptr<voxelize::LidarWorld> world;
        all = measure_cost([&] {
            world = voxelize::open_lidar_world(options, times);
            thread::parallel_for(columns.size(), threads, [&](std::size_t i) {
                const auto extent = world->column(0, columns[i].bx, columns[i].bz);
                for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by)
                    if (world->box({0, columns[i].bx, by, columns[i].bz}))
                        ++solid;
            });
        });
    }
    if (solid == 0)
        throw util::Error("make the boxes of the square: all of them are air");
    const auto boxes = static_cast<double>(solid);
    readings.add("box columns " + label, "columns", static_cast<double>(columns.size()));
    readings.add("boxes " + label, "boxes", boxes);
    readings.add("CPU " + label, "s", all.cpu_s);
    readings.add("wall " + label, "s", all.wall_s);
    readings.add("LASzip CPU " + label, "s", decode.cpu_s);
    readings.add("CPU / LASzip CPU " + label, "x", all.cpu_s / decode.cpu_s, at_most(1.5));
    readings.add("wall of a box " + label, "ms/box", all.wall_s * 1e3 / boxes,
                 threads > 1 ? at_most(kFirstSystem_ms / 6) : Target{});
    readings.add("wall of a box column " + label, "ms",
                 all.wall_s * 1e3 / static_cast<double>(columns.size()));
    if (threads == 1)
        add_steps(times, readings);
}

Entry entry() {
    Entry out;
    out.name = "voxelize/square";
    out.measures =
        "opening a square and making each of its boxes once, everything on: CPU and wall time, and "
        "where it goes";
    out.work = square().facts +
               " with its orthophoto: the 16 x 16 box columns over 960 x 960 m; nothing cached, "
               "warm page cache; 1 and N threads";
    out.floor = "LASzip decoding of the same file with as many threads";
    out.missing = square_and_photo_missing;
    out.prepare = [](const Context& c) -> Body {
        static_cast<void>(square_photo(c));
        const auto floor = std::make_shared<DecodeFloor>(square().paths(c));
        return [floor, &c](Readings& readings) {
            measure_threads(c, *floor, 1, "1t", readings);
            if (c.threads > 1)
                measure_threads(c, *floor, c.threads, "Nt", readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::voxelize_square_entry
