#include "voxelserver/serve/store_world.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "common/util/error.hpp"

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

// Squares are named E_N by their south-western corner in kilometres; this is used where the store
// has no bounds for one that it has not fetched.
std::optional<store::StoredBounds> bounds_of(const StoredSquare& s) {
    if (s.bounds)
        return s.bounds;
    double e = 0;
    double n = 0;
    char tail = 0;
    if (std::sscanf(s.name.c_str(), "%lf_%lf%c", &e, &n, &tail) != 2 || !std::isfinite(e) ||
        !std::isfinite(n))
        return std::nullopt;
    return store::StoredBounds{{e * 1000, n * 1000, 0}, {(e + 1) * 1000, (n + 1) * 1000, 0}};
}

http::SquareEntry entry_of(const StoredSquare& s, const store::StoredBounds& bounds,
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
    out.min_x = voxel(bounds.min[0]);
    out.max_x = voxel(bounds.max[0]);
    out.min_z = voxel(-bounds.max[1]);
    out.max_z = voxel(-bounds.min[1]);
    return out;
}

}  // namespace

std::vector<http::SquareEntry> squares_of(const DeferredWorld& world,
                                          const std::optional<GrabberStore>& store) {
    std::map<std::string, const StoredSquare*> by_file;
    if (store)
        for (const StoredSquare& s : store->squares)
            if (!s.file.empty())
                by_file[s.file.string()] = &s;
    std::vector<http::SquareEntry> out;
    for (const voxelize::SquareInfo& s : world.squares()) {
        out.push_back(entry_of(s));
        if (const auto stored = by_file.find(s.file.string()); stored != by_file.end())
            add_terms(*stored->second, out.back());
    }
    if (!store)
        return out;
    for (const StoredSquare& s : store->squares) {
        if (s.state == StoredState::kFetched || s.state == StoredState::kMissing)
            continue;
        if (const auto bounds = bounds_of(s))
            out.push_back(entry_of(s, *bounds, world.info()));
    }
    return out;
}

}  // namespace terravox::serve
