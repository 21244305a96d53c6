#include "tests/bench/programs.hpp"

namespace terravox::bench::grab_throughput_entry {
namespace {

Entry entry() {
    Entry out;
    out.name = "grab/throughput";
    out.measures =
        "the grabber and curl fetch the same list, four files at a time, in turns; the grabber "
        "also hashes, checks, records and syncs";
    out.work =
        "24 files of 25 MB and 4000 of 50 kB from this machine; 150 of 2 MB from a server that "
        "paces each body to 8 MB/s";
    out.floor = "curl";
    out.missing = [](const Context&) { return missing_for_grabbing(); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto add = [&readings](const nlohmann::json& figures, const char* list,
                                         const std::string& shown) {
                const auto value = [&](const char* name) {
                    return figures.at(list).at(name).get<double>();
                };
                readings.add(shown + ": curl", "s", value("curl_s"));
                readings.add(shown + ": grabber", "s", value("grabber_s"));
                readings.add(shown + ": curl / grabber", "x", value("ratio"), at_least(0.9));
                readings.add(shown + ": curl and sync / grabber", "x", value("ratio_sync"));
            };
            const auto near =
                run_script(c, "grab/throughput", {"--rounds", "3", "--lists", "large,small"});
            add(near, "large", "large files");
            add(near, "small", "small files");
            add(run_script(c, "grab/throughput",
                           {"--rounds", "3", "--lists", "middle", "--rate", "8000000"}),
                "middle", "paced server");
        };
    };
    out.exact = true;  // the script repeats
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::grab_throughput_entry
