#include "raytracer/analyse/objects/polygon_cells.hpp"

#include <ogr_geometry.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/geo/geojson.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/objects/cell_labels.hpp"
#include "raytracer/core/output/gdal_writing.hpp"

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
            out.push_back(make_polygon(first, i));
        }
        if (out.empty())
            throw util::Error(m_attempt + ": it holds none");
        return out;
    }

private:
    [[noreturn]] void fail(std::size_t feature, const std::string& what) const {
        throw util::Error(m_attempt + ": feature " + std::to_string(feature) + " " + what);
    }

    [[nodiscard]] ObjectPolygon make_polygon(std::size_t begin, std::size_t end) const {
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
                part->addRingDirectly(make_line(ring).release());
                rings.push_back(in_cells(feature, ring));
            }
            outline->addGeometryDirectly(part.release());
            parts.push_back(make_footprint(feature, std::move(rings)));
        }
        const output::GdalWatch watch(m_attempt);
        const bool is_valid = outline->IsValid();
        watch.check(true);
        if (!is_valid)
            fail(feature, "is not valid: borders cross themselves or each other");
        return {feature, outline, std::move(parts)};
    }

    [[nodiscard]] Footprint make_footprint(std::size_t feature,
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

    static std::unique_ptr<OGRLinearRing> make_line(const Positions& ring) {
        auto out = std::make_unique<OGRLinearRing>();
        for (const geo::Shape::Position& p : ring)
            out->addPoint(p[0], p[1]);
        return out;
    }

    [[nodiscard]] Footprint::Ring in_cells(std::size_t feature, const Positions& ring) const {
        // More than the Earth has, of the smallest voxels. Areas of such polygons are whole
        // numbers.
        constexpr double kFarthest = 1e9;
        Footprint::Ring out;
        for (const geo::Shape::Position& p : ring) {
            out.push_back({(p[0] - m_transform[0]) / m_transform[1],
                           (p[1] - m_transform[3]) / m_transform[5]});
            for (const double at : out.back())
                if (!(std::abs(at) <= kFarthest))
                    fail(feature, "has a corner farther than 10^9 cells from the raster");
        }
        return out;
    }

    const std::string m_attempt;
    const std::array<double, 6> m_transform;
    const std::vector<geo::Shape> m_shapes;
};

/// Mean of a number that goes evenly from `a` to `b` and is cut to [low, high], above `low`.
double mean_above(double a, double b, double low, double high) {
    const double least = std::min(a, b);
    const double most = std::max(a, b);
    const double from = std::clamp(least, low, high);
    const double to = std::clamp(most, low, high);
    if (least == most)
        return from - low;
    const double beyond = std::max(most, high) - std::max(least, high);
    return ((to - from) * ((from + to) / 2 - low) + beyond * (high - low)) / (most - least);
}

/// The area of a ring within [low, high), in cells: by Green's theorem the integral of x along its
/// sides, which are cut to the rectangle.
double area_within(const Footprint::Ring& ring, const Footprint::Point& low,
                   const Footprint::Point& high) {
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Footprint::Point& a = ring[i];
        const Footprint::Point& b = ring[(i + 1) % ring.size()];
        const double begin = std::clamp(a[1], low[1], high[1]);
        const double end = std::clamp(b[1], low[1], high[1]);
        if (begin == end)
            continue;
        const auto x_at = [&](double y) {
            return a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]));
        };
        sum += (end - begin) * mean_above(x_at(begin), x_at(end), low[0], high[0]);
    }
    return std::abs(sum);
}

/// The area of a footprint, without its holes.
double area_within(const Footprint& footprint, const Footprint::Point& low,
                   const Footprint::Point& high) {
    const std::vector<Footprint::Ring>& rings = footprint.rings();
    double out = area_within(rings.front(), low, high);
    for (std::size_t hole = 1; hole < rings.size(); ++hole)
        out -= area_within(rings[hole], low, high);
    return out;
}

/// Beyond a raster there may be any number of cells, so they are not counted one by one.
std::uint64_t cells_beyond(const CellFile& cells, const Footprint& footprint) {
    const double inside =
        area_within(footprint, {0, 0},
                    {static_cast<double>(cells.columns()), static_cast<double>(cells.rows())});
    const double all = area_within(footprint, footprint.min(), footprint.max());
    return static_cast<std::uint64_t>(std::max(std::round(all - inside), 0.0));
}

void add_cells(CellFile& cells, const Footprint& footprint, double cell_m2,
               const std::stop_token& stop, ObjectSums& out) {
    const std::uint64_t beyond = cells_beyond(cells, footprint);
    out.cells += beyond;
    out.cells_without_value += beyond;
    const CellRectangle area = cells_around(footprint, cells.columns(), cells.rows());
    if (area.width <= 0)
        return;
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

CellRectangle cells_around(const Footprint& part, int columns, int rows) {
    const auto within = [](double side, int end) {
        return static_cast<int>(std::clamp(side, 0.0, static_cast<double>(end)));
    };
    const int west = within(std::floor(part.min()[0]), columns);
    const int north = within(std::floor(part.min()[1]), rows);
    return {west, north, within(std::ceil(part.max()[0]), columns) - west,
            within(std::ceil(part.max()[1]), rows) - north};
}

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

std::vector<ObjectFacts> collect_facts(CellFile& cells, const std::vector<ObjectPolygon>& polygons,
                                       double cell_m2, const std::stop_token& stop) {
    std::vector<ObjectFacts> out;
    out.reserve(polygons.size());
    for (const ObjectPolygon& polygon : polygons) {
        ObjectSums sums;
        for (const Footprint& part : polygon.parts)
            add_cells(cells, part, cell_m2, stop, sums);
        out.push_back(collect_facts(sums, cell_m2));
    }
    return out;
}

}  // namespace terravox::analyse
