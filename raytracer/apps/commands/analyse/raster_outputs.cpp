#include "raytracer/apps/commands/analyse/raster_outputs.hpp"

#include "common/util/error.hpp"
#include "raytracer/analyse/raster/raster.hpp"
#include "raytracer/apps/commands/arguments/number_list.hpp"

namespace terravox::commands {

analyse::ReliefOptions relief_of(const scene::Scene& scene) {
    const scene::Scene::Analysis& asked = scene.analysis;
    analyse::ReliefOptions out;
    out.of = asked.relief == "dsm" ? analyse::ReliefOf::kSurface : analyse::ReliefOf::kGround;
    out.window = asked.window;
    out.fill_m = asked.fill_m;
    const std::string allowed =
        "azimuth,altitude in degrees: 0 to 360 clockwise from north, and 0 to 90";
    const auto light = numbers_of("analyse", "--light", asked.relief_light, 2, allowed);
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
        analyse::derive_terrain(cells, what.grid.edge_m, relief_of(what.scene), stop);
    if (kind == core::AnalysisKind::kSight)
        seen = analyse::summary_of(cells, what.grid.edge_m);
    info.geo = analyse::placement_of(what.grid, what.world);
    analyse::write_raster(cells, outputs.file, info, threads);
    if (outputs.objects)
        outputs.objects->write(cells, stop);
    write_reports(outputs.reports, cells, what, stop);
    return seen;
}

}  // namespace terravox::commands
