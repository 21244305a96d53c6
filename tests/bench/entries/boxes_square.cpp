#include <atomic>

#include "common/thread/parallel.hpp"
#include "tests/bench/entries/data_sets.hpp"

namespace terravox::bench::boxes_square_entry {
namespace {

struct Pass {
    double seconds = 0;
    std::size_t boxes = 0;  ///< that hold anything
};

Pass ask_all(voxel::World& world, const std::vector<voxel::BoxKey>& keys, int threads) {
    std::atomic<std::size_t> solid{0};
    Pass out;
    out.seconds = seconds_of([&] {
        thread::parallel_for(keys.size(), threads, [&](std::size_t i) {
            if (world.box(keys[i]))
                ++solid;
        });
    });
    out.boxes = solid;
    return out;
}

/// Opens the square and requests every box twice. @param label "1t" or "Nt"
void measure_threads(const Context& c, const DecodeFloor& floor, int threads,
                     const std::string& label, Readings& readings) {
    const double floor_s = floor.seconds(threads);
    OpenWorld opened;
    const double open_s = seconds_of([&] { opened = open_data_set(square(), c, threads); });
    const auto keys = box_keys(*opened.world);
    const Pass cold = ask_all(*opened.world, keys, threads);
    const Pass cached = ask_all(*opened.world, keys, threads);
    const auto boxes = static_cast<double>(cold.boxes);
    const double whole_s = open_s + cold.seconds;
    readings.add("boxes " + label, "boxes", boxes);
    readings.add("open " + label, "s", open_s);
    readings.add("box, once open " + label, "ms/box", cold.seconds * 1e3 / boxes);
    readings.add("box, opening included " + label, "ms/box", whole_s * 1e3 / boxes);
    readings.add("boxes, opening included " + label, "boxes/s", boxes / whole_s);
    readings.add("box, cached " + label, "us/box", cached.seconds * 1e6 / boxes);
    readings.add("whole / LASzip " + label, "x", whole_s / floor_s);
}

Entry entry() {
    Entry out;
    out.name = "boxes/square";
    out.measures =
        "all level-0 boxes of a square by library calls: cold caches (warm page cache), then again "
        "from memory";
    out.work =
        square().facts + ": open the world, every box once, every box again; 1 and N threads";
    out.floor = "LASzip decoding of the same file with as many threads";
    out.missing = [](const Context& c) { return square().missing(c); };
    out.prepare = [](const Context& c) -> Body {
        const auto floor = std::make_shared<DecodeFloor>(square().paths(c));
        return [floor, &c](Readings& readings) {
            measure_threads(c, *floor, 1, "1t", readings);
            measure_threads(c, *floor, c.threads, "Nt", readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::boxes_square_entry
