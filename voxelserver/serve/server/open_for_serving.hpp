#pragma once

#include <atomic>
#include <filesystem>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/data/store/grabber_store.hpp"
#include "voxelserver/make/voxelize/points/square_info.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"
#include "voxelserver/make/worlds/kind/served_world.hpp"
#include "voxelserver/serve/http/service.hpp"
#include "voxelserver/serve/server/serve.hpp"

namespace terravox::serve {

/// The squares shown by the HTTP interface: those of the world, and those that the store has not
/// fetched, where they can be placed in the world. Thread-safe.
class SquareList {
public:
    /// @param store must outlive the list; nullopt: the world is of plain files
    explicit SquareList(const std::optional<store::GrabberStore>& store) : m_store(store) {}
    /// @param world the same in each call: what is not fetched is placed in it once
    [[nodiscard]] std::vector<http::SquareEntry> entries(
        std::span<const voxelize::SquareInfo> opened, const voxel::WorldInfo& world);

private:
    const std::optional<store::GrabberStore>& m_store;
    std::once_flag m_once;
    std::vector<http::SquareEntry> m_unfetched;
};

/// A LiDAR world that can be served before it is opened, when its metadata are known from an
/// earlier process: cached boxes are available at once, while the world is opened in the
/// background, on a separate thread. The first box that must be made waits for that. Thread-safe.
///
/// The code that opens worlds is loaded only for that purpose (module/load_module.hpp). The
/// metadata (facts) are stored in a folder under the world's name (voxelize::world_name), so that
/// they never belong to other inputs.
class DeferredWorld final : public worlds::ServedWorld {
public:
    struct Means {
        std::filesystem::path facts;  ///< folder; empty: facts are not stored
        std::size_t image_bytes = 0;  ///< memory limit for decoded images
    };
    /// Opens the world at once when no facts are stored; otherwise it is opened by begin_opening(),
    /// or by the first box that must be made.
    /// @throws as module::open_lidar_world
    DeferredWorld(voxelize::LidarWorldOptions options, util::StageTimes& times, const Means& means);
    ~DeferredWorld() override;  ///< waits until the world is opened
    /// Starts opening the world in the background. Must be called once the server is responding,
    /// since opening would compete with its start for memory and cores. Idempotent.
    void begin_opening() override;

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_facts.info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        return opened().box(key);
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_facts.column(level, bx, bz);
    }
    [[nodiscard]] voxel::BoxWithInputs box_with_inputs(const voxel::BoxKey& key) override {
        return opened().box_with_inputs(key);
    }
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent& reach) const override {
        return m_facts.fingerprint(reach);
    }

    [[nodiscard]] const voxelize::WorldFacts& facts() const noexcept { return m_facts; }
    /// All files with their states; none is reported as prepared before the world is open.
    [[nodiscard]] std::vector<voxelize::SquareInfo> squares() const;
    [[nodiscard]] bool is_open() const noexcept override { return m_is_open; }
    /// Why the world cannot be opened; "" while that is unknown, and when opening succeeded.
    [[nodiscard]] std::string failure() const override { return m_failed ? m_failure : ""; }
    [[nodiscard]] std::string summary() const override;
    [[nodiscard]] bool makes_all_levels() const noexcept override { return false; }

private:
    /// Waits for the world, and opens it if necessary.
    /// @throws the exception of opening
    [[nodiscard]] voxelize::LidarWorld& opened();
    void open() noexcept;
    void keep(const voxelize::WorldFacts& facts) const noexcept;

    const voxelize::LidarWorldOptions m_options;
    const std::size_t m_image_bytes;
    std::filesystem::path m_file;  ///< file of the facts; empty: they are not stored
    util::StageTimes& m_times;
    voxelize::WorldFacts m_facts;
    std::promise<std::shared_ptr<voxelize::LidarWorld>> m_promise;
    const std::shared_future<std::shared_ptr<voxelize::LidarWorld>> m_world;
    std::atomic<bool> m_is_open{false};  ///< set when m_world holds a world
    std::atomic<bool> m_failed{false};   ///< set after m_failure was written
    std::string m_failure;
    std::once_flag m_begun;
    std::thread m_opening;
};

/// The world that a server serves, and its origin.
struct OpenedForServing {
    std::unique_ptr<worlds::ServedWorld> world;
    const DeferredWorld* lidar = nullptr;      ///< `world`, when it is LiDAR data or a store
    std::optional<store::GrabberStore> store;  ///< the grabber's store, when one was given
};

/// Opens the inputs of `options`: LiDAR data and stores as a DeferredWorld, all other kinds through
/// the module.
/// @param times outlives the world
/// @param stop cancels the opening, e.g. while another server is slow to respond
/// @throws UsageError for flags that are not valid for the kind; Error when the world cannot be
/// opened, or opening was cancelled
[[nodiscard]] OpenedForServing open_for_serving(const Options& options, const Plan& plan,
                                                util::StageTimes& times,
                                                const std::stop_token& stop);

}  // namespace terravox::serve
