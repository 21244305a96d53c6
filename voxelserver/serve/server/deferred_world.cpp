#include "voxelserver/serve/server/deferred_world.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/make/voxelize/world/world_name.hpp"
#include "voxelserver/serve/module/load_module.hpp"

namespace terravox::serve {

namespace fs = std::filesystem;
namespace {

// Maximum number of worlds with stored facts; the least recently written ones are removed.
constexpr std::size_t kMaxFacts = 200;

std::optional<voxelize::WorldFacts> read_facts(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in)
        return std::nullopt;
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    try {
        return voxelize::facts_from_bytes(bytes);
    } catch (const util::Error& e) {
        util::log_warn("{}: {}; the world is opened anew", file.string(), e.what());
        return std::nullopt;
    }
}

void forget_old(const fs::path& folder) {
    std::vector<std::pair<fs::file_time_type, fs::path>> files;
    std::error_code failed;
    std::error_code gone;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed))
        if (entry->path().extension() == ".facts")
            files.emplace_back(entry->last_write_time(gone), entry->path());
    std::sort(files.begin(), files.end());
    for (std::size_t i = 0; i + kMaxFacts < files.size(); ++i)
        fs::remove(files[i].second, gone);
}

}  // namespace

DeferredWorld::DeferredWorld(voxelize::LidarWorldOptions options, util::StageTimes& times,
                             const Means& means)
    : m_options(std::move(options)),
      m_image_bytes(means.image_bytes),
      m_times(times),
      m_world(m_promise.get_future()) {
    if (!means.facts.empty())
        m_file =
            means.facts / (voxelize::world_name(m_options, module::worlds_module()) + ".facts");
    if (auto known = m_file.empty() ? std::nullopt : read_facts(m_file)) {
        m_facts = std::move(*known);
        return;
    }
    std::call_once(m_begun, [&] {
        std::shared_ptr<voxelize::LidarWorld> world =
            module::open_lidar_world(m_options, m_times, m_image_bytes);
        m_facts = world->facts();
        m_promise.set_value(std::move(world));
        m_is_open = true;
    });
    if (!m_file.empty())
        keep(m_facts);
}

DeferredWorld::~DeferredWorld() {
    if (m_opening.joinable())
        m_opening.join();
}

void DeferredWorld::begin_opening() {
    std::call_once(m_begun, [this] { m_opening = std::thread([this] { open(); }); });
}

void DeferredWorld::open() noexcept {
    try {
        std::shared_ptr<voxelize::LidarWorld> world =
            module::open_lidar_world(m_options, m_times, m_image_bytes);
        // The name cannot cover everything: the system's GDAL and PROJ may have changed. Whatever
        // the cause, the next start must not use these facts again.
        if (voxelize::to_bytes(world->facts()) != voxelize::to_bytes(m_facts)) {
            std::error_code ignored;
            fs::remove(m_file, ignored);
            throw util::Error(
                "open the world: its files have changed since the server started, or what is known "
                "of it is out of date; start it again");
        }
        m_promise.set_value(std::move(world));
        m_is_open = true;
    } catch (const std::exception& e) {
        util::log_error("{}; only boxes that were kept can be served", e.what());
        m_failure = e.what();
        m_failed = true;
        m_promise.set_exception(std::current_exception());
    }
}

voxelize::LidarWorld& DeferredWorld::opened() {
    begin_opening();
    return *m_world.get();
}

std::vector<voxelize::SquareInfo> DeferredWorld::squares() const {
    return m_is_open ? m_world.get()->squares() : m_facts.squares;
}

std::string DeferredWorld::summary() const {
    std::uint64_t points = 0;
    for (const voxelize::SquareInfo& square : m_facts.squares)
        points += square.points;
    return std::to_string(points) + " points in " + std::to_string(m_facts.squares.size()) +
           " files, " + std::to_string(m_facts.orthophotos) + " orthophotos";
}

void DeferredWorld::keep(const voxelize::WorldFacts& facts) const noexcept {
    try {
        util::write_file_atomically(m_file, voxelize::to_bytes(facts));
        forget_old(m_file.parent_path());
    } catch (const std::exception& e) {
        util::log_warn("{}; the next start takes longer", e.what());
    }
}

}  // namespace terravox::serve
