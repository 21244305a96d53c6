#include <ctime>

#include "tests/bench/bench.hpp"
#include "voxelserver/make/worlds/procedural/procedural_world.hpp"

namespace terravox::bench::world_procedural_entry {
namespace {

/// Time that this process computes, all threads together: others on the machine do not count.
double cpu_seconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Made {
    double seconds = 0;
    int boxes = 0;  ///< that hold anything
    std::size_t bytes = 0;
};

/// Stacks of boxes about the origin, each made for the first time.
Made make_all(voxel::World& world, int level, int half) {
    Made out;
    const double start = cpu_seconds();
    for (std::int32_t bz = -half; bz < half; ++bz)
        for (std::int32_t bx = -half; bx < half; ++bx) {
            const voxel::ColumnExtent extent = world.column(level, bx, bz);
            for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by) {
                const auto box = world.box({level, bx, by, bz});
                if (box) {
                    ++out.boxes;
                    out.bytes += box->memory_bytes();
                }
            }
        }
    out.seconds = cpu_seconds() - start;
    return out;
}

Entry entry() {
    Entry out;
    out.name = "world/generated";
    out.measures =
        "opening a generated world and making its boxes, level by level, one thread (CPU time)";
    out.work = "seed 1: 256 stacks of boxes about the origin of levels 0 to 3, and of level 8";
    out.missing = [](const Context&) { return std::string(); };
    out.prepare = [](const Context&) -> Body {
        return [](Readings& readings) {
            const double start = cpu_seconds();
            const auto world = procedural::open_procedural_world({});
            readings.add("open", "ms", (cpu_seconds() - start) * 1e3);
            for (const int level : {0, 1, 2, 3, 8}) {
                const Made made = make_all(*world, level, 8);
                const std::string name = "level " + std::to_string(level);
                readings.add(name, "boxes/s", made.boxes / made.seconds,
                             level == 0 ? at_least(150) : Target{});
                readings.add(name + " memory", "KiB/box",
                             static_cast<double>(made.bytes) / made.boxes / 1024);
            }
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::world_procedural_entry
