#include "raytracer/apps/commands/merge/joined_raster.hpp"

#include <CLI/CLI.hpp>

#include <array>
#include <cstdio>
#include <optional>
#include <string_view>
#include <utility>

#include "common/thread/stop_signals.hpp"
#include "common/util/log.hpp"
#include "common/voxel/world_json.hpp"
#include "raytracer/analyse/raster/raster.hpp"
#include "raytracer/apps/commands/analyse/own_fields.hpp"
#include "raytracer/apps/commands/analyse/raster_outputs.hpp"
#include "raytracer/apps/commands/run_report.hpp"
#include "raytracer/farm/render/joined_pictures.hpp"

namespace terravox::commands {
namespace {

using core::AnalysisKind;

/// The options of merge that some analyses have, and which those are.
struct OwnOption {
    const char* name;
    bool is_given;
    std::optional<AnalysisKind> of;  ///< nullopt: all
};

std::array<OwnOption, 5> own_options(const JoinedRasterArguments& args) {
    return {{{"--report", !args.reports.page.empty(), std::nullopt},
             {"--map", !args.reports.map.empty(), std::nullopt},
             {"--objects", !args.objects.file.empty(), AnalysisKind::kEnergy},
             {"--polygons", !args.objects.polygons.empty(), AnalysisKind::kEnergy},
             {"--json", args.as_json, AnalysisKind::kSight}}};
}

/// Planned objects are a part of what the world's boxes come from.
std::vector<std::string> additions_of(const farm::PictureKey& key) {
    constexpr std::string_view kState = "state of the archive: ";
    std::vector<std::string> out;
    for (const std::string& input : key.inputs)
        if (input.starts_with(kState))
            out.push_back(input.substr(kState.size()));
    return out;
}

void count(const tiles::TileResult& tile, render::RenderStatistics& s) {
    ++s.counts.tiles;
    s.counts.trace.add(tile.counts);
    s.counts.holes.insert(tile.holes.begin(), tile.holes.end());
}

}  // namespace

void add_joined_raster_options(CLI::App& command, JoinedRasterArguments& args) {
    add_report_options(command, args.reports);
    add_object_options(command, args.objects);
    command.add_flag("--json", args.as_json,
                     "of sight: print what is seen, by material and class, as one JSON object");
    for (const OwnOption& option : own_options(args))
        command.get_option(option.name)->group("Rasters of analyses");
}

void check_is_no_raster(const JoinedRasterArguments& args) {
    for (const OwnOption& option : own_options(args))
        if (option.is_given)
            throw util::UsageError(std::string("merge: ") + option.name +
                                   " with parts of a picture; allowed: with parts of an analysis");
}

void check_joined_raster(const scene::Scene& scene, const std::vector<std::string>& outputs,
                         const JoinedRasterArguments& args) {
    const AnalysisKind kind = scene.analysis.kind;
    for (const OwnOption& option : own_options(args))
        if (option.is_given && option.of && *option.of != kind)
            throw util::UsageError(std::string("merge: ") + option.name +
                                   " with parts of an analysis of " +
                                   std::string(core::word_of(kind)) + "; allowed: of " +
                                   std::string(core::word_of(*option.of)));
    if (outputs.size() != 1)
        throw util::UsageError("merge: " + std::to_string(outputs.size()) +
                               " files for the raster of an analysis; allowed: 1, -o FILE.tif");
    analyse::check_raster_target(outputs.front());
    check_report_targets(args.reports);
    (void)relief_of(scene);
    if (kind == AnalysisKind::kEnergy)
        check_object_arguments(args.objects, scene, false);
}

util::ExitCode write_joined_raster(const farm::JoinedTiles& tiles, const scene::Scene& scene,
                                   const std::string& output, const JoinedRasterArguments& args,
                                   int threads, bool quiet) {
    const farm::PictureKey& key = tiles.key();
    const voxel::WorldInfo world = voxel::world_from_json(key.world, "the checkpoint");
    const analyse::CellGrid grid = analyse::grid_of(scene, world);
    const thread::StopSignals signals;
    render::RenderStatistics statistics;
    statistics.damage = tiles.damage();
    statistics.counts.samples = static_cast<std::uint32_t>(scene.quality.samples);
    std::optional<PlannedObjects> objects;
    if (!args.objects.file.empty())
        objects.emplace(args.objects, scene, grid, world);
    analyse::CellFile cells(output, scene.analysis.kind, grid.columns, grid.rows, key.grid.tile_px);
    tiles.each([&](tiles::TileResult&& tile) {
        if (signals.token().stop_requested())
            throw util::Error(cells.attempt() + ": interrupted");
        cells.add(tile);
        count(tile, statistics);
    });
    const Reported what{world,
                        scene,
                        grid,
                        own_fields(scene.analysis.kind),
                        additions_of(key),
                        scene.analysis.light.empty() ? "" : "a weather file",
                        statistics.counts.holes.size()};
    const auto seen = write_outputs(cells, {output, args.reports, objects}, what,
                                    render::joined_picture_info(scene, world, statistics), threads,
                                    signals.token());
    if (seen && args.as_json)
        std::printf("%s\n", analyse::json_of(*seen).c_str());
    else if (seen && !quiet)
        std::printf("%s", analyse::table_of(*seen).c_str());
    if (!quiet && !args.as_json)
        for (const std::string& file :
             {output, args.objects.file, args.reports.map, args.reports.page})
            if (!file.empty())
                std::printf("wrote %s\n", file.c_str());
    return report_gaps(statistics, "raster");
}

}  // namespace terravox::commands
