#include "raytracer/analyse/objects/facade_file.hpp"

#include <ogr_geometry.h>

#include <algorithm>
#include <memory>
#include <tuple>

#include "raytracer/analyse/objects/qgis_style.hpp"

namespace terravox::analyse {
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

Line line_of(const FacadeFace& face) noexcept {
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
OGRMultiLineString lines_of(const FacadeFacts& facade, const std::array<double, 6>& t) {
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
        const Line line = line_of(face);
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
    feature.set("facing", name_of(key.facing));
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
        file.add(feature, lines_of(facade, info.placement.transform));
        kwh_m2.push_back(facade.kwh_m2());
    }
    file.finish({"facades", "kWh/m2", qgis_style(kwh_m2, StyledShape::kLine)});
    return sums.facts().size();
}

}  // namespace terravox::analyse
