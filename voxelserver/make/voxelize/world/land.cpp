#include "voxelserver/make/voxelize/world/land.hpp"

#include <algorithm>

#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

namespace terravox::voxelize {
namespace {

// With less, the surroundings of a gap would be computed for every column.
constexpr std::size_t kMinWide = std::size_t{1} << 20;

water::WaterOptions water_options(const Settings& settings, int cell_voxels, double voxel_m,
                                  std::size_t memory_bytes) {
    water::WaterOptions out;
    out.cell_voxels = cell_voxels;
    out.voxel_m = voxel_m;
    out.memory_bytes = memory_bytes;
    out.evidence.by_class = settings.water.from_class;
    out.evidence.by_photo = settings.water.from_orthophoto;
    out.evidence.by_void = settings.water.from_voids;
    return out;
}

}  // namespace

StepContext::StepContext(PointSet& given, const imagery::Orthophotos* images,
                         const Settings& chosen, std::size_t memory_bytes, util::StageTimes& times)
    : points(given),
      settings(chosen),
      voxel_m(given.sources().frame.voxel_m()),
      photo_lights(images != nullptr && chosen.orthophoto.albedo
                       ? std::make_unique<PhotoLights>(
                             *images, given, times,
                             KeptLights{given.facts_folder(),
                                        fingerprint_everywhere(given.sources(), given.classes(),
                                                               chosen, given.cell_voxels())})
                       : nullptr),
      surface(images, photo_lights.get(), given.classes(), chosen, given.sources().has_water_class,
              voxel_m, memory_bytes / 4, times),
      tints(given.sources().tints),
      cells(given, surface, memory_bytes / 4),
      bodies(cells, water_options(chosen, given.cell_voxels(), voxel_m, memory_bytes / 4)),
      wide_ground(given, std::max(memory_bytes / 4, kMinWide)) {}

Land::Land(StepContext& context, grid::PatchKey patch)
    : shared(context),
      window(context.points.window(patch)),
      in_bounds(context.points.in_bounds(patch)),
      water_access{context.cells, context.bodies, context.points.cell_voxels(),
                   measure_reach(patch, 1)} {}

}  // namespace terravox::voxelize
