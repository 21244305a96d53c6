#include <filesystem>
#include <string>

#include "tests/bench/serve_script.hpp"

namespace terravox::bench::library_python_entry {
namespace {

std::string missing(const Context& c) {
    std::error_code ignored;
    for (const char* program : {"terravox-convert", "library_rates"})
        if (!std::filesystem::is_regular_file(c.programs / program, ignored))
            return std::string("no ") + program + " in " + c.programs.string() + " (--programs)";
    const auto package = python_package(c) / "terravox";
    if (package_python().empty() || !std::filesystem::is_directory(package, ignored))
        return "no " + package.string() + " (a build without -DTERRAVOX_PYTHON=OFF makes it)";
    return missing_for_serving(c);
}

void run(const Context& c, Readings& readings) {
    const nlohmann::json figures = run_script(c, "library/python_rates", {}, package_python());
    const auto value = [&](const std::string& name) { return figures.at(name).get<double>(); };
    readings.add("surface of an archive just opened", "ms", value("opening_ms"), at_most(100));
    for (const std::string threads : {"1", "2"}) {
        const std::string after = ", " + threads + "t";
        readings.add("cast" + after, "Mrays/s", value("cast_" + threads + "_mrays"));
        readings.add("cast" + after + " / C++", "", value("cast_" + threads + "_of_library"),
                     at_least(0.9));
        readings.add("surface" + after, "ms", value("surface_" + threads + "_ms"));
        readings.add("surface" + after + " / C++", "", value("surface_" + threads + "_of_library"));
    }
    readings.add("cast, 2t / 1t", "", value("speedup"), at_least(1.8));
    readings.add("cast, 2t / 1t, by processor time", "", value("speedup_processor"));
    readings.add("cast, 2t / 1t, C++", "", value("speedup_library"));
    readings.add("cast, two processes of C++ / one", "", value("speedup_processes"));
    readings.add("cast, 2t / 1t, to that of two processes", "",
                 value("speedup") / value("speedup_processes"));
}

Entry entry() {
    Entry out;
    out.name = "library/python";
    out.measures =
        "rays and surfaces from Python, next to the C++ library in the same run; what a second "
        "thread brings, next to what a second process brings";
    out.work =
        "a synthetic square of 1 km as an archive; a million rays from above it in random "
        "directions, 7 rounds in turns, the best of each";
    out.missing = missing;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) { run(c, readings); };
    };
    out.exact = true;  // the script repeats
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::library_python_entry
