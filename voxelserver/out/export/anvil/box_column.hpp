#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "voxelserver/out/export/anvil/place.hpp"
#include "voxelserver/out/export/anvil/section.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports::anvil {

/// The boxes above one patch of the part, as 4 x 4 chunks. Not thread-safe.
class BoxColumn {
public:
    static constexpr int kChunksAlong = voxel::kBoxSizeX / kSectionSize;

    /// Requests the boxes from the job. The references must outlive it.
    BoxColumn(Job& job, const Place& place, std::int32_t bx, std::int32_t bz);

    [[nodiscard]] bool empty() const noexcept;
    /// x of the chunk (0, 0).
    [[nodiscard]] std::int32_t chunk_x() const noexcept {
        return m_bx * kChunksAlong - m_place.offset[0] / kSectionSize;
    }
    /// z of the chunk (0, 0).
    [[nodiscard]] std::int32_t chunk_z() const noexcept {
        return m_bz * kChunksAlong - m_place.offset[2] / kSectionSize;
    }
    /// The sections of one chunk, from the lowest of the dimension up; valid until the next call.
    [[nodiscard]] std::vector<Section>& sections(int cx, int cz, SectionReader& reader);

private:
    const Place& m_place;
    const std::int32_t m_bx;
    const std::int32_t m_bz;
    std::int32_t m_first_by = 0;
    std::vector<std::shared_ptr<const voxel::Box>> m_boxes;
    std::vector<Section> m_sections;
};

/// The block above the surface at the centre of the part, or, where there is none, at the nearest
/// of some places at increasing distance.
[[nodiscard]] std::array<std::int32_t, 3> spawn_of(Job& job, const Place& place);

}  // namespace terravox::exports::anvil
