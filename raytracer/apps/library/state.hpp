#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <terravox/place.hpp>
#include <terravox/world.hpp>

#include "common/util/folders.hpp"
#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox {

/// Between the coordinates of a map and voxels of level 0 (terravox/place.hpp).
class MapFrame {
public:
    explicit MapFrame(const voxel::WorldInfo& world) noexcept
        : m_units(world.crs.empty() ? world.voxel_m : world.crs_units_per_voxel),
          m_voxel_m(world.voxel_m) {}

    /// A point or a direction: both systems have the same origin.
    [[nodiscard]] core::Vec3 to_voxels(const double (&at)[3]) const noexcept {
        return {at[0] / m_units, at[2] / m_voxel_m, -at[1] / m_units};
    }
    [[nodiscard]] double units() const noexcept { return m_units; }
    [[nodiscard]] MapBounds measure_bounds(const voxel::VoxelBounds& block) const noexcept {
        return {block.min[0] * m_units,  -block.max[2] * m_units,  block.max[0] * m_units,
                -block.min[2] * m_units, block.min[1] * m_voxel_m, block.max[1] * m_voxel_m};
    }
    /// The smallest block of voxels of a level that covers bounds, as far as it is in a world, in
    /// voxels of that level.
    /// @throws util::UsageError where nothing is left
    [[nodiscard]] voxel::VoxelBounds block_over(const MapBounds& bounds, int level,
                                                const voxel::VoxelBounds& world) const;

private:
    double m_units;
    double m_voxel_m;
};

/// Opens a world.
/// @param times outlive it
using OpenWorld = std::function<std::unique_ptr<voxel::World>(util::StageTimes& times)>;

/// An open world: its boxes in memory, and what it was opened with.
struct WorldState {
    /// @param settings its section processing is used
    WorldState(const scene::Scene& settings, const OpenWorld& open,
               util::TemporaryFolder files = {});

    const util::TemporaryFolder folder;  ///< outlives the world, whose files may be in it
    util::StageTimes times;              ///< outlives the world, which writes to it
    const std::unique_ptr<voxel::World> world;
    const MapFrame frame;
    const WorldInfo info;
    /// Shared by all calls; thread-safe.
    mutable blocks::BlockManager blocks;

    mutable std::atomic<int> calls{0};  ///< that are under way

    /// The smallest block of a level that covers bounds, in voxels of that level; without bounds
    /// what pictures show.
    /// @throws util::UsageError for a level that the world does not have, and where nothing is
    [[nodiscard]] voxel::VoxelBounds block_over(const std::optional<MapBounds>& bounds,
                                                int level) const;
    /// The same over the whole height of the world.
    [[nodiscard]] voxel::VoxelBounds columns_over(const std::optional<MapBounds>& area,
                                                  int level) const;
    /// @throws util::UsageError for a level that the world does not have
    void check_level(int level) const;
};

/// A call that reads boxes. If no other is under way, boxes that could not be read are asked for
/// again.
class WorldCall {
public:
    /// @throws util::UsageError for a number of threads that is not allowed
    WorldCall(const WorldState& state, int threads);
    ~WorldCall();
    WorldCall(const WorldCall&) = delete;
    WorldCall& operator=(const WorldCall&) = delete;
    /// @return the holes that a result has
    /// @throws voxel::ChangedError where it has any because the world is another one now
    [[nodiscard]] std::size_t checked(std::size_t holes) const;

private:
    const WorldState& m_state;
};

/// @throws util::UsageError unless 0 to 1024
void check_threads(int threads);

/// Makes a state. In a forked process it is never destroyed, which would wait for threads that are
/// not there.
/// @throws what `open` throws
[[nodiscard]] std::shared_ptr<WorldState> make_state(const scene::Scene& settings,
                                                     const OpenWorld& open,
                                                     util::TemporaryFolder files = {});

/// The settings that a world is opened with.
/// @throws util::UsageError
[[nodiscard]] scene::Scene make_settings(const OpenOptions& options);

/// @throws Stopped once the caller has requested it
void check_stop(const Control& control);

}  // namespace terravox
