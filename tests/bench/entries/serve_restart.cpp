#include "tests/bench/programs.hpp"

namespace terravox::bench::serve_restart_entry {
namespace {

Entry entry() {
    Entry out;
    out.name = "serve/restart";
    out.measures =
        "a server that starts with its boxes on disk: from exec to listening, and to the first "
        "whole box (medians and worst of the starts)";
    out.work =
        "20 starts on the benchmark square (a synthetic one where it is missing), prepared and its "
        "boxes made before";
    out.floor = "the same program asked for its version: what the dynamic loader takes";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "serve/restart", {"--starts", "20"});
            const auto value = [&](const char* name) { return figures.at(name).get<double>(); };
            readings.add("exec to the end of --version", "ms", value("version_ms"));
            readings.add("exec to listening", "ms", value("listening_ms"));
            readings.add("exec to listening, worst", "ms", value("listening_worst_ms"));
            readings.add("exec to the first box", "ms", value("reply_ms"), at_most(20));
            readings.add("exec to the first box, worst", "ms", value("reply_worst_ms"));
            readings.add("listening to the first box", "ms", value("box_ms"));
            readings.add("boxes from disk", "of 20", value("from_disk"), at_least(value("starts")));
            readings.add("other bytes than before", "replies", value("other_replies"), at_most(0));
        };
    };
    out.exact = true;  // the script repeats
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::serve_restart_entry
