#include "voxelserver/serve/server/open_for_serving.hpp"

#include <spdlog/spdlog.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/make/voxelize/world/store_options.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/serve/module/load_module.hpp"

namespace terravox::serve {
namespace {

using store::GrabberStore;
using store::StoredSquare;
using store::StoredState;

const char* state_name(voxelize::SquareState state) {
    switch (state) {
        case voxelize::SquareState::kPrepared: return "prepared";
        case voxelize::SquareState::kFailed: return "failed";
        case voxelize::SquareState::kFetched: break;
    }
    return "fetched";
}

http::SquareEntry make_entry(const voxelize::SquareInfo& s) {
    http::SquareEntry out;
    out.name = s.name;
    out.state = state_name(s.state);
    out.file = s.file.filename().string();
    if (!s.error.empty())
        out.error = s.error;
    out.points = s.points;
    out.bytes = s.bytes;
    out.min_x = s.bounds.min_x;
    out.min_z = s.bounds.min_z;
    out.max_x = s.bounds.max_x;
    out.max_z = s.bounds.max_z;
    return out;
}

void add_terms(const StoredSquare& from, http::SquareEntry& to) {
    to.source = from.source;
    to.licence = from.licence;
    to.attribution = from.attribution;
}

using Extent = std::array<double, 4>;  ///< west, south, east, north

// Squares are named E_N by their south-western corner in kilometres; this is used where the store
// has no bounds for one that it has not fetched.
std::optional<Extent> stored_extent(const StoredSquare& s) {
    if (s.bounds)
        return Extent{s.bounds->min[0], s.bounds->min[1], s.bounds->max[0], s.bounds->max[1]};
    double e = 0;
    double n = 0;
    char tail = 0;
    if (std::sscanf(s.name.c_str(), "%lf_%lf%c", &e, &n, &tail) != 2 || !std::isfinite(e) ||
        !std::isfinite(n))
        return std::nullopt;
    return Extent{e * 1000, n * 1000, (e + 1) * 1000, (n + 1) * 1000};
}

/// Squares that are not fetched, with where they lie in a world.
struct Placed {
    std::vector<const StoredSquare*> squares;
    std::vector<std::optional<Extent>> extents;
};

// Catalogues may have a CRS of their own, as that of a country whose surveys have many. Only for
// those is the module loaded that knows how to get from one to another.
void place(const std::string& crs, const voxel::WorldInfo& world, Placed& placed) {
    if (crs.empty() || world.crs_wkt.empty() || crs == world.crs)
        return;
    try {
        module::place_extents(crs, world.crs_wkt, placed.extents);
    } catch (const util::Error& error) {
        spdlog::warn("squares that are not fetched are not shown: {}", error.what());
        placed.extents.assign(placed.extents.size(), std::nullopt);
    }
}

http::SquareEntry make_entry(const StoredSquare& s, const Extent& extent,
                             const voxel::WorldInfo& info) {
    http::SquareEntry out;
    out.name = s.name;
    out.state = s.state == StoredState::kWanted ? "wanted" : "failed";
    if (!s.error.empty())
        out.error = s.error;
    if (s.points > 0)
        out.points = s.points;
    out.bytes = s.bytes;
    add_terms(s, out);
    const auto voxel = [&](double value) {
        return static_cast<std::int32_t>(std::clamp(value / info.crs_units_per_voxel, -1e9, 1e9));
    };
    const auto& [west, south, east, north] = extent;
    out.min_x = voxel(west);
    out.max_x = voxel(east);
    out.min_z = voxel(-north);
    out.max_z = voxel(-south);
    return out;
}

std::vector<http::SquareEntry> unfetched_squares(const GrabberStore& store,
                                                 const voxel::WorldInfo& world) {
    std::map<std::string, Placed> by_crs;
    for (const StoredSquare& s : store.squares) {
        if (s.state == StoredState::kFetched || s.state == StoredState::kMissing)
            continue;
        Placed& placed = by_crs[s.bounds_crs];
        placed.squares.push_back(&s);
        placed.extents.push_back(stored_extent(s));
    }
    std::vector<http::SquareEntry> out;
    for (auto& [crs, placed] : by_crs) {
        place(crs, world, placed);
        for (std::size_t i = 0; i < placed.squares.size(); ++i)
            if (placed.extents[i])
                out.push_back(make_entry(*placed.squares[i], *placed.extents[i], world));
    }
    return out;
}

}  // namespace

std::vector<http::SquareEntry> SquareList::entries(std::span<const voxelize::SquareInfo> opened,
                                                   const voxel::WorldInfo& world) {
    std::map<std::string, const StoredSquare*> by_file;
    if (m_store)
        for (const StoredSquare& s : m_store->squares)
            if (!s.file.empty())
                by_file[s.file.string()] = &s;
    std::vector<http::SquareEntry> out;
    for (const voxelize::SquareInfo& s : opened) {
        out.push_back(make_entry(s));
        if (const auto stored = by_file.find(s.file.string()); stored != by_file.end())
            add_terms(*stored->second, out.back());
    }
    if (m_store)
        std::call_once(m_once, [&] { m_unfetched = unfetched_squares(*m_store, world); });
    out.insert(out.end(), m_unfetched.begin(), m_unfetched.end());
    return out;
}

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

namespace {

bool is_lidar_or_store(const std::string& input) {
    return !worlds::is_http_address(input) && (worlds::is_store(input) || worlds::is_lidar(input));
}

OpenedForServing open_lidar(const Options& options, const Plan& plan, util::StageTimes& times) {
    OpenedForServing out;
    const auto& inputs = options.world.inputs;
    std::filesystem::path store = options.store;
    if (inputs.size() == 1 && worlds::is_store(inputs.front()))
        store = inputs.front();
    const bool is_store = !store.empty();
    worlds::check_flags(is_store ? store.string() : inputs.front(),
                        is_store ? "a store" : "LiDAR data", worlds::kLidarFlags,
                        options.kind_flags);
    voxelize::LidarWorldOptions lidar = worlds::lidar_options(options.world);
    lidar.cache_bytes = plan.square_bytes;
    if (is_store) {
        out.store = store::read_grabber_store(store);
        voxelize::take_from_store(*out.store, lidar);
    } else {
        lidar.files.assign(inputs.begin(), inputs.end());
    }
    auto world = std::make_unique<DeferredWorld>(
        lidar, times, DeferredWorld::Means{plan.facts, plan.image_bytes});
    out.lidar = world.get();
    out.world = std::move(world);
    return out;
}

OpenedForServing open_other(const Options& options, const Plan& plan, util::StageTimes& times,
                            const std::stop_token& stop) {
    const worlds::ServeRequest request{options.world, options.kind_flags, module::worlds_module()};
    OpenedForServing out;
    out.world = module::open_served_world(request, times, stop, plan.image_bytes);
    if (stop.stop_requested())
        throw util::Error("open the world " + options.world.inputs.front() + ": stopped");
    return out;
}

}  // namespace

OpenedForServing open_for_serving(const Options& options, const Plan& plan, util::StageTimes& times,
                                  const std::stop_token& stop) {
    const auto& inputs = options.world.inputs;
    const bool all_lidar = std::all_of(inputs.begin(), inputs.end(), is_lidar_or_store);
    if (!options.store.empty() || all_lidar)
        return open_lidar(options, plan, times);
    return open_other(options, plan, times, stop);
}

}  // namespace terravox::serve
