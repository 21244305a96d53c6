#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

#include <algorithm>

#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/imagery/colour_map.hpp"
#include "voxelserver/data/imagery/filters.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"
#include "voxelserver/make/voxelize/steps/photo_light.hpp"
#include "voxelserver/make/voxelize/steps/photo_mosaic.hpp"

namespace terravox::voxelize {
namespace {

using voxel::ByteWriter;
using voxel::Fingerprint;
using voxel::InputExtent;

/// A reach as columns, which may not fit 32 bits.
struct WideRect {
    std::int64_t min_x;
    std::int64_t min_z;
    std::int64_t max_x;
    std::int64_t max_z;
    explicit WideRect(const InputExtent& r)
        : min_x(std::int64_t{r.min_bx} * grid::kPatchSize),
          min_z(std::int64_t{r.min_bz} * grid::kPatchSize),
          max_x(std::int64_t{r.max_bx} * grid::kPatchSize),
          max_z(std::int64_t{r.max_bz} * grid::kPatchSize) {}
    [[nodiscard]] bool overlaps(const grid::ColumnRect& o) const noexcept {
        return min_x < o.max_x && o.min_x < max_x && min_z < o.max_z && o.min_z < max_z;
    }
};

}  // namespace

Fingerprint to_fingerprint(const ClassTable& classes) {
    voxel::ByteWriter out;
    for (const ClassMeaning& m : classes.meaning) {
        out.add(m.role);
        out.add(m.material);
        out.add(m.tiers);
    }
    return out.fingerprint();
}

Fingerprint palette_fingerprint(const Settings& settings) {
    if (!settings.steps.specialization)
        return {};
    voxel::ByteWriter out;
    imagery::ColourMap::load(settings.palette).add_values(out);
    if (settings.steps.neighbourhood_filters)
        imagery::add_values(imagery::load_filters(settings.palette), out);
    return out.fingerprint();
}

Fingerprint to_fingerprint(const Tints& tints) {
    voxel::ByteWriter out;
    tints.add_values(out);
    return out.fingerprint();
}

Fingerprint InputFingerprints::fingerprint(const InputExtent& reach) const {
    const WideRect area(reach);
    voxel::ByteWriter out;
    out.add(everywhere);
    bool coloured = false;
    for (const auto* inputs : {&points, &images}) {
        std::uint32_t count = 0;
        for (const Input& input : *inputs) {
            if (!area.overlaps(input.rect))
                continue;
            out.add(input.fingerprint);
            ++count;
            coloured = coloured || input.coloured;
        }
        out.add(count);
    }
    if (coloured)
        out.add(palette);
    return out.fingerprint();
}

namespace {

/// Each image with all that its albedo depends on besides the points beneath: the light of images
/// around it counts, too, and the exposure of its series.
std::vector<Fingerprint> albedo_fingerprints(const std::vector<imagery::Orthophotos::Input>& images,
                                             const Sources& sources) {
    std::vector<Fingerprint> own;
    for (const imagery::Orthophotos::Input& image : images)
        own.push_back(to_fingerprint(photo_sample(image.rect, sources), image.identity, sources));
    const PhotoMosaic mosaic(images);
    const ExposureImages exposure = exposure_images(images);
    std::vector<Fingerprint> out;
    for (std::size_t i = 0; i < images.size(); ++i) {
        voxel::ByteWriter all;
        all.add(own[i]);
        for (const std::size_t around : mosaic.around(i))
            all.add(own[around]);
        for (const std::size_t exposed : exposure.at(images[i].series))
            all.add(own[exposed]);
        out.push_back(all.fingerprint());
    }
    return out;
}

}  // namespace

voxel::Fingerprint fingerprint_everywhere(const Sources& sources, const ClassTable& classes,
                                          const Settings& settings, int cell_voxels) {
    ByteWriter all;
    const grid::Frame& frame = sources.frame;
    all.add(kBoxRecipe);
    all.add(frame.crs().wkt());
    all.add(frame.units_per_voxel());
    all.add(frame.voxel_m());
    all.add(to_fingerprint(settings));
    all.add(to_fingerprint(classes));
    all.add(settings.steps.colour_variation ? to_fingerprint(sources.tints) : Fingerprint{});
    all.add(cell_voxels);
    all.add(sources.has_water_class);
    all.add(sources.floor_y);
    // Nothing rises above the points that it is made from, but a bed may lie below them all, and
    // boxes below the lowest are not requested.
    all.add(voxel::floor_div(sources.lowest_y, voxel::kBoxSizeY));
    return all.fingerprint();
}

InputFingerprints make_fingerprints(const Sources& sources, const imagery::Orthophotos* images,
                                    const ClassTable& classes, const Settings& settings,
                                    int cell_voxels) {
    InputFingerprints out;
    out.everywhere = fingerprint_everywhere(sources, classes, settings, cell_voxels);
    out.palette = palette_fingerprint(settings);
    // A margin of one voxel, as where columns are made: a transformed or rounded point may lie just
    // outside its file's bounds.
    for (const SquareSource& s : sources.files)
        out.points.push_back({s.bounds.grown(1), to_fingerprint(s), s.has_colour});
    std::sort(out.points.begin(), out.points.end(),
              [](const auto& a, const auto& b) { return a.fingerprint < b.fingerprint; });
    if (images == nullptr)
        return out;
    const std::vector<imagery::Orthophotos::Input> inputs = images->inputs();
    std::vector<Fingerprint> albedo;
    if (settings.orthophoto.albedo)
        albedo = albedo_fingerprints(inputs, sources);
    for (std::size_t i = 0; i < inputs.size(); ++i)
        out.images.push_back(
            {inputs[i].rect, albedo.empty() ? inputs[i].identity : albedo[i], true});
    return out;
}

}  // namespace terravox::voxelize
