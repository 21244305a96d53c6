#include <memory>
#include <string>

#include "tests/bench/accuracy/measures.hpp"
#include "tests/bench/entries/data_sets.hpp"

namespace terravox::bench::accuracy_strangers_entry {
namespace {

using Measure = void (*)(const VoxelField&, Readings&);

Entry entry(const DataSet& set, Measure measure, const std::string& measures) {
    Entry out;
    out.name = "accuracy/strangers/" + set.id;
    out.measures = measures;
    out.work = set.facts + ", voxels of 1 m";
    out.missing = [&set](const Context& c) { return set.missing(c); };
    out.exact = true;
    out.prepare = [&set, measure](const Context& c) -> Body {
        return [&set, measure, &c](Readings& readings) {
            const OpenWorld open = open_data_set(set, c, c.threads);
            const auto [low, high] = open.world->info().bounds;
            const Area area{low[0], -std::int64_t{low[2]}, high[0] - low[0], high[2] - low[2]};
            measure({*open.world, area, c.threads}, readings);
        };
    };
    return out;
}

std::vector<Entry> entries() {
    static const DataSet town{
        "sevilla",
        "102,565 points of an old town, 180 m square, half of them of class 12 (overlap)",
        {"pnoa-sevilla/PlazaNueva.laz"},
        {},
        "",
        "asprs",
        1};
    static const DataSet park{"autzen",
                              "110,000 points of classes 1 and 2, 359 x 172 m",
                              {"pdal/las/autzen_trim.las"},
                              {},
                              "",
                              "asprs",
                              1};
    return {entry(town, measure_facades, "faces of walls and roofs next to air or leaves: leaves"),
            entry(park, measure_crowns, "trunks under the crowns of a sparse survey")};
}

const Registration kRegistered(entries);

}  // namespace
}  // namespace terravox::bench::accuracy_strangers_entry
