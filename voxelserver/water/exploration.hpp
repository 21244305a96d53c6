#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/water/evidence.hpp"
#include "voxelserver/water/water_cells.hpp"

namespace terravox::water {

/// A patch's index.
struct PatchIndex {
    std::int32_t x = 0, z = 0;
    bool operator==(const PatchIndex&) const = default;
};
struct PatchIndexHash {
    std::size_t operator()(PatchIndex p) const noexcept {
        const std::uint64_t both = static_cast<std::uint64_t>(static_cast<std::uint32_t>(p.x))
                                       << 32 |
                                   static_cast<std::uint32_t>(p.z);
        return static_cast<std::size_t>((both ^ both >> 29) * 0x9e3779b97f4a7c15u >> 7);
    }
};
/// One byte for each cell of a patch, not 0 = set.
using CellFlags = std::vector<std::uint8_t>;
using FlaggedPatches = std::unordered_map<PatchIndex, CellFlags, PatchIndexHash>;

/// Division that rounds down; b > 0.
[[nodiscard]] constexpr std::int32_t floor_div(std::int32_t a, std::int32_t b) noexcept {
    return a / b - (a % b < 0 ? 1 : 0);
}

/// Cells of one patch from a source, checked. @throws Error when the source gives null or a patch
/// of another size
[[nodiscard]] std::shared_ptr<const CellPatch> checked_cells(CellSource& source, PatchIndex patch,
                                                             int side);

/// How far an exploration may go.
struct Bounds {
    std::size_t patches = 0;  ///< patches loaded, the start's included
    /// With it, only the patches of one square of a fixed grid are entered: square edge in patches.
    std::optional<std::int32_t> square;
    /// Cells known to belong to a body that exceeds `patches`: touching one ends the exploration as
    /// exceeding it would. May be null.
    const FlaggedPatches* oversize = nullptr;
};

/// All candidates connected (over edges) with one candidate, collected patch by patch.
class Exploration final : public Candidates {
public:
    /// Holds references to both.
    Exploration(CellSource& source, int side, const Evidence& evidence)
        : m_source(source), m_side(side), m_evidence(evidence) {}

    /// @param start a candidate @return false when the body goes on beyond the bounds: which cells
    /// were reached then depends on the start
    [[nodiscard]] bool run(CellPlace start, const Bounds& bounds);
    /// Sorts what was found; call once, after run().
    void list();

    [[nodiscard]] const std::vector<CellPlace>& places() const override { return m_places; }
    [[nodiscard]] const WaterCell* find(CellPlace place) const override;
    /// Holds every patch that was looked at; of a finished exploration the same whatever it started
    /// from.
    [[nodiscard]] voxel::InputExtent reach() const noexcept;
    /// Calls visit(patch, flags of the cells found in it) for each patch with such cells, in no
    /// promised order.
    template <class Visit>
    void for_each_patch(const Visit& visit) const {
        for (const auto& [patch, v] : m_visits)
            if (v.count > 0)
                visit(patch, v.found);
    }

private:
    struct Visited {
        std::shared_ptr<const CellPatch> cells;
        CellFlags found;
        std::vector<std::int32_t> waiting;  // found, neighbours not looked at yet
        std::uint32_t count = 0;
        const CellFlags* oversize = nullptr;
    };
    Visited* visit(PatchIndex patch);
    void touch(PatchIndex patch, Visited& v, int x, int z);
    void spread(PatchIndex patch);
    void cross(PatchIndex to, int x, int z);

    CellSource& m_source;
    int m_side;
    const Evidence& m_evidence;
    Bounds m_bounds;
    PatchIndex m_square;  // of the start, when bounded to one
    bool m_exceeded = false;
    std::unordered_map<PatchIndex, Visited, PatchIndexHash> m_visits;
    std::vector<PatchIndex> m_queue;
    std::vector<CellPlace> m_places;
};

}  // namespace terravox::water
