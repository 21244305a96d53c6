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

#include "common/geo/crs.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/changed_error.hpp"

namespace terravox::voxel {

/// A block of voxels, half-open: min <= coordinate < max, in voxels of level 0.
struct VoxelBounds {
    std::array<std::int32_t, 3> min{}, max{};
    [[nodiscard]] bool empty() const noexcept {
        return min[0] >= max[0] || min[1] >= max[1] || min[2] >= max[2];
    }
    friend bool operator==(const VoxelBounds&, const VoxelBounds&) = default;
};

/// What is known of a world before any box is read.
struct WorldInfo {
    std::string title;
    VoxelBounds bounds;  ///< of everything solid, level-0 voxels
    double voxel_m = 1;  ///< edge of a level-0 voxel, metres
    int levels = 1;      ///< levels 0 .. levels-1 can be asked for
    std::string crs;     ///< short name, empty when the world has no place on Earth
    std::string crs_wkt;
    /// CRS units per voxel: easting = x * crs_units_per_voxel, northing = -z * crs_units_per_voxel,
    /// height_m = y * voxel_m.
    double crs_units_per_voxel = 1;
    std::optional<geo::LatLon> centre;
    std::string licence, attribution;
    /// What a camera that frames the world frames; empty: bounds. For worlds without end.
    VoxelBounds framed;
    [[nodiscard]] const VoxelBounds& framed_bounds() const noexcept {
        return framed.empty() ? bounds : framed;
    }
};

/// Which boxes of one column of boxes hold anything.
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
    BoxKey min, max;
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

/// What came of asking for a box.
struct BoxOutcome {
    std::shared_ptr<const Box> box;  ///< nullptr: air throughout, or not to be had
    std::exception_ptr failure;      ///< why it cannot be had; null: it can
};
/// Takes what came of one of several boxes. Must not throw.
using TakeBox = std::function<void(const BoxKey&, BoxOutcome)>;

/// Anything that yields boxes. Axes: x east, y up, z south (right-handed), integer voxel (x,y,z)
/// covers [x,x+1) and so on. Implementations are thread-safe, and yield the same box for the same
/// key at any time and in any order.
class World {
public:
    World() = default;
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    virtual ~World() = default;

    [[nodiscard]] virtual const WorldInfo& info() const noexcept = 0;

    /// @return the box, or nullptr when it is known to be air throughout
    /// @throws Error when the box cannot be made or fetched: a hole, never quiet air; ChangedError
    /// when boxes of another world would come
    [[nodiscard]] virtual std::shared_ptr<const Box> box(const BoxKey& key) = 0;

    /// Several boxes; take is called once for each of the keys, as soon as its box has come, in any
    /// order, on this thread. A box that cannot be had holds up no other. @param keys each once
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
    /// How many keys at once suit boxes(), at least 1. More than 1: asking costs much beside
    /// making, as over a network.
    [[nodiscard]] virtual int preferred_batch() const noexcept { return 1; }

    /// How many threads are worth asking at once; more than there are cores where each answer is
    /// waited for, as over a network.
    [[nodiscard]] virtual int useful_concurrency(int threads) const noexcept { return threads; }

    /// A cheap upper bound of where box() is not nullptr; boxes inside may still be air. @throws
    /// Error as box()
    [[nodiscard]] virtual ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) = 0;

    /// Whether any of these boxes may be other than air: cheap, and wrong only by yes. To find what
    /// stands in a world that is wide and mostly air. @throws Error as box()
    [[nodiscard]] virtual bool may_hold(const BoxRange& /*boxes*/) { return true; }

    /// What of the world's data was found damaged so far, one line each; boxes are made without it.
    /// To be told, and counted like a hole.
    [[nodiscard]] virtual std::vector<std::string> damage() const { return {}; }

    /// Names the state of what the world was opened from, where its name and info() do not: one
    /// line, so that work that was cut off does not go on with another state. Empty: files, which
    /// have names of their own, or not known.
    [[nodiscard]] virtual std::string edition() const { return {}; }

    /// Requests under way and later ones end soon with an Error: for Ctrl-C.
    virtual void stop() noexcept {}
};

/// Where everything lies that shaped a box: box columns of level 0, half-open.
struct InputExtent {
    std::int32_t min_bx = 0, min_bz = 0, max_bx = 0, max_bz = 0;
    [[nodiscard]] bool empty() const noexcept { return min_bx >= max_bx || min_bz >= max_bz; }
    /// Grows to hold `other` as well.
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

/// Two inputs that are alike have the same fingerprint, in every process and on every machine.
using Fingerprint = std::array<std::uint64_t, 2>;

/// A box and what it was made of.
struct BoxWithInputs {
    std::shared_ptr<const Box> box;  ///< nullptr: air throughout
    InputExtent reach;
};

/// A world that knows what its boxes are made of, so that they may be kept from one process to the
/// next: a box that was kept is still right when the fingerprint of its reach is what it was.
class ProvenanceWorld : public World {
public:
    /// As box(). @throws Error as box()
    [[nodiscard]] virtual BoxWithInputs traced_box(const BoxKey& key) = 0;
    /// Names all inputs that lie in or reach into `reach`, and all that every box depends on
    /// (settings, frame, ways of making).
    [[nodiscard]] virtual Fingerprint fingerprint(const InputExtent& reach) const = 0;
};

}  // namespace terravox::voxel
