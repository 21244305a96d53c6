#include "raytracer/analyse/objects/facades.hpp"

#include <ogr_geometry.h>
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <tuple>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/objects/cell_labels.hpp"
#include "raytracer/analyse/objects/feature_file.hpp"

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
            m_cells.read(kNames[i], area, m_values[i]);
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
                m_facts[{building[cell], find_facing(kUpright_deg, azimuth), storey}];
            add_to(facade, strip, cell);
            const auto at = static_cast<int>(cell);
            facade.faces.push_back({at % columns, area.y0 + at / columns, side});
        }
    }
    return has_walls;
}

namespace {

constexpr FeatureField kFacadeFields[] = {
    {"building", OFTInteger64}, {"facing", OFTString}, {"storey", OFTInteger64},
    {"bottom_m", OFTReal},      {"top_m", OFTReal},    {"area_m2", OFTReal},
    {"kwh_m2", OFTReal},        {"kwh", OFTReal},      {"beam_kwh_m2", OFTReal},
    {"sun_hours", OFTReal},     {"sky_view", OFTReal}, {"azimuth_deg", OFTReal},
    {"faces", OFTInteger64},
};

/// The line of a face: from its first to its last corner, in cells of the raster.
struct Line {
    double x0, y0, x1, y1;
};

Line make_line(const FacadeFace& face) noexcept {
    const double x = face.column;
    const double y = face.row;
    switch (face.side) {
        case core::WallSide::kNorth: return {x, y, x + 1, y};
        case core::WallSide::kSouth: return {x, y + 1, x + 1, y + 1};
        case core::WallSide::kEast: return {x + 1, y, x + 1, y + 1};
        case core::WallSide::kWest: break;
    }
    return {x, y, x, y + 1};
}

/// Faces in the order in which those of one line follow each other.
std::vector<FacadeFace> along_walls(std::vector<FacadeFace> faces) {
    const auto key = [](const FacadeFace& f) {
        const bool is_across = f.side == core::WallSide::kNorth || f.side == core::WallSide::kSouth;
        return is_across ? std::tuple{f.side, f.row, f.column}
                         : std::tuple{f.side, f.column, f.row};
    };
    std::sort(faces.begin(), faces.end(),
              [&](const FacadeFace& a, const FacadeFace& b) { return key(a) < key(b); });
    return faces;
}

/// The lines of faces, of which those that go on in the same direction are one.
OGRMultiLineString make_lines(const FacadeFacts& facade, const std::array<double, 6>& t) {
    OGRMultiLineString out;
    const auto add = [&](const Line& line) {
        auto one = std::make_unique<OGRLineString>();
        one->addPoint(t[0] + line.x0 * t[1], t[3] + line.y0 * t[5]);
        one->addPoint(t[0] + line.x1 * t[1], t[3] + line.y1 * t[5]);
        out.addGeometryDirectly(one.release());
    };
    Line running{};
    bool has_begun = false;
    core::WallSide side = core::WallSide::kNorth;
    for (const FacadeFace& face : along_walls(facade.faces)) {
        const Line line = make_line(face);
        if (has_begun && face.side == side && line.x0 == running.x1 && line.y0 == running.y1) {
            running.x1 = line.x1;
            running.y1 = line.y1;
            continue;
        }
        if (has_begun)
            add(running);
        running = line;
        side = face.side;
        has_begun = true;
    }
    if (has_begun)
        add(running);
    return out;
}

void set_facts(Feature& feature, const FacadeKey& key, const FacadeFacts& facade) {
    if (key.building > 0)
        feature.set_count("building", static_cast<std::uint64_t>(key.building));
    feature.set("facing", to_name(key.facing));
    feature.set_count("storey", static_cast<std::uint64_t>(key.storey));
    feature.set("bottom_m", facade.bottom_m);
    feature.set("top_m", facade.top_m);
    feature.set("area_m2", facade.area_m2);
    feature.set("kwh_m2", facade.kwh_m2());
    feature.set("kwh", facade.kwh);
    feature.set("beam_kwh_m2", facade.beam_kwh / facade.area_m2);
    feature.set("sun_hours", facade.hours_m2 / facade.area_m2);
    feature.set("sky_view", facade.sky_m2 / facade.area_m2);
    feature.set("azimuth_deg", facade.azimuth_deg());
    feature.set_count("faces", facade.faces.size());
}

}  // namespace

std::size_t write_facades(const FacadeSums& sums, const std::filesystem::path& out,
                          const ObjectFileInfo& info) {
    FeatureFile file(out, "facades", info.placement,
                     {"facades", wkbMultiLineString, info.description, kFacadeFields});
    std::vector<double> kwh_m2;
    for (const auto& [key, facade] : sums.facts()) {
        Feature feature = file.new_feature();
        set_facts(feature, key, facade);
        file.add(feature, make_lines(facade, info.placement.transform));
        kwh_m2.push_back(facade.kwh_m2());
    }
    file.finish({"facades", "kWh/m2", qgis_style(kwh_m2, StyledShape::kLine)});
    return sums.facts().size();
}

}  // namespace terravox::analyse
