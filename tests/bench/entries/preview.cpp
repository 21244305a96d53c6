#include "tests/bench/programs.hpp"

namespace terravox::bench::preview_entry {
namespace {

Entry latency() {
    Entry out;
    out.name = "preview/latency";
    out.measures =
        "the preview window while one flies: time until the whole picture has changed, and of a "
        "frame; by green alone, and with a thread";
    out.work =
        "the demo scene in a window of 1280x720 under Xvfb, OpenGL in software, keys and mouse by "
        "xdotool; boxes in memory";
    out.missing = [](const Context& c) { return missing_for_serving(c, {"Xvfb", "xdotool"}); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "preview/latency", {});
            for (const std::string who : {"green", "thread"}) {
                const auto add = [&](const char* metric, const char* unit, const char* name,
                                     Target target = {}) {
                    readings.add(who + ": " + metric, unit,
                                 figures.at(who + "_" + name).get<double>(), target);
                };
                add("pictures", "", "pictures", at_least(100));
                add("from a move to the first whole picture, median", "s", "first_median_s",
                    at_most(0.1));
                add("the same, p99", "s", "first_p99_s");
                add("ending the picture before, p99", "s", "stop_p99_s", at_most(0.02));
                add("frame, median", "s", "frame_median_s", at_most(1.0 / 50));
                add("frame, p95", "s", "frame_p95_s");
                add("memory", "MiB", "memory_mib");
            }
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{latency()}; });

}  // namespace
}  // namespace terravox::bench::preview_entry
