#include <fstream>

#include "common/util/error.hpp"
#include "tests/bench/entries/square_photo.hpp"
#include "tests/bench/paper/box_sizes.hpp"
#include "tests/bench/serve_script.hpp"

namespace terravox::bench::paper_figures_entry {
namespace {

std::string missing(const Context& c) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(c.programs / "terravox-raytracer", ignored))
        return "no terravox-raytracer in " + c.programs.string() + " (--programs)";
    return missing_for_serving(c);
}

/// With the camera of the paper, a bird's eye about 500 m above the town: SQUARE_CAMERA of
/// paper/figures.py.
scene::Scene paper_scene() {
    scene::Scene out;
    out.camera.position = {{462500, 101050, 800}};
    out.camera.target = {{462500, 101450, 300}};
    return out;
}

/// Figure 6, for the script to draw.
std::filesystem::path write_box_sizes(const Context& c, Readings& readings) {
    constexpr int kRounds = 3;
    constexpr double kMebi = 1 << 20;
    const OpenWorld opened = open_data_set(square(), c, c.threads);
    nlohmann::json sizes = nlohmann::json::array();
    for (const BoxSize& size : measure_box_sizes(*opened.world, paper_scene(), kRounds)) {
        const std::string name = "boxes of " + std::to_string(size.edge_voxels) + ": ";
        readings.add(name + "count", "boxes", static_cast<double>(size.boxes));
        readings.add(name + "trees", "MiB", size.tree_bytes / kMebi);
        readings.add(name + "steps", "steps/ray", size.steps);
        sizes.push_back(
            {{"edge", size.edge_voxels}, {"make_s", size.make_s}, {"walk_s", size.walk_s}});
    }
    const std::filesystem::path file = c.scratch / "box-sizes.json";
    std::ofstream out(file);
    out << sizes.dump();
    out.close();
    if (!out)
        throw util::Error("write " + file.string() + ": the disk is full or not writable");
    return file;
}

void run(const Context& c, Readings& readings) {
    const auto folder =
        c.programs.parent_path() / "figures";  // next to the programs: the scratch folder goes away
    std::vector<std::string> arguments = {"--output", folder.string()};
    if (square().missing(c).empty())
        arguments.insert(arguments.end(), {"--box-sizes", write_box_sizes(c, readings).string()});
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
        "the first system's figures 6 to 9, measured again and drawn: time against size of boxes "
        "and of tiles, by processor over runs, steps of a box";
    out.work =
        "the benchmark square with its photo, or a synthetic survey of 1 km; 1280x720; by the real "
        "program, cold and with prepared squares; sizes of boxes by a walker of the benchmark's "
        "own, on the square alone";
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
