#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "common/util/error.hpp"
#include "common/voxel/box.hpp"

namespace terravox::voxel {

/// The data of a world have changed since it was opened. This is not a hole: boxes read before and
/// boxes read now may not match, so the output in progress must be abandoned.
class ChangedError : public util::Error {
public:
    using util::Error::Error;
};

/// The server that a world comes from does not respond, or refuses the request. The state of the
/// box is unknown: a later request may succeed.
class UnreachableError : public util::Error {
public:
    using util::Error::Error;
};

/// An axis-aligned block of voxels, half-open: min <= coordinate < max, in voxels of level 0.
struct VoxelBounds {
    std::array<std::int32_t, 3> min{};
    std::array<std::int32_t, 3> max{};
    [[nodiscard]] bool empty() const noexcept {
        return min[0] >= max[0] || min[1] >= max[1] || min[2] >= max[2];
    }
    friend bool operator==(const VoxelBounds&, const VoxelBounds&) = default;
};

/// Heights of voxels, half-open: min <= y < max, in voxels of level 0.
struct HeightRange {
    std::int32_t min = 0;
    std::int32_t max = 0;
    friend bool operator==(const HeightRange&, const HeightRange&) = default;
};

/// Metadata of a world, available before any box is read.
struct WorldInfo {
    std::string title;
    VoxelBounds bounds;  ///< bounds of all solid voxels, in level-0 voxels
    double voxel_m = 1;  ///< edge of a level-0 voxel, metres
    int levels = 1;      ///< levels 0 .. levels-1 are available
    std::string crs;     ///< short name; empty when the world is not georeferenced
    std::string crs_wkt;
    /// CRS units per voxel: easting = x * crs_units_per_voxel, northing = -z * crs_units_per_voxel,
    /// height_m = y * voxel_m.
    double crs_units_per_voxel = 1;
    /// The middle of the bounds; nullopt when the world is not georeferenced.
    std::optional<geo::MapPlace> centre;
    std::string licence;
    std::string attribution;
    /// The bounds that a camera should frame by default, for worlds without end; empty: `bounds`.
    VoxelBounds framed;
    [[nodiscard]] const VoxelBounds& framed_bounds() const noexcept {
        return framed.empty() ? bounds : framed;
    }
    /// Heights of nearly all that the world holds, where single voxels (birds, clouds, noise) lie
    /// far beyond: what a camera shows by default. Not an extent: boxes and exports have them all.
    std::optional<HeightRange> typical_heights;
    /// A block of voxels within the typical heights; the block itself where nothing of it lies
    /// there.
    [[nodiscard]] VoxelBounds at_typical_heights(const VoxelBounds& block) const noexcept {
        if (!typical_heights)
            return block;
        VoxelBounds out = block;
        out.min[1] = std::max(out.min[1], typical_heights->min);
        out.max[1] = std::min(out.max[1], typical_heights->max);
        return out.empty() ? block : out;
    }
    /// The block that a camera shows by default.
    [[nodiscard]] VoxelBounds camera_bounds() const noexcept {
        return at_typical_heights(framed_bounds());
    }
};

/// The vertical range of the non-empty boxes in one column of boxes.
struct ColumnExtent {
    std::int32_t by_begin = 0, by_end = 0;  ///< half-open; equal when the column is air
    [[nodiscard]] bool empty() const noexcept { return by_begin >= by_end; }
    friend bool operator==(const ColumnExtent&, const ColumnExtent&) = default;
};

[[nodiscard]] constexpr std::int32_t floor_div(std::int32_t a, std::int32_t b) noexcept {
    return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}

/// The boxes of a level that cover bounds: keys with min <= coordinate < max (level is set in
/// both).
struct BoxRange {
    BoxKey min;
    BoxKey max;
    /// @param key of the same level
    [[nodiscard]] bool contains(const BoxKey& key) const noexcept {
        return key.bx >= min.bx && key.bx < max.bx && key.by >= min.by && key.by < max.by &&
               key.bz >= min.bz && key.bz < max.bz;
    }
};
[[nodiscard]] inline BoxRange boxes_over(const VoxelBounds& b, int level) noexcept {
    const auto range = [&](std::size_t axis, std::int32_t size, std::int32_t& lo,
                           std::int32_t& hi) {
        const std::int32_t scaled = size << level;
        lo = floor_div(b.min[axis], scaled);
        hi = floor_div(b.max[axis] - 1, scaled) + 1;
    };
    BoxRange out;
    out.min.level = out.max.level = level;
    range(0, kBoxSizeX, out.min.bx, out.max.bx);
    range(1, kBoxSizeY, out.min.by, out.max.by);
    range(2, kBoxSizeZ, out.min.bz, out.max.bz);
    return out;
}

/// The result of a request for a box.
struct BoxOutcome {
    std::shared_ptr<const Box> box;  ///< nullptr: air throughout, or unavailable
    std::exception_ptr failure;      ///< why the box is unavailable; null: it is available
};
/// Receives the result for one of several boxes. Must not throw.
using TakeBox = std::function<void(const BoxKey&, BoxOutcome)>;

/// A source of boxes. Axes: x east, y up, z south (right-handed); the integer voxel (x, y, z)
/// covers [x, x+1) and so on. Implementations are thread-safe, and return the same box for the same
/// key at any time and in any order.
class World {
public:
    World() = default;
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    virtual ~World() = default;

