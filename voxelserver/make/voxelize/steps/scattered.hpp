#pragma once

#include <array>
#include <cstdint>
#include <nanoflann.hpp>
#include <vector>

namespace terravox::voxelize {

/// Heights at scattered places of a plane, with a k-d tree over them, to interpolate between what
/// was seen.
/// Ref: Franke & Nielson, "Smooth interpolation of large sets of scattered data", 1980 (weights
/// that vanish at the farthest neighbour, so that it does not matter which of several equally far
/// ones were taken).
class ScatteredHeights {
public:
    struct Sample {
        float x;
        float z;
        float height;
    };

    /// @param samples  at least one
    explicit ScatteredHeights(std::vector<Sample> samples);
    ScatteredHeights(const ScatteredHeights&) = delete;
    ScatteredHeights& operator=(const ScatteredHeights&) = delete;

    /// The mean of the nearest samples, weighted by distance. Does not depend on the order in which
    /// samples were given.
    /// @param reach samples farther away do not count
    /// @return NaN when none is within reach
    [[nodiscard]] float at(float x, float z, float reach) const;

private:
    [[nodiscard]] float mean_within(float x, float z, float squared) const;
    // nanoflann's data set interface.
    struct Cloud {
        std::vector<Sample> samples;
        [[nodiscard]] std::size_t kdtree_get_point_count() const { return samples.size(); }
        [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
            return axis == 0 ? samples[i].x : samples[i].z;
        }
        template <class Box>
        bool kdtree_get_bbox(Box&) const {
            return false;
        }
    };
    using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>,
                                                     Cloud, 2, std::uint32_t>;
    Cloud m_cloud;
    Tree m_tree;
};

}  // namespace terravox::voxelize
