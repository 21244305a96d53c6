#include "voxelserver/voxelize/ground_fill.hpp"

#include <array>
#include <cmath>
#include <nanoflann.hpp>
#include <tuple>

namespace terravox::voxelize {
namespace {

constexpr int kReach = 32;       // voxels
constexpr std::size_t kNearest = 10;

struct GroundColumns {
    struct Entry { std::int16_t x, z; float height; };
    std::vector<Entry> entries;

    // nanoflann's data set interface.
    [[nodiscard]] std::size_t kdtree_get_point_count() const { return entries.size(); }
    [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const { return axis == 0 ? entries[i].x : entries[i].z; }
    template <class Box> bool kdtree_get_bbox(Box&) const { return false; }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, GroundColumns>, GroundColumns, 2, std::uint32_t>;

float interpolate(const Tree& tree, const GroundColumns& ground, int x, int z, float otherwise) {
    std::array<std::uint32_t, kNearest> found{};
    std::array<float, kNearest> squared{};
    const std::array<float, 2> query{static_cast<float>(x), static_cast<float>(z)};
    std::size_t count = tree.knnSearch(query.data(), kNearest, found.data(), squared.data());
    while (count > 0 && squared[count - 1] > static_cast<float>(kReach * kReach)) --count;
    if (count == 0) return otherwise;
    // Sums in an order that does not depend on the tree: by distance, then place.
    struct Neighbour {
        float squared;
        GroundColumns::Entry entry;
        bool operator<(const Neighbour& o) const noexcept { return std::tie(squared, entry.z, entry.x) < std::tie(o.squared, o.entry.z, o.entry.x); }
    };
    std::array<Neighbour, kNearest> neighbours{};
    for (std::size_t i = 0; i < count; ++i) neighbours[i] = {squared[i], ground.entries[found[i]]};
    for (std::size_t i = 1; i < count; ++i)  // insertion sort: the list is short and nearly sorted
        for (std::size_t k = i; k > 0 && neighbours[k] < neighbours[k - 1]; --k) std::swap(neighbours[k], neighbours[k - 1]);
    const float radius = count == kNearest ? std::sqrt(squared[count - 1]) : static_cast<float>(kReach);
    float sum = 0, weights = 0, plain = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const float d = std::sqrt(neighbours[k].squared), h = neighbours[k].entry.height;
        const float w = (radius - d) / (radius * d);  // d >= 1: the column itself has no ground
        sum += w * w * h, weights += w * w, plain += h;
    }
    return weights > 0 ? sum / weights : plain / static_cast<float>(count);
}

}  // namespace

Margined<float> fill_ground(const Window& window, const TerrainGrid& terrain, std::int32_t x0, std::int32_t z0) {
    constexpr int kMargin = Margined<float>::kMargin;
    GroundColumns ground;
    bool gaps = false;
    for (int z = -kMargin - kReach; z < kPatchSize + kMargin + kReach; ++z)
        for (int x = -kMargin - kReach; x < kPatchSize + kMargin + kReach; ++x) {
            const Surface& g = window.column(x, z).ground;
            if (g.seen()) ground.entries.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(z), g.height});
            else gaps = true;
        }
    Margined<float> out;
    if (!gaps) {
        for (int z = -kMargin; z < kPatchSize + kMargin; ++z)
            for (int x = -kMargin; x < kPatchSize + kMargin; ++x) out.at(x, z) = window.column(x, z).ground.height;
        return out;
    }
    const Tree tree(2, ground, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    for (int z = -kMargin; z < kPatchSize + kMargin; ++z)
        for (int x = -kMargin; x < kPatchSize + kMargin; ++x) {
            const Surface& g = window.column(x, z).ground;
            out.at(x, z) = g.seen() ? g.height
                           : ground.entries.empty() ? terrain.ground(x0 + x, z0 + z)
                                                    : interpolate(tree, ground, x, z, terrain.ground(x0 + x, z0 + z));
        }
    return out;
}

}  // namespace terravox::voxelize
