#include "tests/bench/serve_script.hpp"

namespace terravox::bench::country_readers_entry {
namespace {

void add_host(const nlohmann::json& of, const std::string& host, Readings& readings) {
    const auto value = [&](const char* name) { return of.at(name).get<double>(); };
    readings.add(host + ": errors and mixtures", "readers", value("errors"), at_most(0));
    readings.add(host + ": states met", "archives", value("states"), at_least(2));
    readings.add(host + ": opened", "times", value("opened"));
    readings.add(host + ": started again", "times", value("changed"));
    readings.add(host + ": waits (429, 502, 503, 504)", "times", value("waits"));
    readings.add(host + ": closed without a reply, tried again", "times", value("lost"));
    readings.add(host + ": read", "MB/s", value("mb_per_s"));
    if (const auto error = of.at("first_error").get<std::string>(); !error.empty())
        readings.note(host + ": " + error);
}

Entry entry() {
    Entry out;
    out.name = "country/readers";
    out.measures =
        "1000 readers by ranges of an archive that is patched meanwhile: what fails or is mixed of "
        "two archives; by the voxel server, by it behind config/nginx, by nginx from the file";
    out.work =
        "a synthetic survey of 6x6 squares of 256 m, one square of another flight put in and taken "
        "out again, 10 times for each host; readers with If-Match, with If-Range, and comparing";
    out.missing = [](const Context& c) { return missing_for_serving(c, {"nginx"}); };
    out.exact = out.only_by_name = true;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_serve_script(c, "readers");
            readings.add("archive", "MB", figures.at("archive_mb").get<double>());
            add_host(figures.at("server"), "server", readings);
            add_host(figures.at("front"), "behind nginx", readings);
            add_host(figures.at("files"), "nginx, files", readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::country_readers_entry
