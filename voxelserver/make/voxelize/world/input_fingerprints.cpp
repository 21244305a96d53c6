#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

#include "common/voxel/bytes.hpp"
#include "voxelserver/data/imagery/colour_map.hpp"
#include "voxelserver/data/imagery/filters.hpp"
#include "voxelserver/make/voxelize/steps/tints.hpp"

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

Fingerprint fingerprint_of(const ClassTable& classes) {
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

Fingerprint tints_fingerprint(const Settings& settings) {
    if (!settings.steps.colour_variation)
        return {};
    voxel::ByteWriter out;
    Tints::load(settings.tints).add_values(out);
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

}  // namespace terravox::voxelize
