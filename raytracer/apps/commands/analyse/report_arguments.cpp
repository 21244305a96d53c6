#include "raytracer/apps/commands/analyse/report_arguments.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>

#include "raytracer/analyse/report/html_report.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::commands {
namespace {

analyse::ReportFacts facts_of(const Reported& what) {
    analyse::ReportFacts facts;
    facts.kind = what.scene.analysis.kind;
    facts.place = what.world.title;
    facts.attribution = what.world.attribution;
    facts.licence = what.world.licence;
    facts.crs = what.world.crs;
    facts.cell_m = what.grid.edge_m;
    facts.missing_boxes = what.missing_boxes;
    const bool has_period = !what.scene.analysis.from.empty();
    for (const auto& [path, text] : scene::field_texts(what.scene)) {
        const bool is_own =
            std::find(what.fields.begin(), what.fields.end(), path) != what.fields.end();
        if (is_own && text && !(has_period && path == "sun.date"))
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
                       "map of the first band to write, too, with its legend: .png");
}

void check_report_targets(const ReportArguments& args) {
    if (!args.page.empty())
        analyse::check_report_target(args.page, ".html");
    if (!args.map.empty())
        analyse::check_report_target(args.map, ".png");
}

void write_reports(const ReportArguments& args, analyse::CellFile& cells, const Reported& what,
                   const std::stop_token& stop) {
    const analyse::ReportFacts facts = facts_of(what);
    if (!args.map.empty())
        analyse::write_map(cells, args.map, facts, stop);
    if (!args.page.empty())
        analyse::write_report(cells, args.page, facts, stop);
}

}  // namespace terravox::commands
