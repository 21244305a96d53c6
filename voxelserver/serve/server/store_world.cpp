#include "voxelserver/serve/server/store_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <spdlog/spdlog.h>

#include "common/util/error.hpp"
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

http::SquareEntry entry_of(const voxelize::SquareInfo& s) {
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

http::SquareEntry entry_of(const StoredSquare& s, const Extent& extent,
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
                out.push_back(entry_of(*placed.squares[i], *placed.extents[i], world));
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
        out.push_back(entry_of(s));
        if (const auto stored = by_file.find(s.file.string()); stored != by_file.end())
            add_terms(*stored->second, out.back());
    }
    if (m_store)
        std::call_once(m_once, [&] { m_unfetched = unfetched_squares(*m_store, world); });
    out.insert(out.end(), m_unfetched.begin(), m_unfetched.end());
    return out;
}

}  // namespace terravox::serve
