#pragma once

#include <atomic>
#include <filesystem>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "voxelserver/voxelize/world/lidar_world.hpp"
#include "voxelserver/voxelize/world/world_facts.hpp"
#include "voxelserver/worlds/kind/served_world.hpp"

namespace terravox::serve {

/// A LiDAR world of which is known, from an earlier process, what it is: boxes that were kept can
/// be handed out at once, and the world is opened beside, on a thread of its own. The first box
/// that has to be made waits for that. Thread-safe.
///
/// What opens worlds is loaded for that only (module/load_module.hpp). Facts are kept in a folder
/// under the world's name (voxelize::world_name), so that they are never those of other inputs.
class DeferredWorld final : public worlds::ServedWorld {
public:
    struct Means {
        std::filesystem::path facts;  ///< folder; empty: nothing is kept
        std::size_t image_bytes = 0;  ///< of memory, for what is decoded of images
    };
    /// Opens the world now where nothing is known of it; otherwise begin_opening() does, or the
    /// first box that has to be made.
    /// @throws as module::open_lidar_world
    DeferredWorld(voxelize::LidarWorldOptions options, util::StageTimes& times, const Means& means);
    ~DeferredWorld() override;  ///< waits for the opening
    /// Opens the world beside. To be called when the server answers, whose start would have to
    /// share memory and cores with it. Idempotent.
    void begin_opening() override;

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        return opened().box(key);
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_facts.column(level, bx, bz);
    }
    [[nodiscard]] voxel::BoxWithInputs traced_box(const voxel::BoxKey& key) override {
        return opened().traced_box(key);
    }
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent& reach) const override {
        return m_facts.fingerprint(reach);
    }

    /// What the store knows of the data, before anybody asks for info().
    void set_licence(const std::string& licence, const std::string& attribution) {
        m_info.licence = licence;
        m_info.attribution = attribution;
    }
    [[nodiscard]] const voxelize::WorldFacts& facts() const noexcept { return m_facts; }
    /// All files with their states; none is known to be prepared before the world is open.
    [[nodiscard]] std::vector<voxelize::SquareInfo> squares() const;
    [[nodiscard]] bool is_open() const noexcept override { return m_is_open; }
    /// Why the world cannot be opened; "" while it is not known, and when it could.
    [[nodiscard]] std::string trouble() const override { return m_failed ? m_trouble : ""; }
    [[nodiscard]] std::string summary() const override;
    [[nodiscard]] bool makes_all_levels() const noexcept override { return false; }

private:
    [[nodiscard]] voxelize::LidarWorld& opened();  ///< @throws what opening threw
    void open() noexcept;
    void keep(const voxelize::WorldFacts& facts) const noexcept;

    const voxelize::LidarWorldOptions m_options;
    const std::size_t m_image_bytes;
    std::filesystem::path m_file;  ///< of the facts; empty: nothing is kept
    util::StageTimes& m_times;
    voxelize::WorldFacts m_facts;
    voxel::WorldInfo m_info;
    std::promise<std::shared_ptr<voxelize::LidarWorld>> m_promise;
    const std::shared_future<std::shared_ptr<voxelize::LidarWorld>> m_world;
    std::atomic<bool> m_is_open{false};  ///< set when m_world holds a world
    std::atomic<bool> m_failed{false};   ///< set when m_trouble is written
    std::string m_trouble;
    std::once_flag m_begun;
    std::thread m_opening;
};

}  // namespace terravox::serve
