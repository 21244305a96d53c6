#include "tests/bench/serve_script.hpp"

namespace terravox::bench::serve_shared_entry {
namespace {

void add_load(const nlohmann::json& figures, const std::string& name, Readings& readings) {
    double one_process = 0;
    for (const char* processes : {"1", "2"}) {
        const auto& of = figures.at(name + " " + processes);
        const std::string title = name + ", processes: " + processes;
        const auto rate = of.at("rate").get<double>();
        readings.add(title, "requests/s", rate);
        readings.add(title + ": read", "MB/s", of.at("mb_per_s").get<double>());
        readings.add(title + ": p99", "ms", of.at("p99_ms").get<double>());
        readings.add(title + ": errors", "replies", of.at("errors").get<double>(), at_most(0));
        if (one_process > 0)
            readings.add(name + ": two processes / one", "x", rate / one_process);
        one_process = rate;
    }
}

Entry entry() {
    Entry out;
    out.name = "serve/shared";
    out.measures =
        "one archive behind nginx, served by one process and by two: boxes that are kept, and "
        "parts "
        "of the file of 64 KiB";
    out.work =
        "wrk with 1 thread and 64 connections, 5 s twice for each figure, in turn; config/nginx "
        "without limits; a synthetic survey of 4x4 squares of 256 m";
    out.missing = [](const Context& c) { return missing_for_serving(c, {"wrk", "nginx"}); };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_serve_script(c, "shared");
            add_load(figures, "boxes", readings);
            add_load(figures, "parts", readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::serve_shared_entry
