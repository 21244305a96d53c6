#include "tests/bench/entries/data_sets.hpp"

namespace terravox::bench::laszip_decode_entry {
namespace {

Entry entry_for(const DataSet& set) {
    Entry out;
    out.name = "laszip/decode/" + set.id;
    out.measures =
        "bare LASzip decoding with 1 and N threads: the floor of everything that uses the points";
    out.work = "every point of " + set.facts + ", decoded and dropped";
    out.missing = [&set](const Context& c) { return set.missing(c); };
    out.prepare = [&set](const Context& c) -> Body {
        const auto floor = std::make_shared<DecodeFloor>(set.paths(c));
        return [floor, threads = c.threads](Readings& readings) {
            const auto points = static_cast<double>(floor->points());
            const double alone = floor->seconds(1);
            const double together = floor->seconds(threads);
            readings.add("time 1t", "s", alone);
            readings.add("time Nt", "s", together);
            readings.add("rate 1t", "Mpoint/s", points / alone / 1e6);
            readings.add("rate Nt", "Mpoint/s", points / together / 1e6);
        };
    };
    return out;
}

const Registration kRegistered([] {
    return std::vector{entry_for(delft()), entry_for(montpellier()), entry_for(square())};
});

}  // namespace
}  // namespace terravox::bench::laszip_decode_entry