    [[nodiscard]] virtual const WorldInfo& info() const noexcept = 0;

    /// @return the box, or nullptr when it is known to be air throughout
    /// @throws Error when the box cannot be made or fetched: a hole must never be returned as air;
    /// ChangedError when the source now holds another world
    [[nodiscard]] virtual std::shared_ptr<const Box> box(const BoxKey& key) = 0;

    /// Requests several boxes. Calls `take` once for each key, as soon as its box is available, in
    /// any order, on the calling thread. An unavailable box does not delay the others.
    /// @param keys without duplicates
    virtual void boxes(std::span<const BoxKey> keys, const TakeBox& take) {
        for (const BoxKey& key : keys) {
            BoxOutcome outcome;
            try {
                outcome.box = box(key);
            } catch (...) {
                outcome.failure = std::current_exception();
            }
            take(key, std::move(outcome));
        }
    }
    /// The preferred number of keys per call of boxes(), at least 1. More than 1 where a request
    /// has a high overhead, as over a network.
    [[nodiscard]] virtual int preferred_batch() const noexcept { return 1; }

    /// The number of threads that can usefully request boxes at once; more than the number of cores
    /// where each response has latency, as over a network.
    /// @param threads the number that would be used otherwise
    [[nodiscard]] virtual int useful_concurrency(int threads) const noexcept { return threads; }

    /// A cheap upper bound of where box() is not nullptr; boxes inside may still be air.
    /// @throws Error as box()
    [[nodiscard]] virtual ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) = 0;

    /// Whether any of these boxes may contain something other than air: cheap and conservative (no
    /// false negatives). Used to find the solid parts of a world that is wide and mostly air.
    /// @throws Error as box()
    [[nodiscard]] virtual bool may_hold(const BoxRange& /*boxes*/) { return true; }

    /// Damaged parts of the world's data found so far, one line each; boxes are made without them.
    /// Callers must report them, and count each like a hole.
    [[nodiscard]] virtual std::vector<std::string> damage() const { return {}; }

    /// Identifies the version of the data that the world was opened from, where its name and info()
    /// do not: one line, so that interrupted work is not resumed with other data. Empty: files,
    /// which have names of their own, or unknown.
    [[nodiscard]] virtual std::string edition() const { return {}; }

    /// Makes requests in progress and later ones end soon with an Error: for Ctrl-C.
    virtual void stop() noexcept {}
};

/// The extent of all inputs that contributed to a box: box columns of level 0, half-open.
struct InputExtent {
    std::int32_t min_bx = 0;
    std::int32_t min_bz = 0;
    std::int32_t max_bx = 0;
    std::int32_t max_bz = 0;
    [[nodiscard]] bool empty() const noexcept { return min_bx >= max_bx || min_bz >= max_bz; }
    /// Grows to include `other`.
    void add(const InputExtent& other) noexcept {
        if (other.empty())
            return;
        if (empty()) {
            *this = other;
            return;
        }
        min_bx = std::min(min_bx, other.min_bx);
        min_bz = std::min(min_bz, other.min_bz);
        max_bx = std::max(max_bx, other.max_bx);
        max_bz = std::max(max_bz, other.max_bz);
    }
    friend bool operator==(const InputExtent&, const InputExtent&) = default;
};

/// Equal inputs have the same fingerprint, in every process and on every machine.
using Fingerprint = std::array<std::uint64_t, 2>;

/// A box and the extent of the inputs that it was made from.
struct BoxWithInputs {
    std::shared_ptr<const Box> box;  ///< nullptr: air throughout
    InputExtent reach;
};

/// A world that tracks the inputs of its boxes, so that they can be cached across processes: a
/// cached box is still valid when the fingerprint of its reach is unchanged.
class ProvenanceWorld : public World {
public:
    /// As box(), and also returns the reach of its inputs.
    /// @throws Error as box()
    [[nodiscard]] virtual BoxWithInputs box_with_inputs(const BoxKey& key) = 0;
    /// Identifies all inputs that lie in or reach into `reach`, and everything that every box
    /// depends on (settings, frame, algorithm versions).
    [[nodiscard]] virtual Fingerprint fingerprint(const InputExtent& reach) const = 0;
};

inline constexpr int kWorldVersion = 2;  ///< version of the HTTP interface: /v2

/// The response body of GET /v2/world (docs/formats/http.md).
[[nodiscard]] std::string world_to_json(const WorldInfo& info);

/// The inverse of world_to_json(), for untrusted text.
/// @param origin names the text in error messages
/// @throws Error for a wrong version, a missing or invalid value, or bounds that are too large for
/// the number of levels: the boxes of the coarsest level over them are at most 16,384 on an edge
/// and 4,194,304 in all, so that rendering a world of air terminates
[[nodiscard]] WorldInfo world_from_json(const std::string& text, const std::string& origin);

}  // namespace terravox::voxel
