#include "tests/bench/programs.hpp"

namespace terravox::bench::serve_cached_entry {
namespace {

void add_variant(const nlohmann::json& figures, const std::string& name, bool is_target,
                 Readings& readings) {
    const auto& of = figures.at(name);
    if (of.is_null())
        return;  // the server has one form of a box
    const auto& server = of.at("server");
    const auto& nginx = of.at("nginx");
    const auto ours = server.at("rate").get<double>();
    const auto theirs = nginx.at("rate").get<double>();
    readings.add(name + ": server", "requests/s", ours);
    readings.add(name + ": nginx", "requests/s", theirs);
    readings.add(name + ": server / nginx", "x", ours / theirs,
                 is_target ? at_least(0.5) : Target{});
    readings.add(name + ": p99, server", "ms", server.at("p99_ms").get<double>(),
                 is_target ? at_most(10) : Target{});
    readings.add(name + ": p99, nginx", "ms", nginx.at("p99_ms").get<double>());
    readings.add(name + ": errors", "replies", server.at("errors").get<double>(), at_most(0));
    if (is_target)
        readings.add("mean box", "bytes", of.at("bytes").get<double>());
}

Entry entry() {
    Entry out;
    out.name = "serve/cached";
    out.measures =
        "cached boxes over HTTP: requests a second and the slowest percent, beside nginx with the "
        "same bytes from files; 304s; "
        "boxes undone for clients without zstd";
    out.work =
        "wrk with 2 threads, 64 connections, 16 boxes in turn, 4 s for each server and variant, in "
        "turns of 2 s";
    out.floor = "nginx: sendfile, open_file_cache, kept connections, no log";
    out.missing = [](const Context& c) { return missing_for_serving(c, {"wrk", "nginx"}); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "serve/cached", {"--seconds", "4"});
            add_variant(figures, "boxes", true, readings);
            add_variant(figures, "304", false, readings);
            add_variant(figures, "identity", false, readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::serve_cached_entry
