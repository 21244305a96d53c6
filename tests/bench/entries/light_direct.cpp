#include <fstream>
#include <memory>

#include "common/util/error.hpp"
#include "tests/bench/programs.hpp"

namespace terravox::bench::light_direct_entry {
namespace {

/// The place of the demo, prepared.
struct DemoPlace {
    explicit DemoPlace(const Context& context)
        : c(context), survey(demo_survey(c)), report(c.scratch / "light-direct.json") {
        (void)render({});
    }
    ChildOutcome render(const std::vector<std::string>& arguments) const {
        std::vector<std::string> command = {(c.programs / "terravox-raytracer").string(), "render",
                                            survey.string(), "--ortho",
                                            (survey / "ortho").string()};
        command.insert(
            command.end(),
            {"--cache", (c.scratch / "light-cache").string(), "--scene",
             std::string(TERRAVOX_SOURCE_DIR) + "/config/scenes/demo.toml", "--size", "1280x720"});
        command.insert(command.end(),
                       {"--threads", std::to_string(c.threads), "--quiet", "--report",
                        report.string(), "-o", (c.scratch / "light-direct.png").string()});
        command.insert(command.end(), arguments.begin(), arguments.end());
        return run_program(c, command, c.scratch / "light-direct.txt");
    }
    const Context& c;
    std::filesystem::path survey;
    std::filesystem::path report;
};

void add_picture(const std::string& name, const DemoPlace& place,
                 const std::vector<std::string>& arguments, Readings& readings) {
    const ChildOutcome outcome = place.render(arguments);
    std::ifstream file(place.report);
    const auto report = nlohmann::json::parse(file);
    if (const auto holes = report.at("holes").get<int>(); holes != 0)
        throw util::Error("render the demo: the picture has " + std::to_string(holes) + " holes");
    readings.add(name + ": whole", "s", outcome.wall_s);
    for (const auto& stage : report.at("stages"))
        if (stage.at("name") == "ray tracing (clock)")
            readings.add(name + ": tracing", "s", stage.at("seconds").get<double>());
    double all = 0;
    for (const auto& [stage, seconds] : report.at("tracing_seconds").items())
        all += seconds.get<double>();
    readings.add(name + ": rays", "Mray/s of a thread",
                 report.at("rays").get<double>() / all / 1e6);
    for (const auto& [stage, seconds] : report.at("tracing_seconds").items())
        readings.add(name + ": " + stage, "% of tracing", 100 * seconds.get<double>() / all);
}

Entry entry() {
    Entry out;
    out.name = "light/direct";
    out.measures = "a picture in direct light by the real program: seconds, and what they go into";
    out.work =
        "the demo's place (synthetic, 1 km2, prepared) and camera, 1280x720, 4 samples, N threads: "
        "sun, sky, mirrors, water; with 8 rays of ambient occlusion; with paths of 6 bounces";
    out.missing = [](const Context& c) {
        return missing_programs(c, {"terravox-raytracer", "terravox-survey"});
    };
    out.prepare = [](const Context& c) -> Body {
        const auto place = std::make_shared<const DemoPlace>(c);
        return [place](Readings& readings) {
            add_picture("as it comes", *place, {}, readings);
            add_picture("8 ambient rays", *place, {"--ao-rays", "8"}, readings);
            add_picture("paths", *place, {"--integrator", "path"}, readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::light_direct_entry
