#include "voxelserver/make/voxelize/steps/scattered.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace terravox::voxelize {

namespace {
constexpr std::size_t kNearest = 12;
}

ScatteredHeights::ScatteredHeights(std::vector<Sample> samples)
    : m_cloud{std::move(samples)},
      m_tree(2, m_cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}

float ScatteredHeights::at(float x, float z, float reach) const {
    std::array<std::uint32_t, kNearest> found{};
    std::array<float, kNearest> squared{};
    const std::array<float, 2> query{x, z};
    std::size_t count = m_tree.knnSearch(query.data(), kNearest, found.data(), squared.data());
    while (count > 0 && squared[count - 1] > reach * reach)
        --count;
    if (count == 0)
        return std::numeric_limits<float>::quiet_NaN();
    // Sums in an order that does not depend on the tree: by distance, then place.
    struct Neighbour {
        float squared;
        Sample sample;
        bool operator<(const Neighbour& o) const noexcept {
            return std::tie(squared, sample.z, sample.x) <
                   std::tie(o.squared, o.sample.z, o.sample.x);
        }
    };
    std::array<Neighbour, kNearest> neighbours{};
    for (std::size_t i = 0; i < count; ++i)
        neighbours[i] = {squared[i], m_cloud.samples[found[i]]};
    for (std::size_t i = 1; i < count; ++i)  // insertion sort: the list is short and nearly sorted
        for (std::size_t k = i; k > 0 && neighbours[k] < neighbours[k - 1]; --k)
            std::swap(neighbours[k], neighbours[k - 1]);
    const float radius = count == kNearest ? std::sqrt(squared[count - 1]) : reach;
    float sum = 0;
    float weights = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const float d = std::sqrt(neighbours[k].squared);
        const float h = neighbours[k].sample.height;
        if (d == 0)
            return h;
        const float w = (radius - d) / (radius * d);
        sum += w * w * h;
        weights += w * w;
    }
    return weights > 0 ? sum / weights : mean_within(x, z, squared[count - 1]);
}

// All found samples are equally far: which of further ones the tree returned must not matter, so
// all at that distance count.
float ScatteredHeights::mean_within(float x, float z, float squared) const {
    std::vector<float> heights;  // rare, so a linear search suffices
    for (const Sample& s : m_cloud.samples)
        if ((s.x - x) * (s.x - x) + (s.z - z) * (s.z - z) <= squared)
            heights.push_back(s.height);
    std::sort(heights.begin(), heights.end());
    double sum = 0;
    for (const float h : heights)
        sum += static_cast<double>(h);
    return static_cast<float>(sum / static_cast<double>(heights.size()));
}

}  // namespace terravox::voxelize
