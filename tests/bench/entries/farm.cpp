#include "tests/bench/serve_script.hpp"

namespace terravox::bench {
namespace {

Entry scale() {
    Entry out;
    out.name = "farm/scale";
    out.measures = "one picture by green, threads and socket workers: time of the tracing, efficiency against threads and against one worker";
    out.work = "640x360 paths of 24 samples of an invented square of 512 m; workers on loopback, then 1 to 12 that have 14 % of a core each (control groups; as root)";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "farm/scale", {});
            const auto add = [&](const char* metric, const char* unit, const char* name, Target target = {}) { readings.add(metric, unit, figures.at(name).get<double>(), target); };
            add("green", "s", "green_s");
            add("1 thread", "s", "threads_1_s");
            add("2 threads", "s", "threads_2_s");
            add("2 workers, cold", "s", "workers_2_cold_s");
            add("2 workers, warm", "s", "workers_2_s");
            add("efficiency of 2 workers against 2 threads", "", "loopback_efficiency", at_least(0.95));
            for (const std::string count : {"1", "2", "4", "6", "12"}) {
                readings.add(count + " workers of a share", "s", figures.at("shared_" + count + "_s").get<double>());
                readings.add("efficiency of " + count, "", figures.at("shared_" + count + "_efficiency").get<double>(), at_least(0.9));
            }
            add("different pictures", "", "pictures", at_most(1));
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

Entry kill() {
    Entry out;
    out.name = "farm/kill";
    out.measures = "kill -9 of 1 or 2 of 3 workers at random times: pictures that are not the same, and time beyond that of the workers that are left";
    out.work = "50 pictures of 320x180, seeded";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "farm/kill", {});
            const auto value = [&](const char* name) { return figures.at(name).get<double>(); };
            readings.add("pictures", "", value("runs"), at_least(50));
            readings.add("wrong", "", value("wrong"), at_most(0));
            readings.add("workers lost", "", value("lost"));
            readings.add("one core alone", "s", value("one_core_s"));
            readings.add("beyond the ideal, median", "s", value("over_median_s"), at_most(1));
            readings.add("beyond the ideal, most", "s", value("over_most_s"));
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{scale(), kill()}; });

}  // namespace
}  // namespace terravox::bench
