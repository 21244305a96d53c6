#pragma once

#include <terravox/sources.hpp>

#include <memory>

#include "common/voxel/pyramid_world.hpp"

namespace terravox {

/// The world of a caller's source of voxels. Thread-safe if the source is.
class SourceWorld final : public voxel::PyramidWorld {
public:
    /// @param limit_bytes of boxes that it keeps
    /// @throws util::UsageError for a source whose facts make no world
    SourceWorld(std::shared_ptr<VoxelSource> source, std::size_t limit_bytes);

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

protected:
    [[nodiscard]] voxel::FineColumn make_column(std::int32_t bx, std::int32_t bz) override;

private:
    const std::shared_ptr<VoxelSource> m_source;
    const voxel::WorldInfo m_info;
};

}  // namespace terravox
