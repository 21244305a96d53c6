#include "raytracer/apps/commands/analyse/raster_outputs.hpp"

#include <CLI/CLI.hpp>

#include "common/util/error.hpp"
#include "common/voxel/analysis.hpp"
#include "raytracer/analyse/report/html_report.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::commands {

namespace {

analyse::ReportFacts collect_facts(const Reported& what) {
    analyse::ReportFacts facts;
    facts.kind = what.scene.analysis.kind;
    facts.place = what.world.title;
    facts.attribution = what.world.attribution;
    facts.licence = what.world.licence;
    facts.crs = what.world.crs;
    facts.cell_m = what.grid.edge_m;
    facts.missing_boxes = what.missing_boxes;
    const bool has_period = !what.scene.analysis.from.empty();
    const voxel::AnalysisTerms& terms = voxel::find_terms(facts.kind);
    for (const auto& [path, text] : scene::field_texts(what.scene)) {
        if (terms.reads(path) && text && !(has_period && path == "sun.date"))
            facts.settings.emplace_back(path.substr(path.find('.') + 1), *text);
    }
    const auto& analysis = what.scene.analysis;
    if (analysis.kind == core::AnalysisKind::kSight)
        facts.settings.emplace_back("observers", std::to_string(analysis.observers.points.size()));
    if (!what.weather.empty()) {
        std::erase_if(facts.settings, [](const auto& one) { return one.first == "linke"; });
        facts.settings.emplace_back("weather", what.weather);
    }
    for (const std::string& text : what.additions)
        facts.settings.emplace_back("added", text);
    return facts;
}

}  // namespace

void add_report_options(CLI::App& command, ReportArguments& args) {
    command.add_option("--report", args.page,
                       "page with maps, charts and numbers to write, too: .html, one file");
    command.add_option("--map", args.map,
                       "map of the first band to write, too, with its legend: .svg");
}

void check_report_targets(const ReportArguments& args) {
    if (!args.page.empty())
        analyse::check_report_target(args.page, ".html");
    if (!args.map.empty())
        analyse::check_report_target(args.map, ".svg");
}

namespace {

/// @throws Error "interrupted" when stopped; Error when they cannot be written
void write_reports(const ReportArguments& args, analyse::CellFile& cells, const Reported& what,
                   const std::stop_token& stop) {
    const analyse::ReportFacts facts = collect_facts(what);
    if (!args.map.empty())
        analyse::write_map(cells, args.map, facts, stop);
    if (!args.page.empty())
        analyse::write_report(cells, args.page, facts, stop);
}

}  // namespace

analyse::ReliefOptions make_relief(const scene::Scene& scene) {
    const scene::Scene::Analysis& asked = scene.analysis;
    analyse::ReliefOptions out;
    out.of = asked.relief == "dsm" ? analyse::ReliefOf::kSurface : analyse::ReliefOf::kGround;
    out.window = asked.window;
    out.fill_m = asked.fill_m;
    const std::string allowed =
        "azimuth,altitude in degrees: 0 to 360 clockwise from north, and 0 to 90";
    const auto light = list_numbers("analyse", "--light", asked.relief_light, 2, allowed);
    if (light.size() != 2 || light[0] < 0 || light[0] > 360 || light[1] < 0 || light[1] > 90)
        throw util::UsageError("analyse: --light " + asked.relief_light + "; allowed: " + allowed);
    out.light_azimuth_deg = light[0];
    out.light_altitude_deg = light[1];
    if (out.window % 2 == 0)
        throw util::UsageError("analyse: --window " + std::to_string(out.window) +
                               "; allowed: odd numbers of cells, 3 to 101");
    return out;
}

std::optional<analyse::SightSummary> write_outputs(analyse::CellFile& cells,
                                                   const RasterOutputs& outputs,
                                                   const Reported& what, output::PictureInfo info,
                                                   int threads, const std::stop_token& stop) {
    const core::AnalysisKind kind = what.scene.analysis.kind;
    std::optional<analyse::SightSummary> seen;
    if (kind == core::AnalysisKind::kTerrain)
        analyse::derive_terrain(cells, what.grid.edge_m, make_relief(what.scene), stop);
    if (kind == core::AnalysisKind::kSight)
        seen = analyse::make_summary(cells, what.grid.edge_m);
    info.geo = analyse::make_placement(what.grid, what.world);
    analyse::write_raster(cells, outputs.file, info, threads);
    if (outputs.objects)
        outputs.objects->write(cells, stop);
    write_reports(outputs.reports, cells, what, stop);
    return seen;
}

}  // namespace terravox::commands
