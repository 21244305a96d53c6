#include "tests/bench/accuracy/photo_seams.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "tests/bench/accuracy/linear_colour.hpp"
#include "tests/bench/accuracy/photo_mosaic_survey.hpp"
#include "voxelserver/voxelize/points/settings.hpp"
#include "voxelserver/voxelize/steps/photo_lights.hpp"

namespace terravox::bench {
namespace {

/// The logarithm of albedo over the truth by columns; NaN = not known.
class RatioGrid {
public:
    explicit RatioGrid(const grid::ColumnRect& bounds)
        : m_bounds(bounds),
          m_values(static_cast<std::size_t>(width()) * static_cast<std::size_t>(depth()),
                   std::numeric_limits<float>::quiet_NaN()) {}

    void add(grid::PatchKey key, const imagery::Raster& albedo, const imagery::Raster& truth) {
        constexpr double kDark = 0.004;  // below it, bytes are too coarse
        for (std::size_t i = 0; i < truth.colour.size() && i < albedo.colour.size(); ++i) {
            const int x = key.x0() + static_cast<int>(i) % grid::kPatchSize;
            const int z = key.z0() + static_cast<int>(i) / grid::kPatchSize;
            const double is = luminance_of(albedo.colour[i]);
            const double should_be = luminance_of(truth.colour[i]);
            if (x < m_bounds.min_x || x >= m_bounds.max_x || z < m_bounds.min_z ||
                z >= m_bounds.max_z || std::min(is, should_be) < kDark)
                continue;
            m_values[index(x, z)] = static_cast<float>(std::log(is / should_be));
        }
    }

    /// The steps across a line from north to south, or from west to east.
    void add_steps(int at, bool southwards, std::vector<double>& out) const {
        constexpr int kWide = 12;
        constexpr int kLong = 64;
        const int begin = southwards ? m_bounds.min_z : m_bounds.min_x;
        const int end = southwards ? m_bounds.max_z : m_bounds.max_x;
        for (int along = begin; along + kLong <= end; along += kLong) {
            const auto side = [&](int from) {
                return southwards ? median({from, along, from + kWide, along + kLong})
                                  : median({along, from, along + kLong, from + kWide});
            };
            const std::optional<double> before = side(at - kWide);
            const std::optional<double> after = side(at);
            if (before && after)
                out.push_back(*after - *before);
        }
    }

private:
    [[nodiscard]] int width() const noexcept { return m_bounds.max_x - m_bounds.min_x; }
    [[nodiscard]] int depth() const noexcept { return m_bounds.max_z - m_bounds.min_z; }
    [[nodiscard]] std::size_t index(int x, int z) const noexcept {
        return static_cast<std::size_t>(z - m_bounds.min_z) * static_cast<std::size_t>(width()) +
               static_cast<std::size_t>(x - m_bounds.min_x);
    }
    [[nodiscard]] std::optional<double> median(const grid::ColumnRect& rect) const {
        std::vector<float> known;
        for (int z = rect.min_z; z < rect.max_z; ++z)
            for (int x = rect.min_x; x < rect.max_x; ++x)
                if (const float value = m_values[index(x, z)]; value == value)
                    known.push_back(value);
        if (known.empty())
            return std::nullopt;
        const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
        std::nth_element(known.begin(), middle, known.end());
        return static_cast<double>(*middle);
    }

    grid::ColumnRect m_bounds;
    std::vector<float> m_values;
};

double root_mean_square(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values)
        sum += value * value;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

SeamSteps measure_seams(const std::filesystem::path& folder, int threads) {
    const PhotoMosaicSurvey survey = photo_mosaic_survey(folder, threads);
    voxelize::LidarWorldOptions world;
    world.threads = threads;
    world.files = survey.points;
    util::StageTimes times;
    const voxelize::Settings settings;
    voxelize::PointSet points(world, settings, times);
    const grid::Frame& frame = points.sources().frame;
    const imagery::Orthophotos photos(survey.photos, frame);
    const imagery::Orthophotos truths(survey.albedos, frame);
    voxelize::PhotoLights lights(photos, points, times);

    // Rounded to squares: the bounds of points are a column wider in places.
    grid::ColumnRect b = points.sources().bounds;
    const int side = PhotoMosaicSurvey::kSquares * PhotoMosaicSurvey::kSquare_m;
    b.max_x = std::min(b.max_x, b.min_x + side);
    b.max_z = std::min(b.max_z, b.min_z + side);
    RatioGrid ratios(b);
    for (std::int32_t pz = b.min_z >> 6; pz <= (b.max_z - 1) >> 6; ++pz)
        for (std::int32_t px = b.min_x >> 6; px <= (b.max_x - 1) >> 6; ++px) {
            const grid::PatchKey key{px, pz};
            ratios.add(key, lights.albedo(key),
                       truths.read(key.x0(), key.z0(), grid::kPatchSize, grid::kPatchSize));
        }
    constexpr int kEvery = 32;
    std::vector<double> at_borders;
    std::vector<double> elsewhere;
    for (int at = kEvery; at + kEvery <= side - kEvery; at += kEvery)
        for (const bool southwards : {true, false})
            ratios.add_steps((southwards ? b.min_x : b.min_z) + at, southwards,
                             at % PhotoMosaicSurvey::kSquare_m == 0 ? at_borders : elsewhere);
    return {root_mean_square(at_borders), root_mean_square(elsewhere)};
}

}  // namespace terravox::bench
