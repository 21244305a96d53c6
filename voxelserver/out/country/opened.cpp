#include "voxelserver/out/country/opened.hpp"

#include "common/voxel/bytes.hpp"
#include "common/voxel/file_identity.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"

namespace terravox::country {

OpenedCountry::OpenedCountry(const worlds::WorldOptions& options, const exports::Selection& part)
    : m_world(voxelize::open_lidar_world(worlds::lidar_world_options(options), m_times)),
      m_part(exports::part_of(m_world->info(), part)) {}

std::string OpenedCountry::fingerprint() const {
    const voxel::BoxRange all = voxel::boxes_over(m_world->info().bounds, 0);
    return voxel::hex_of(
        m_world->fingerprint({all.min.bx - 1, all.min.bz - 1, all.max.bx + 1, all.max.bz + 1}));
}

std::string OpenedCountry::fingerprint_of_all_boxes() const {
    const voxelize::InputFingerprints& of = m_world->facts().fingerprints;
    voxel::ByteWriter out;
    out.add(of.everywhere);
    out.add(of.palette);
    return voxel::hex_of(out.fingerprint());
}

std::vector<SurveySquare> OpenedCountry::squares() const {
    std::vector<SurveySquare> out;
    for (const voxelize::SquareInfo& square : m_world->facts().squares)
        out.push_back({square.bounds, square.points});
    return out;
}

}  // namespace terravox::country
