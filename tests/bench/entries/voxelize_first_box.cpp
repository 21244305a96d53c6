#include "common/util/error.hpp"
#include "tests/bench/clocks.hpp"
#include "tests/bench/entries/square_photo.hpp"

namespace terravox::bench::voxelize_first_box_entry {
namespace {

constexpr double kIndexed_ms = 250;
constexpr double kCopc_ms = 60;
constexpr double kPreparedBox_ms = 5;
constexpr const char* kCopcSquare = "bench/TM_462_101.copc.laz";  ///< where it has been made
constexpr const char* kCopcOther =
    "copcjs/ellipsoid.copc.laz";  ///< else a small file of another place

voxel::BoxKey find_middle(voxelize::LidarWorld& world) {
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    const std::int32_t bx = (range.min.bx + range.max.bx) / 2;
    const std::int32_t bz = (range.min.bz + range.max.bz) / 2;
    return {0, bx, world.column(0, bx, bz).by_begin, bz};
}

/// From nothing to the first box in the middle that is not air.
Cost first_box(const voxelize::LidarWorldOptions& options) {
    util::StageTimes times;
    std::unique_ptr<voxelize::LidarWorld> world;
    return measure_cost([&] {
        world = voxelize::open_lidar_world(options, times);
        voxel::BoxKey key = find_middle(*world);
        const auto extent = world->column(0, key.bx, key.bz);
        while (!world->box(key))
            if (++key.by >= extent.by_end)
                throw util::Error("make the first box: all of the middle is air");
    });
}

/// Opens the world once for what it leaves in its cache folder. @param boxes also requests every
/// box
void fill_cache(const voxelize::LidarWorldOptions& options, bool boxes) {
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options, times);
    if (boxes)
        for (const auto& key : box_keys(*world))
            static_cast<void>(world->box(key));
}

/// CPU of one box when its square is prepared on disk and open, but no box was requested before.
double prepared_box_ms(const voxelize::LidarWorldOptions& options) {
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options, times);
    std::size_t solid = 0;
    const Cost cost = measure_cost([&] {
        for (const auto& key : box_keys(*world))
            solid += world->box(key) ? 1U : 0U;
    });
    if (solid == 0)
        throw util::Error("make the boxes of the prepared square: all of them are air");
    return cost.cpu_s * 1e3 / static_cast<double>(solid);
}

struct Cases {
    voxelize::LidarWorldOptions plain;
    voxelize::LidarWorldOptions indexed;
    voxelize::LidarWorldOptions prepared;
    voxelize::LidarWorldOptions copc;
    std::string copc_name;
};

Cases make_cases(const Context& c) {
    Cases out;
    out.plain = out.indexed = out.prepared = square_options(c, c.threads);
    out.indexed.cache_dir = c.scratch / "first-box-indexed";
    out.prepared.cache_dir = c.scratch / "first-box-prepared";
    for (const auto* options : {&out.indexed, &out.prepared})
        std::filesystem::create_directories(options->cache_dir);
    fill_cache(out.prepared, true);
    std::error_code ignored;
    if (std::filesystem::is_regular_file(c.data / kCopcSquare, ignored)) {
        out.copc = out.plain;
        out.copc.files = {c.data / kCopcSquare};
        out.copc_name = "COPC of the square";
    } else if (std::filesystem::is_regular_file(c.data / kCopcOther, ignored)) {
        out.copc.files = {c.data / kCopcOther};
        out.copc.threads = c.threads;
        out.copc_name = std::string("COPC, ") + kCopcOther;
    }
    return out;
}

Entry entry() {
    Entry out;
    out.name = "voxelize/first-box";
    out.measures = "a new world until its first box, in the middle; and a box of a prepared square";
    out.work = square().facts +
               " with its orthophoto, N threads: nothing cached; with the chunk index alone; "
               "prepared on disk; COPC";
    out.missing = square_and_photo_missing;
    out.prepare = [](const Context& c) -> Body {
        const auto cases = std::make_shared<Cases>(make_cases(c));
        return [cases](Readings& readings) {
            const auto add = [&](const std::string& what,
                                 const voxelize::LidarWorldOptions& options, Target target) {
                const Cost cost = first_box(options);
                readings.add("first box: " + what, "ms", cost.wall_s * 1e3, target);
                readings.add("first box: " + what + ": CPU", "ms", cost.cpu_s * 1e3);
            };
            add("plain LAZ, nothing cached", cases->plain, {});
            // What is left when the folder's limit has driven the prepared square out: its chunk
            // index.
            fill_cache(cases->indexed, true);
            for (const auto& file :
                 std::filesystem::recursive_directory_iterator(cases->indexed.cache_dir))
                if (file.path().extension() == ".square")
                    std::filesystem::remove(file.path());
            add("plain LAZ with its chunk index", cases->indexed, at_most(kIndexed_ms));
            add("prepared square on disk", cases->prepared, {});
            if (!cases->copc.files.empty())
                add(cases->copc_name, cases->copc, at_most(kCopc_ms));
            readings.add("any box of a prepared square: CPU", "ms/box",
                         prepared_box_ms(cases->prepared), at_most(kPreparedBox_ms));
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::voxelize_first_box_entry
