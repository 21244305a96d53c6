#include "voxelserver/voxelize/steps/photo_mosaic.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

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

float weight_at(const grid::ColumnRect& r, std::int32_t x, std::int32_t z) noexcept {
    if (r.max_x <= r.min_x || r.max_z <= r.min_z)
        return 0;
    return Reach(r.min_x, r.max_x).weight(x) * Reach(r.min_z, r.max_z).weight(z);
}

}  // namespace

PhotoMosaic::PhotoMosaic(std::span<const imagery::Orthophotos::Input> images) {
    for (const imagery::Orthophotos::Input& image : images) {
        m_west_to_east.push_back(m_images.size());
        m_images.push_back({image.rect, image.series, 0});
        m_max_width = std::max(m_max_width, std::int64_t{image.rect.max_x} - image.rect.min_x);
    }
    std::sort(m_west_to_east.begin(), m_west_to_east.end(), [&](std::size_t a, std::size_t b) {
        return m_images[a].rect.min_x < m_images[b].rect.min_x;
    });
    find_mosaics();
}

// Each image joins the first mosaic that covers less than half of it, and of whose images it covers
// less than half: where a place was photographed several times, each time becomes a mosaic.
void PhotoMosaic::find_mosaics() {
    struct Overlap {
        std::int64_t area = 0;
        bool too_much = false;
    };
    for (std::size_t i = 0; i < m_images.size(); ++i) {
        const std::int64_t own_area = m_images[i].rect.area();
        std::map<std::size_t, Overlap> by_mosaic;
        for (const std::size_t other : near(i)) {
            if (other > i)
                continue;
            const std::int64_t area = m_images[i].rect.common(m_images[other].rect).area();
            Overlap& sum = by_mosaic[m_images[other].mosaic];
            sum.area += area;
            sum.too_much =
                sum.too_much || 2 * area >= m_images[other].rect.area() || 2 * sum.area >= own_area;
        }
        std::size_t mosaic = 0;
        while (by_mosaic.contains(mosaic) && by_mosaic.at(mosaic).too_much)
            ++mosaic;
        m_images[i].mosaic = mosaic;
    }
}

std::vector<std::size_t> PhotoMosaic::near(std::size_t image) const {
    const grid::ColumnRect& own = m_images[image].rect;
    const auto starts_before = [&](std::size_t i, std::int64_t x) {
        return m_images[i].rect.min_x < x;
    };
    // No image counts further from its western edge than this.
    const std::int64_t first_x = std::int64_t{own.min_x} - m_max_width - m_max_width / 2 - 1;
    const std::int64_t end_x = std::int64_t{own.max_x} + m_max_width / 2 + 1;
    std::vector<std::size_t> out;
    for (auto at =
             std::lower_bound(m_west_to_east.begin(), m_west_to_east.end(), first_x, starts_before);
         at != m_west_to_east.end() && m_images[*at].rect.min_x <= end_x; ++at) {
        const grid::ColumnRect& other = m_images[*at].rect;
        if (*at != image && m_images[*at].series == m_images[image].series &&
            Reach(other.min_x, other.max_x).meets(own.min_x, own.max_x) &&
            Reach(other.min_z, other.max_z).meets(own.min_z, own.max_z))
            out.push_back(*at);
    }
    return out;
}

std::vector<std::size_t> PhotoMosaic::around(std::size_t image) const {
    std::vector<std::size_t> out{image};
    for (const std::size_t other : near(image))
        if (m_images[other].mosaic == m_images[image].mosaic)
            out.push_back(other);
    std::sort(out.begin(), out.end());
    return out;
}

std::vector<PhotoMosaic::Weight> PhotoMosaic::weights(std::size_t image, std::int32_t x,
                                                      std::int32_t z) const {
    std::vector<Weight> out;
    std::vector<float> largest_first;
    for (const std::size_t i : around(image)) {
        out.push_back({i, weight_at(m_images[i].rect, x, z)});
        largest_first.push_back(out.back().weight);
    }
    float fifth = 0;
    if (largest_first.size() > kMostImages) {
        const auto at = largest_first.begin() + kMostImages;
        std::nth_element(largest_first.begin(), at, largest_first.end(), std::greater<>());
        fifth = *at;
    }
    std::erase_if(out, [&](const Weight& one) { return !(one.weight > fifth); });
    for (Weight& one : out)
        one.weight -= fifth;
    return out;
}

}  // namespace terravox::voxelize
