#include <algorithm>
#include <fstream>

#include "common/util/error.hpp"
#include "tests/bench/entries/data_sets.hpp"
#include "tests/bench/programs.hpp"

namespace terravox::bench::render_entry {
namespace {

/// The useful figures of the ray tracer's --report.
void add_report(const std::filesystem::path& file, double wall_s, Readings& readings) {
    std::ifstream in(file);
    const auto report = nlohmann::json::parse(in);
    const double inside = report.at("seconds").get<double>();
    readings.add("start and end of the process", "s", wall_s - inside);
    for (const auto& stage : report.at("stages"))
        readings.add("stage: " + stage.at("name").get<std::string>(), "s",
                     stage.at("seconds").get<double>());
    readings.add("rays", "million", report.at("rays").get<double>() / 1e6);
    if (const auto holes = report.at("holes").get<int>(); holes != 0)
        throw util::Error("render: the picture has " + std::to_string(holes) + " holes");
}

std::vector<std::string> command_for(const DataSet& set, const Context& c,
                                     const std::vector<std::string>& endings,
                                     const std::filesystem::path& report) {
    std::vector<std::string> out = {(c.programs / "terravox-raytracer").string(), "render",
                                    "--cache", "none"};
    for (const auto& file : set.paths(c))
        out.push_back(file.string());
    for (const auto& photo : set.orthophoto_paths(c))
        out.insert(out.end(), {"--ortho", photo.string()});
    if (!set.crs.empty())
        out.insert(out.end(), {"--crs", set.crs});
    out.insert(out.end(), {"--classes", set.classes, "--voxel", std::to_string(set.voxel_m),
                           "--size", "1280x720", "--threads", std::to_string(c.threads)});
    for (const std::string& ending : endings)
        out.insert(out.end(), {"-o", (c.scratch / (set.id + ending)).string()});
    out.insert(out.end(), {"--quiet", "--report", report.string()});
    return out;
}

void render_once(const std::vector<std::string>& command, const std::filesystem::path& report,
                 const DecodeFloor& floor, const Context& c, Readings& readings) {
    // Short for these files: the fastest of three is what the machine can do.
    const double floor_s =
        std::min({floor.seconds(c.threads), floor.seconds(c.threads), floor.seconds(c.threads)});
    const ChildOutcome outcome = run_program(c, command, c.scratch / "render.txt");
    readings.add("whole", "s", outcome.wall_s);
    readings.add("whole / LASzip Nt", "x", outcome.wall_s / floor_s);
    readings.add("LASzip Nt", "s", floor_s);
    readings.add("CPU time", "s", outcome.user_s + outcome.system_s);
    readings.add("peak memory", "MiB", static_cast<double>(outcome.peak_kib) / 1024);
    add_report(report, outcome.wall_s, readings);
}

Entry entry_for(const DataSet& set, const std::vector<std::string>& endings) {
    Entry out;
    out.name = "render/" + set.id;
    out.measures =
        "a picture from LiDAR files by the real program: wall time of the process, its stages, "
        "peak memory";
    out.work = set.facts + ", voxels of " + (set.voxel_m == 1 ? "1" : "0.5") +
               " m, 1280x720, N threads, writes";
    for (const std::string& ending : endings)
        out.work += " " + ending;
    out.floor = "LASzip decoding of the same files, N threads, the fastest of three";
    out.missing = [&set](const Context& c) {
        const std::string reason = missing_programs(c, {"terravox-raytracer"});
        return reason.empty() ? set.missing(c) : reason;
    };
    out.prepare = [&set, endings](const Context& c) -> Body {
        const auto floor = std::make_shared<DecodeFloor>(set.paths(c));
        const auto report = c.scratch / (set.id + ".json");
        return [floor, report, command = command_for(set, c, endings, report),
                &c](Readings& readings) { render_once(command, report, *floor, c, readings); };
    };
    return out;
}

const Registration kRegistered([] {
    return std::vector{entry_for(delft(), {".png", ".exr"}), entry_for(montpellier(), {".png"})};
});

}  // namespace
}  // namespace terravox::bench::render_entry
