#include "raytracer/analyse/objects/facade_sums.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/objects/connected_cells.hpp"

namespace terravox::analyse {
namespace {

constexpr double kRadPerDeg = det::kPi / 180;
constexpr float kUpright_deg = 90;

/// The bands of a strip of rows that facades need.
class Strip {
public:
    explicit Strip(CellFile& cells) : m_cells(cells) {}

    void read(const CellRectangle& area) {
        for (std::size_t i = 0; i < kNames.size(); ++i)
            m_cells.read(band_number(core::AnalysisKind::kFacade, kNames[i]), area, m_values[i]);
    }
    [[nodiscard]] double of(std::size_t band, std::size_t cell) const noexcept {
        return static_cast<double>(m_values[band][cell]);
    }

    enum : std::size_t { kTotal, kBeam, kHours, kSky, kAzimuth, kBottom, kHeight, kArea };

private:
    static constexpr std::array<const char*, 8> kNames = {
        "kwh_m2", "beam", "sun_hours", "sky_view", "azimuth", "bottom", "height", "area"};
    CellFile& m_cells;
    std::array<std::vector<float>, kNames.size()> m_values;
};

void add_to(FacadeFacts& facade, const Strip& strip, std::size_t cell) {
    const double area_m2 = strip.of(Strip::kArea, cell);
    const det::SinCos azimuth = det::sin_cos(strip.of(Strip::kAzimuth, cell) * kRadPerDeg);
    const double bottom_m = strip.of(Strip::kBottom, cell);
    const double top_m = bottom_m + strip.of(Strip::kHeight, cell);
    facade.bottom_m = facade.faces.empty() ? bottom_m : std::min(facade.bottom_m, bottom_m);
    facade.top_m = facade.faces.empty() ? top_m : std::max(facade.top_m, top_m);
    facade.area_m2 += area_m2;
    facade.kwh += strip.of(Strip::kTotal, cell) * area_m2;
    facade.beam_kwh += strip.of(Strip::kBeam, cell) * area_m2;
    facade.hours_m2 += strip.of(Strip::kHours, cell) * area_m2;
    facade.sky_m2 += strip.of(Strip::kSky, cell) * area_m2;
    facade.east += azimuth.sin * area_m2;
    facade.north += azimuth.cos * area_m2;
}

}  // namespace

double FacadeFacts::azimuth_deg() const noexcept {
    const double azimuth = det::atan2(east, north) / kRadPerDeg;
    return azimuth < 0 ? azimuth + 360 : azimuth;
}

bool FacadeSums::add(CellFile& cells, GDALDatasetH buildings, core::WallSide side,
                     std::int32_t storey, const std::stop_token& stop) {
    const output::GdalWatch watch(cells.attempt());
    GDALRasterBandH numbers = GDALGetRasterBand(buildings, 1);
    const int columns = cells.columns();
    std::vector<std::int32_t> building;
    bool has_walls = false;
    Strip strip(cells);
    CellRectangle area{0, 0, columns, std::clamp(kStripCells / columns, 1, cells.rows())};
    for (; area.y0 < cells.rows(); area.y0 += area.height) {
        check_stop(stop);
        area.height = std::min(area.height, cells.rows() - area.y0);
        const auto count =
            static_cast<std::size_t>(columns) * static_cast<std::size_t>(area.height);
        strip.read(area);
        building.resize(count);
        watch.check(GDALRasterIO(numbers, GF_Read, 0, area.y0, columns, area.height,
                                 building.data(), columns, area.height, GDT_Int32, 0,
                                 0) == CE_None);
        for (std::size_t cell = 0; cell < count; ++cell) {
            if (!(strip.of(Strip::kArea, cell) > 0))
                continue;
            has_walls = true;
            if (building[cell] == 0 && m_unnumbered == Unnumbered::kLeftOut)
                continue;
            if (++m_faces > kMaxFaces)
                throw util::Error(cells.attempt() + ": more than " + std::to_string(kMaxFaces) +
                                  " faces of walls; allowed: a smaller --area");
            const auto azimuth = static_cast<float>(strip.of(Strip::kAzimuth, cell));
            FacadeFacts& facade =
                m_facts[{building[cell], facing_of(kUpright_deg, azimuth), storey}];
            add_to(facade, strip, cell);
            const auto at = static_cast<int>(cell);
            facade.faces.push_back({at % columns, area.y0 + at / columns, side});
        }
    }
    return has_walls;
}

}  // namespace terravox::analyse
