#include "tests/bench/entries/square_photo.hpp"
#include "tests/bench/serve_script.hpp"

namespace terravox::bench::paper_figures_entry {
namespace {

std::string missing(const Context& c) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(c.programs / "terravox-raytracer", ignored))
        return "no terravox-raytracer in " + c.programs.string() + " (--programs)";
    return missing_for_serving(c);
}

void run(const Context& c, Readings& readings) {
    const auto folder =
        c.programs.parent_path() / "figures";  // next to the programs: the scratch folder goes away
    std::vector<std::string> arguments = {"--output", folder.string()};
    if (square_and_photo_missing(c).empty())
        arguments.insert(arguments.end(), {"--ortho", square_photo(c).string()});
    const nlohmann::json figures = run_script(c, "paper/figures", arguments);
    for (const auto& reading : figures.at("readings"))
        readings.add(reading.at(0).get<std::string>(), reading.at(1).get<std::string>(),
                     reading.at(2).get<double>());
    readings.note("drawings in " + folder.string());
}

Entry entry() {
    Entry out;
    out.name = "paper/figures";
    out.measures =
        "the first system's figures 7 to 9, measured again and drawn: time against size of tile, "
        "by processor over runs, steps of a box";
    out.work =
        "the benchmark square with its photo, or a synthetic survey of 1 km; 1280x720; by the real "
        "program, cold and with prepared squares";
    out.missing = missing;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) { run(c, readings); };
    };
    out.exact = true;  // the script repeats
    out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::paper_figures_entry
