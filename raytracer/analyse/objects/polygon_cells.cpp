#include "raytracer/analyse/objects/polygon_cells.hpp"

#include <ogr_geometry.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "common/geo/geojson.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/objects/connected_cells.hpp"
#include "raytracer/analyse/objects/energy_rows.hpp"
#include "raytracer/output/gdal_writing.hpp"

namespace terravox::analyse {
namespace {

using overlay::Footprint;
using Positions = std::vector<geo::Shape::Position>;

/// Reads one file.
class PolygonFile {
public:
    PolygonFile(const std::filesystem::path& file, const output::GeoPlacement& to)
        : m_attempt("read the polygons of " + file.string()),
          m_transform(to.transform),
          m_shapes(geo::read_geojson(file, geo::Crs::from_wkt(to.crs_wkt))) {}

    [[nodiscard]] std::vector<ObjectPolygon> polygons() const {
        std::vector<ObjectPolygon> out;
        for (std::size_t i = 0; i < m_shapes.size();) {
            const std::size_t first = i;
            // Parts of a feature follow each other.
            while (i < m_shapes.size() && m_shapes[i].feature == m_shapes[first].feature)
                ++i;
            out.push_back(polygon_of(first, i));
        }
        if (out.empty())
            throw util::Error(m_attempt + ": it holds none");
        return out;
    }

private:
    [[noreturn]] void fail(std::size_t feature, const std::string& what) const {
        throw util::Error(m_attempt + ": feature " + std::to_string(feature) + " " + what);
    }

    [[nodiscard]] ObjectPolygon polygon_of(std::size_t begin, std::size_t end) const {
        const std::size_t feature = m_shapes[begin].feature;
        const auto outline = std::make_shared<OGRMultiPolygon>();
        std::vector<Footprint> parts;
        for (std::size_t i = begin; i < end; ++i) {
            if (m_shapes[i].kind != geo::ShapeKind::kPolygon)
                fail(feature, "is no polygon; allowed: Polygon, MultiPolygon");
            auto part = std::make_unique<OGRPolygon>();
            std::vector<Footprint::Ring> rings;
            for (const Positions& ring : m_shapes[i].parts) {
                check_ring(feature, ring);
                part->addRingDirectly(line_of(ring).release());
                rings.push_back(in_cells(ring));
            }
            outline->addGeometryDirectly(part.release());
            parts.push_back(footprint_of(feature, std::move(rings)));
        }
        const output::GdalWatch watch(m_attempt);
        const bool is_valid = outline->IsValid();
        watch.check(true);
        if (!is_valid)
            fail(feature, "is not valid: borders cross themselves or each other");
        return {feature, outline, std::move(parts)};
    }

    [[nodiscard]] Footprint footprint_of(std::size_t feature,
                                         std::vector<Footprint::Ring> rings) const {
        try {
            return Footprint(std::move(rings));
        } catch (const std::invalid_argument& e) {
            fail(feature, std::string("is not valid: ") + e.what());
        }
    }

    void check_ring(std::size_t feature, const Positions& ring) const {
        constexpr std::size_t kLeast = 4;
        const bool is_closed =
            ring.front()[0] == ring.back()[0] && ring.front()[1] == ring.back()[1];
        if (ring.size() < kLeast || !is_closed)
            fail(feature,
                 "has a border that is not closed; allowed: four positions and more, the "
                 "last one like the first");
    }

    static std::unique_ptr<OGRLinearRing> line_of(const Positions& ring) {
        auto out = std::make_unique<OGRLinearRing>();
        for (const geo::Shape::Position& p : ring)
            out->addPoint(p[0], p[1]);
        return out;
    }

    [[nodiscard]] Footprint::Ring in_cells(const Positions& ring) const {
        Footprint::Ring out;
        for (const geo::Shape::Position& p : ring)
            out.push_back({(p[0] - m_transform[0]) / m_transform[1],
                           (p[1] - m_transform[3]) / m_transform[5]});
        return out;
    }

    const std::string m_attempt;
    const std::array<double, 6> m_transform;
    const std::vector<geo::Shape> m_shapes;
};

/// The cells that a footprint's corners span, within some distance of any raster.
CellRectangle span_of(const Footprint& cells) {
    constexpr double kFarthest = 1e6;
    const auto cell = [&](double at) {
        return static_cast<int>(std::floor(std::clamp(at, -kFarthest, kFarthest)));
    };
    const int x0 = cell(cells.min()[0]);
    const int y0 = cell(cells.min()[1]);
    return {x0, y0, cell(cells.max()[0]) - x0 + 1, cell(cells.max()[1]) - y0 + 1};
}

void add_cells(CellFile& cells, const Footprint& footprint, double cell_m2,
               const std::stop_token& stop, ObjectSums& out) {
    const CellRectangle area = span_of(footprint);
    EnergyRows rows(cells, area);
    while (rows.next()) {
        check_stop(stop);
        const std::vector<double> crossings = footprint.crossings(rows.row() + 0.5);
        for (int x = 0; x < area.width; ++x)
            if (Footprint::is_inside(crossings, area.x0 + x + 0.5))
                out.add(rows.at(x), cell_m2);
    }
}

}  // namespace

std::vector<ObjectPolygon> read_polygons(const std::filesystem::path& file,
                                         const output::GeoPlacement& to, int columns, int rows) {
    std::vector<ObjectPolygon> out = PolygonFile(file, to).polygons();
    const auto is_met = [&](const ObjectPolygon& polygon) {
        return std::any_of(polygon.parts.begin(), polygon.parts.end(), [&](const Footprint& part) {
            return part.max()[0] > 0 && part.min()[0] < columns && part.max()[1] > 0 &&
                   part.min()[1] < rows;
        });
    };
    if (std::none_of(out.begin(), out.end(), is_met))
        throw util::Error("read the polygons of " + file.string() +
                          ": none of them meets the raster");
    return out;
}

std::vector<ObjectFacts> facts_of(CellFile& cells, const std::vector<ObjectPolygon>& polygons,
                                  double cell_m2, const std::stop_token& stop) {
    std::vector<ObjectFacts> out;
    out.reserve(polygons.size());
    for (const ObjectPolygon& polygon : polygons) {
        ObjectSums sums;
        for (const Footprint& part : polygon.parts)
            add_cells(cells, part, cell_m2, stop, sums);
        out.push_back(facts_of(sums, cell_m2));
    }
    return out;
}

}  // namespace terravox::analyse
