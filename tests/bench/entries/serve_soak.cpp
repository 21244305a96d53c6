#include "tests/bench/serve_script.hpp"

namespace terravox::bench::serve_soak_entry {
namespace {

constexpr int kMemory_mib = 256;

void add_times(const nlohmann::json& figures, Readings& readings) {
    for (const char* share : {"p50_ms", "p99_ms"})
        for (const auto& [kind, ms] : figures.at(share).items())
            readings.add(std::string(share, 3) + ": " + kind, "ms", ms.get<double>());
}

Entry entry_for(const std::string& minutes) {
    Entry out;
    out.name = "serve/soak/" + minutes + "min";
    out.measures =
        "mixed load on a world larger than the memory limit: resident memory, errors, times of "
        "each kind of request";
    out.work = minutes + " minutes, 6 clients, --memory-mib " + std::to_string(kMemory_mib) +
               ", 16 synthetic squares of 512 m: boxes of all levels, columns, map tiles, batches, "
               "304s, bad requests; a box must always be the same bytes";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [minutes](const Context& c) -> Body {
        return [minutes, &c](Readings& readings) {
            const auto figures = run_serve_script(
                c, "soak", {"--minutes", minutes, "--memory-mib", std::to_string(kMemory_mib)});
            const auto value = [&](const char* name) { return figures.at(name).get<double>(); };
            readings.add("resident memory, peak", "MiB", value("peak_mib"));
            readings.add("peak / limit", "x", value("peak_mib") / value("limit_mib"), at_most(1.1));
            readings.add("second half / first half", "x", value("growth"), at_most(1.1));
            readings.add("errors", "replies", value("errors"), at_most(0));
            readings.add("503", "replies", value("busy"));
            readings.add("requests", "requests", value("requests"));
            readings.add("rate", "requests/s", value("requests") / value("seconds"));
            readings.add("open descriptors, most", "files", value("descriptors"));
            add_times(figures, readings);
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{entry_for("1"), entry_for("10")}; });

}  // namespace
}  // namespace terravox::bench::serve_soak_entry
