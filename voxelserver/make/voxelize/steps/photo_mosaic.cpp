#include "voxelserver/make/voxelize/steps/photo_mosaic.hpp"

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

/// The share of a rectangle that others cover, by 16 x 16 points of it.
double covered_share(const grid::ColumnRect& rect, const std::vector<grid::ColumnRect>& others) {
    constexpr std::int64_t kPoints = 16;
    int covered = 0;
    const auto at = [](std::int32_t min, std::int32_t max, std::int64_t i) {
        const std::int64_t length = std::int64_t{max} - min;
        return static_cast<std::int32_t>(min + length * (2 * i + 1) / (2 * kPoints));
    };
    for (std::int64_t row = 0; row < kPoints; ++row)
        for (std::int64_t column = 0; column < kPoints; ++column) {
            const std::int32_t x = at(rect.min_x, rect.max_x, column);
            const std::int32_t z = at(rect.min_z, rect.max_z, row);
            const grid::ColumnRect point{x, z, x + 1, z + 1};
            if (std::any_of(others.begin(), others.end(),
                            [&](const grid::ColumnRect& r) { return r.overlaps(point); }))
                ++covered;
        }
    return static_cast<double>(covered) / (kPoints * kPoints);
}

/// Whether an image is covered by less than half, and covers less than half of each of the others.
bool fits(const grid::ColumnRect& image, const std::vector<grid::ColumnRect>& others) {
    constexpr double kMost = 0.5;
    return covered_share(image, others) < kMost &&
           std::none_of(
               others.begin(), others.end(),
               [&](const grid::ColumnRect& other) {
                   return covered_share(other, {image}) >= kMost;
               });
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
    for (std::size_t i = 0; i < m_images.size(); ++i) {
        m_around.push_back({i});
        for (const std::size_t other : near(i))
            if (m_images[other].mosaic == m_images[i].mosaic)
                m_around.back().push_back(other);
        std::sort(m_around.back().begin(), m_around.back().end());
    }
}

// Each image joins the first mosaic that covers less than half of it, and of whose images it covers
// less than half: where a place was photographed several times, each time becomes a mosaic.
void PhotoMosaic::find_mosaics() {
    for (std::size_t i = 0; i < m_images.size(); ++i) {
        std::map<std::size_t, std::vector<grid::ColumnRect>> overlapping;  // by mosaic
        for (const std::size_t other : near(i))
            if (other < i && m_images[other].rect.overlaps(m_images[i].rect))
                overlapping[m_images[other].mosaic].push_back(m_images[other].rect);
        const auto is_room_in = [&](std::size_t mosaic) {
            const auto found = overlapping.find(mosaic);
            return found == overlapping.end() || fits(m_images[i].rect, found->second);
        };
        while (!is_room_in(m_images[i].mosaic))
            ++m_images[i].mosaic;
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

std::vector<PhotoMosaic::Weight> PhotoMosaic::weights(std::size_t image, std::int32_t x,
                                                      std::int32_t z) const {
    std::vector<Weight> out;
    std::vector<float> largest_first;
    for (const std::size_t i : m_around[image]) {
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
