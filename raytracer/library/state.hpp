#pragma once

#include <terravox/world.hpp>

#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/blocks/block_manager.hpp"
#include "raytracer/library/map_frame.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox {

/// A folder that is removed with the object; an empty path is none.
class TemporaryFolder {
public:
    TemporaryFolder() = default;
    /// @throws util::Error when it cannot be made
    static TemporaryFolder make();
    TemporaryFolder(TemporaryFolder&& other) noexcept;
    TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
    ~TemporaryFolder();
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }

private:
    std::filesystem::path m_path;
};

/// Opens a world.
/// @param times outlive it
using OpenWorld = std::function<std::unique_ptr<voxel::World>(util::StageTimes& times)>;

/// An open world: its boxes in memory, and what it was opened with.
struct WorldState {
    /// @param settings its section processing is used
    WorldState(const scene::Scene& settings, const OpenWorld& open, TemporaryFolder files = {});

    const TemporaryFolder folder;  ///< outlives the world, whose files may be in it
    util::StageTimes times;        ///< outlives the world, which writes to it
    const std::unique_ptr<voxel::World> world;
    const MapFrame frame;
    const WorldInfo info;
    /// Requests for boxes are short, so that a call may be stopped: other calls use the same boxes.
    mutable blocks::BlockManager blocks;

    [[nodiscard]] const voxel::VoxelBounds& bounds() const noexcept {
        return world->info().framed_bounds();
    }
    /// @throws util::UsageError for a level that the world does not have
    void check_level(int level) const;
};

/// Makes a state. In a forked process it is never destroyed, which would wait for threads that are
/// not there.
/// @throws what `open` throws
[[nodiscard]] std::shared_ptr<WorldState> make_state(const scene::Scene& settings,
                                                     const OpenWorld& open,
                                                     TemporaryFolder files = {});

/// The settings that a world is opened with.
/// @throws util::UsageError
[[nodiscard]] scene::Scene settings_of(const OpenOptions& options);

/// @throws Stopped once the caller has requested it
void check_stop(const Control& control);

}  // namespace terravox
