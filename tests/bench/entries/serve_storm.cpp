#include "tests/bench/serve_script.hpp"

namespace terravox::bench::serve_storm_entry {
namespace {

Entry entry() {
    Entry out;
    out.name = "serve/storm";
    out.measures =
        "many clients ask for one box that nobody made, at once: how often it is made, what fails, "
        "how long it takes until all have it";
    out.work =
        "1000 connections, one request each, a synthetic square of 512 m, nothing on disk; 503s "
        "are sent again when Retry-After says";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_serve_script(c, "storm", {"--clients", "1000"});
            const auto value = [&](const char* name) { return figures.at(name).get<double>(); };
            readings.add("made", "times", value("made"), at_most(1));
            readings.add("errors", "replies", value("errors"), at_most(0));
            readings.add("503", "replies", value("busy"));
            readings.add("first reply", "s", value("first_s"));
            readings.add("p99", "s", value("p99_s"));
            readings.add("wall", "s", value("wall_s"));
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::serve_storm_entry
