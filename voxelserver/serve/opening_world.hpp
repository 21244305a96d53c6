#pragma once

#include <atomic>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "voxelserver/voxelize/lidar_world.hpp"
#include "voxelserver/voxelize/world_facts.hpp"

namespace terravox::serve {

/// A LiDAR world of which is known, from an earlier process, what it is: boxes that were kept can be handed out at once, while the world
/// is opened beside. The first box that has to be made waits for that. Thread-safe.
///
/// Facts are kept in a folder under the world's name (voxelize::world_name), so that they are never those of other inputs.
class OpeningWorld final : public voxel::TracedWorld {
public:
    /// Opens the world now where nothing is known of it. @param facts folder; empty: nothing is kept
    /// @throws as open_lidar_world
    OpeningWorld(voxelize::LidarWorldOptions options, util::StageTimes& times, const std::filesystem::path& facts);
    ~OpeningWorld() override;  ///< waits for the opening

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override { return opened().box(key); }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override { return m_facts.column(level, bx, bz); }
    [[nodiscard]] voxel::TracedBox traced_box(const voxel::BoxKey& key) override { return opened().traced_box(key); }
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::Reach& reach) const override { return m_facts.fingerprint(reach); }

    /// What the store knows of the data, before anybody asks for info().
    void set_licence(const std::string& licence, const std::string& attribution) { m_info.licence = licence, m_info.attribution = attribution; }
    [[nodiscard]] const voxelize::WorldFacts& facts() const noexcept { return m_facts; }
    /// All files with their states; none is known to be prepared before the world is open.
    [[nodiscard]] std::vector<voxelize::SquareInfo> squares() const;
    /// Why the world cannot be opened; "" while it is not known, and when it could.
    [[nodiscard]] std::string trouble() const { return m_failed ? m_trouble : ""; }

private:
    [[nodiscard]] voxelize::LidarWorld& opened();  ///< @throws what opening threw
    void keep_facts(const std::filesystem::path& file) const noexcept;

    util::StageTimes& m_times;
    voxelize::WorldFacts m_facts;
    voxel::WorldInfo m_info;
    std::shared_future<std::shared_ptr<voxelize::LidarWorld>> m_world;
    std::atomic<bool> m_is_open{false};  ///< set when m_world holds a world
    std::atomic<bool> m_failed{false};   ///< set when m_trouble is written
    std::string m_trouble;
    std::thread m_opening;
};

}  // namespace terravox::serve
