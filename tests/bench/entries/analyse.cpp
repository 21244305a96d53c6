#include "tests/bench/programs.hpp"

namespace terravox::bench::analyse_entry {
namespace {

struct Analysis {
    const char* name;
    std::vector<std::string> arguments;
    Target target;
};

std::vector<Analysis> analyses() {
    const std::vector<std::string> year = {"--from",     "2026-01-01", "--to",
                                           "2026-12-31", "--step-min", "30"};
    return {{"sky", {"--directions", "153"}, {}},
            {"sight", {"--observer", "462500,101500,+30", "--target-height", "1.75"}, {}},
            {"sun", year, at_most(120)},
            {"energy", year, at_most(120)}};
}

void measure(const Context& c, const Analysis& of, Readings& readings) {
    std::vector<std::string> command = {
        (c.programs / "terravox-raytracer").string(),
        "analyse",
        of.name,
        demo_survey(c).string(),
        "--cache",
        (c.scratch / "analyse-cache").string(),
        "--threads",
        std::to_string(c.threads),
        "--quiet",
        "-o",
        (c.scratch / (std::string("analyse-") + of.name + ".tif")).string()};
    command.insert(command.end(), of.arguments.begin(), of.arguments.end());
    const ChildOutcome outcome = run_program(c, command, c.scratch / "analyse.txt");
    readings.add(std::string(of.name) + ": CPU", "s", outcome.user_s + outcome.system_s, of.target);
    readings.add(std::string(of.name) + ": peak memory", "MiB",
                 static_cast<double>(outcome.peak_kib) / 1024);
}

Entry entry() {
    Entry out;
    out.name = "analyse";
    out.measures =
        "processor time and memory of analyses by the real program: sky with 153 directions, what "
        "one observer sees, sun and energy of a year in half hours";
    out.work = "the demo's place (synthetic, 1 km2, 10^6 cells, prepared), N threads";
    out.missing = [](const Context& c) {
        return missing_programs(c, {"terravox-raytracer", "terravox-survey"});
    };
    out.prepare = [](const Context& c) -> Body {
        Readings ignored;
        measure(c, {"terrain", {}, {}}, ignored);  // prepares the square
        return [&c](Readings& readings) {
            for (const Analysis& of : analyses())
                measure(c, of, readings);
        };
    };
    out.exact = true;  // minutes: many cells are a mean of their own
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::analyse_entry
