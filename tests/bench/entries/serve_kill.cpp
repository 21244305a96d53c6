#include "tests/bench/serve_script.hpp"

namespace terravox::bench::serve_kill_entry {
namespace {

Entry entry() {
    Entry out;
    out.name = "serve/kill";
    out.measures =
        "kill -9 while boxes are made and written: boxes served before and after that are not "
        "those of an uninterrupted server";
    out.work =
        "200 kills at seeded points of its work, one in three of them during the start after "
        "another, every box of a synthetic square compared after each";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_serve_script(c, "kill", {"--kills", "200"});
            const auto value = [&](const char* name) { return figures.at(name).get<double>(); };
            readings.add("kills", "times", value("kills"), at_least(200));
            readings.add("corrupt", "boxes", value("corrupt"), at_most(0));
            readings.add("compared", "boxes", value("compared"));
            readings.add("of them from disk after a kill", "boxes", value("from_disk"));
            readings.add("wall", "s", value("wall_s"));
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::serve_kill_entry
