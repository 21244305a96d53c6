#include <unistd.h>

#include "tests/bench/programs.hpp"

namespace terravox::bench::farm_entry {
namespace {

Entry scale() {
    Entry out;
    out.name = "farm/scale";
    out.measures =
        "one picture by green, threads and socket workers: time of the tracing, efficiency against "
        "threads and against one worker";
    out.work =
        "640x360 paths of 64 samples of a synthetic square of 512 m; workers on loopback, then 1 "
        "to 12 that have 14 % of a core each (control groups; as root)";
    out.missing = [](const Context& c) {
        return geteuid() == 0 ? missing_for_serving(c)
                              : std::string("shares of a core, by control groups, need root");
    };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "farm/scale", {"--runs", "10"});
            const auto add = [&](const char* metric, const char* unit, const char* name,
                                 Target target = {}) {
                readings.add(metric, unit, figures.at(name).get<double>(), target);
            };
            add("green", "s", "green_s");
            add("1 thread", "s", "threads_1_s");
            add("2 threads", "s", "threads_2_s");
            add("2 workers, cold", "s", "workers_2_cold_s");
            add("2 workers, warm", "s", "workers_2_s");
            add("efficiency of 2 workers against 2 threads", "", "loopback_efficiency",
                at_least(0.95));
            for (const std::string count : {"1", "2", "4", "6", "12"}) {
                readings.add(count + " workers of a share", "s",
                             figures.at("shared_" + count + "_s").get<double>());
                readings.add("efficiency of " + count, "",
                             figures.at("shared_" + count + "_efficiency").get<double>(),
                             at_least(0.9));
            }
            add("different pictures", "", "pictures", at_most(1));
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{scale()}; });

}  // namespace
}  // namespace terravox::bench::farm_entry
