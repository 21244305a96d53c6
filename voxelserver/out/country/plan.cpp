#include "voxelserver/out/country/plan.hpp"

#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/bytes.hpp"
#include "common/voxel/file_identity.hpp"

namespace terravox::country {

std::string Plan::id() const {
    voxel::ByteWriter out;
    out.add(kPlanVersion);
    out.add(std::string_view(program));
    out.add(box_recipe);
    out.add(voxel::archive::kVersion);
    out.add(std::string_view(fingerprint));
    for (std::size_t a = 0; a < 3; ++a) {
        out.add(bounds.min[a]);
        out.add(bounds.max[a]);
    }
    out.add(std::string_view(world.title));
    out.add(shards.size());
    return voxel::hex_of(out.fingerprint());
}

}  // namespace terravox::country
