#include "voxelserver/serve/opening_world.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::serve {

namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostFacts = 200;  // worlds of which something is kept; those written longest ago go

std::optional<voxelize::WorldFacts> read_facts(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) return std::nullopt;
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    try {
        return voxelize::facts_from_bytes(bytes);
    } catch (const Error& e) {
        spdlog::warn("{}: {}; the world is opened anew", file.string(), e.what());
        return std::nullopt;
    }
}

void forget_old(const fs::path& folder) {
    std::vector<std::pair<fs::file_time_type, fs::path>> files;
    std::error_code failed, gone;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
        if (entry->path().extension() == ".facts") files.emplace_back(entry->last_write_time(gone), entry->path());
    std::sort(files.begin(), files.end());
    for (std::size_t i = 0; i + kMostFacts < files.size(); ++i) fs::remove(files[i].second, gone);
}

}  // namespace

OpeningWorld::OpeningWorld(voxelize::LidarWorldOptions options, util::StageTimes& times, const fs::path& facts) : m_times(times) {
    const fs::path file = facts.empty() ? fs::path() : facts / (voxelize::world_name(options) + ".facts");
    std::promise<std::shared_ptr<voxelize::LidarWorld>> promise;
    m_world = promise.get_future().share();
    if (auto known = file.empty() ? std::nullopt : read_facts(file)) {
        m_facts = std::move(*known);
        m_info = m_facts.info;
        m_opening = std::thread([this, file, options = std::move(options), promise = std::move(promise)]() mutable {
            try {
                std::shared_ptr<voxelize::LidarWorld> world = voxelize::open_lidar_world(options, m_times);
                if (voxelize::to_bytes(world->facts()) != voxelize::to_bytes(m_facts)) {
                    // Whatever made them differ: the next start must not meet them again.
                    std::error_code ignored;
                    fs::remove(file, ignored);
                    throw Error("open the world: its files have changed since the server started, or what is known of it is out of date; start it again");
                }
                promise.set_value(std::move(world));
                m_is_open = true;
            } catch (const std::exception& e) {
                spdlog::error("{}; only boxes that were kept can be served", e.what());
                m_trouble = e.what();
                m_failed = true;
                promise.set_exception(std::current_exception());
            }
        });
        return;
    }
    std::shared_ptr<voxelize::LidarWorld> world = voxelize::open_lidar_world(options, times);
    m_facts = world->facts();
    m_info = m_facts.info;
    promise.set_value(std::move(world));
    m_is_open = true;
    if (!file.empty()) keep_facts(file);
}

OpeningWorld::~OpeningWorld() {
    if (m_opening.joinable()) m_opening.join();
}

voxelize::LidarWorld& OpeningWorld::opened() { return *m_world.get(); }

std::vector<voxelize::SquareInfo> OpeningWorld::squares() const { return m_is_open ? m_world.get()->squares() : m_facts.squares; }

void OpeningWorld::keep_facts(const fs::path& file) const noexcept {
    try {
        util::write_file_atomically(file, voxelize::to_bytes(m_facts));
        forget_old(file.parent_path());
    } catch (const std::exception& e) {
        spdlog::warn("{}; the next start takes longer", e.what());
    }
}

}  // namespace terravox::serve
