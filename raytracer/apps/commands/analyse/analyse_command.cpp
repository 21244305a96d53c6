#include <CLI/CLI.hpp>

#include <list>
#include <memory>

#include "common/voxel/analysis.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/apps/commands/analyse/analyse_run.hpp"
#include "raytracer/apps/commands/analyse/raster_outputs.hpp"
#include "raytracer/apps/commands/analyse/sun_arguments.hpp"

namespace terravox::commands {
namespace {

CLI::App* add_kind(CLI::App& group, AnalyseArguments& args, const voxel::AnalysisTerms& terms) {
    CLI::App* command = group.add_subcommand(std::string(terms.name), std::string(terms.help));
    command->add_option("inputs", args.world.inputs, world_inputs_help())->required();
    command->add_option("-o,--output", args.output, "raster to write: a Cloud Optimized GeoTIFF")
        ->required();
    add_grid_arguments(*command, args.grid);
    command
        ->add_option("--level", args.level,
                     "level of the world's voxels; default: the coarsest whose voxels are no "
                     "larger than a cell")
        ->check(CLI::Range(0, 20));
    command->add_flag("--resume", args.resume,
                      "keep finished tiles in OUT.tif.tiles until the raster is finished, and go "
                      "on with those that are there");
    command->add_option("--part", args.part,
                        "I/N: only part I of N of the tiles, kept for terravox merge; no raster");
    add_report_options(*command, args.reports);
    add_verbosity_flags(*command, args.verbosity);
    std::vector<std::string> sections(terms.fields.begin(), terms.fields.end());
    std::erase(sections, "");
    sections.insert(sections.end(), {"world", "generated", "processing", "quality.tile"});
    add_opening_arguments(*command, args.world, sections);
    add_render_pool_arguments(*command, args.render_pool);
    return command;
}

void add_sight_options(CLI::App& command, AnalyseArguments& args) {
    allow_several(command.add_option(
        "--observer", args.observers.texts,
        std::string("who looks; may be given several times: ") + kObserverForms));
    allow_several(command.add_option("--observers", args.observers.files, kObserverFileForm));
    command
        .add_option("--observer-step-m", args.observers.step_m,
                    "distance of the observers on a line, metres")
        ->check(CLI::Range(0.1, 1e5))
        ->capture_default_str();
    command.add_flag("--json", args.as_json,
                     "print what is seen, by material and class, as one JSON object");
}

}  // namespace

std::function<util::ExitCode()> add_analyse_command(CLI::App& app) {
    CLI::App* group = app.add_subcommand("analyse", "Measure a world: rasters for GIS, as GeoTIFF");
    group->require_subcommand(1);
    struct Kind {
        core::AnalysisKind kind;
        AnalyseArguments args{};
        CLI::App* command = nullptr;
    };
    using core::AnalysisKind;
    const auto kinds = std::make_shared<std::list<Kind>>();
    for (const voxel::AnalysisTerms& terms : voxel::kAnalyses) {
        if (terms.help.empty())
            continue;
        Kind& kind = kinds->emplace_back(Kind{terms.kind});
        kind.command = add_kind(*group, kind.args, terms);
        if (terms.kind == AnalysisKind::kSun)
            add_sun_options(*kind.command, kind.args.sun);
        if (analyse::find_analysis(terms.kind).sky != analyse::SkyUse::kNone)
            add_horizon_options(*kind.command, kind.args.horizon);
        if (terms.kind == AnalysisKind::kEnergy) {
            add_weather_option(*kind.command, kind.args.weather);
            add_object_options(*kind.command, kind.args.objects);
            add_facade_options(*kind.command, kind.args.facades);
        }
        if (terms.kind == AnalysisKind::kSight)
            add_sight_options(*kind.command, kind.args);
    }
    return [kinds] {
        for (const Kind& kind : *kinds)
            if (kind.command->parsed())
                return run_analyse(kind.args, kind.kind);
        throw util::UsageError("analyse: no kind; --help lists them");
    };
}

}  // namespace terravox::commands
