#include "tests/bench/accuracy/photo_flights.hpp"

#include <cmath>
#include <cstdlib>

#include "tests/bench/accuracy/linear_colour.hpp"
#include "voxelserver/survey/survey.hpp"
#include "voxelserver/voxelize/points/settings.hpp"
#include "voxelserver/voxelize/steps/photo_lights.hpp"

namespace terravox::bench {
namespace {

constexpr int kSquare_m = 512;

survey::SurveyOptions survey_of(const Flight& flight, const std::filesystem::path& folder,
                                int threads) {
    survey::SurveyOptions out;
    out.seed = flight.seed;
    out.density = 8;
    out.square_m = kSquare_m;
    out.origin_east_m = 462240;
    out.origin_north_m = 101232;
    out.photo_light = flight.light;
    out.threads = threads;
    out.folder = folder;
    return out;
}

double squared_difference(voxel::Rgb8 a, voxel::Rgb8 b) {
    const auto part = [](std::uint8_t u, std::uint8_t v) {
        const double d = linear_of(u) - linear_of(v);
        return d * d / 3;
    };
    return part(a.r, b.r) + part(a.g, b.g) + part(a.b, b.b);
}

/// The three pictures of one patch.
struct Pictures {
    imagery::Raster raw;
    imagery::Raster albedo;
    imagery::Raster truth;
};

/// Sums over the columns of a flight.
class Sums {
public:
    void add(const Pictures& p) {
        for (std::size_t i = 0; i < p.truth.colour.size(); ++i) {
            if ((p.truth.flags[i] & imagery::Raster::kColour) == 0)
                continue;
            m_raw += squared_difference(p.raw.colour[i], p.truth.colour[i]);
            m_albedo += squared_difference(p.albedo.colour[i], p.truth.colour[i]);
            ++m_count;
        }
        constexpr int kApart = 4;
        for (int z = 0; z + kApart < p.truth.height; ++z)
            for (int x = 0; x + kApart < p.truth.width; ++x) {
                const auto i = static_cast<std::size_t>(z * p.truth.width + x);
                compare(p, i, i + kApart);
                compare(p, i, i + static_cast<std::size_t>(kApart * p.truth.width));
            }
    }

    void put(FlightErrors& out) const {
        out.raw_rmse = std::sqrt(m_raw / m_count);
        out.albedo_rmse = std::sqrt(m_albedo / m_count);
        out.raw_contrast = m_raw_contrast / m_pairs;
        out.albedo_contrast = m_albedo_contrast / m_pairs;
    }

private:
    // Two columns of one material, one of which lies in the sun and the other in the shadow.
    void compare(const Pictures& p, std::size_t a, std::size_t b) {
        constexpr double kSame = 0.05;
        constexpr double kDark = 0.003;  // below it, bytes are too coarse
        const double truth_a = luminance_of(p.truth.colour[a]);
        const double truth_b = luminance_of(p.truth.colour[b]);
        const double raw_a = luminance_of(p.raw.colour[a]);
        const double raw_b = luminance_of(p.raw.colour[b]);
        if (!(std::min({truth_a, truth_b, raw_a, raw_b}) > kDark) ||
            std::abs(std::log(truth_a / truth_b)) > kSame)
            return;
        constexpr double kLit = 0.9;
        constexpr double kShadow = 0.55;
        const double light_a = raw_a / truth_a;
        const double light_b = raw_b / truth_b;
        const double low = std::min(light_a, light_b);
        const double high = std::max(light_a, light_b);
        if (high < kLit || low > kShadow * high)
            return;
        const double sign = light_a > light_b ? 1 : -1;
        const auto contrast = [&](double of_a, double of_b) {
            return sign * (std::log(std::max(of_a, kDark) / std::max(of_b, kDark)) -
                           std::log(truth_a / truth_b));
        };
        m_raw_contrast += contrast(raw_a, raw_b);
        m_albedo_contrast +=
            contrast(luminance_of(p.albedo.colour[a]), luminance_of(p.albedo.colour[b]));
        ++m_pairs;
    }

    double m_raw = 0;
    double m_albedo = 0;
    double m_count = 0;
    double m_raw_contrast = 0;
    double m_albedo_contrast = 0;
    double m_pairs = 0;
};

}  // namespace

std::vector<Flight> photo_flights() {
    return {
        {1, {150, 40, 0, 0}},    {2, {203, 33, 0, 0}},      {3, {95, 25, 0, 0}},
        {4, {268, 52, 0, 0}},    {5, {180, 64, 0, 0}},      {6, {122, 47, 0, 0}},
        {7, {231, 29, 0, 0}},    {8, {171, 20, 0, 0}},      {9, {140, 58, 0, 0}},
        {10, {212, 44, 0, 0}},   {11, {160, 36, 0, 0}},     {12, {110, 31, 0, 0}},
        {13, {245, 38, 0, 0}},   {14, {195, 61, 0, 0}},     {15, {133, 27, 0.3, 0}},
        {16, {185, 55, 0.5, 0}}, {17, {225, 42, 0.8, 0}},   {18, {155, 35, 0, 0.5}},
        {19, {205, 50, 0, 0.8}}, {20, {128, 45, 0.4, 0.5}},
    };
}

FlightErrors measure_flight(const Flight& flight, const std::filesystem::path& folder,
                            int threads) {
    const survey::SurveyOptions surveyed = survey_of(flight, folder, threads);
    if (!std::filesystem::exists(folder / "truth" / "place.json"))  // written last
        survey::run_survey(surveyed, [](const survey::SquareReport&, std::size_t) {});
    const std::string name = survey::squares_of(surveyed).front().name();
    voxelize::LidarWorldOptions options;
    options.files = {folder / (name + ".laz")};
    options.threads = threads;
    util::StageTimes times;
    const voxelize::Settings settings;
    voxelize::PointSet points(options, settings, times);
    const grid::Frame& frame = points.sources().frame;
    const imagery::Orthophotos photos({folder / "ortho" / (name + ".tif")}, frame);
    const imagery::Orthophotos truths({folder / "truth" / ("albedo_" + name + ".tif")}, frame);
    voxelize::PhotoLights lights(photos, points, times);

    FlightErrors out;
    const voxelize::PhotoLight found = lights.light_of(0);
    out.found = found.light.sun.has_value();
    const double turn = std::abs(found.estimate.sun.azimuth_deg - flight.light.azimuth_deg);
    out.azimuth_deg = std::min(turn, 360 - turn);
    out.altitude_deg = std::abs(found.estimate.sun.altitude_deg - flight.light.altitude_deg);
    Sums sums;
    const grid::ColumnRect b = points.sources().bounds;
    for (std::int32_t pz = b.min_z >> 6; pz <= (b.max_z - 1) >> 6; ++pz)
        for (std::int32_t px = b.min_x >> 6; px <= (b.max_x - 1) >> 6; ++px) {
            const grid::PatchKey key{px, pz};
            Pictures pictures;
            pictures.truth = truths.read(key.x0(), key.z0(), grid::kPatchSize, grid::kPatchSize);
            if (pictures.truth.empty())
                continue;
            pictures.raw = photos.read(key.x0(), key.z0(), grid::kPatchSize, grid::kPatchSize);
            pictures.albedo = lights.albedo(key);
            sums.add(pictures);
        }
    sums.put(out);
    return out;
}

}  // namespace terravox::bench
