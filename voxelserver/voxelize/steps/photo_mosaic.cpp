#include "voxelserver/voxelize/steps/photo_mosaic.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terravox::voxelize {
namespace {

/// An axis of an image: where it counts. Twice the coordinates, so that middles are whole.
struct Reach {
    std::int64_t twice_middle;
    std::int64_t length;

    Reach(std::int32_t min, std::int32_t max) noexcept
        : twice_middle(std::int64_t{min} + max), length(std::int64_t{max} - min) {}
    [[nodiscard]] float weight(std::int32_t at) const noexcept {
        const auto away = static_cast<float>(std::abs(2 * std::int64_t{at} - twice_middle));
        return std::max(0.0F, 1 - away / static_cast<float>(2 * length));
    }
    [[nodiscard]] bool meets(std::int32_t min, std::int32_t max) const noexcept {
        return 2 * std::int64_t{max} > twice_middle - 2 * length &&
               2 * std::int64_t{min} < twice_middle + 2 * length;
    }
};

}  // namespace

PhotoMosaic::PhotoMosaic(std::vector<grid::ColumnRect> images) : m_images(std::move(images)) {
    for (std::size_t i = 0; i < m_images.size(); ++i) {
        m_west_to_east.push_back(i);
        m_max_width = std::max(m_max_width, std::int64_t{m_images[i].max_x} - m_images[i].min_x);
    }
    std::sort(m_west_to_east.begin(), m_west_to_east.end(),
              [&](std::size_t a, std::size_t b) { return m_images[a].min_x < m_images[b].min_x; });
}

std::vector<std::size_t> PhotoMosaic::around(std::size_t image) const {
    const grid::ColumnRect& own = m_images[image];
    const auto starts_before = [&](std::size_t i, std::int64_t x) { return m_images[i].min_x < x; };
    // No image counts further from its western edge than this.
    const std::int64_t first_x = std::int64_t{own.min_x} - m_max_width - m_max_width / 2 - 1;
    const std::int64_t end_x = std::int64_t{own.max_x} + m_max_width / 2 + 1;
    std::vector<std::size_t> out{image};
    for (auto at =
             std::lower_bound(m_west_to_east.begin(), m_west_to_east.end(), first_x, starts_before);
         at != m_west_to_east.end() && m_images[*at].min_x <= end_x; ++at) {
        const grid::ColumnRect& other = m_images[*at];
        if (*at != image && Reach(other.min_x, other.max_x).meets(own.min_x, own.max_x) &&
            Reach(other.min_z, other.max_z).meets(own.min_z, own.max_z))
            out.push_back(*at);
    }
    std::sort(out.begin(), out.end());
    return out;
}

float PhotoMosaic::weight(std::size_t image, std::int32_t x, std::int32_t z) const noexcept {
    const grid::ColumnRect& r = m_images[image];
    if (r.max_x <= r.min_x || r.max_z <= r.min_z)
        return 0;
    return Reach(r.min_x, r.max_x).weight(x) * Reach(r.min_z, r.max_z).weight(z);
}

}  // namespace terravox::voxelize
