// GeoJSON files: shapes, planned objects of a world, outlines to measure.
#include "common/geo/geojson.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <string_view>

#include "common/geo/crs.hpp"
#include "raytracer/analyse/objects/polygon_cells.hpp"
#include "tests/common/voxel/array_world.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/make/worlds/overlay/overlay_world.hpp"

namespace terravox::fuzz {
namespace {

constexpr std::size_t kLongestMessage = 2000;

const geo::Crs& map_crs() {
    static const geo::Crs crs = geo::Crs::from_text("EPSG:3794");
    return crs;
}

const std::string& map_wkt() {
    static const std::string wkt = map_crs().wkt();
    return wkt;
}

void check(const geo::Shape& shape) {
    using geo::ShapeKind;
    expect(!shape.parts.empty(), "a shape has parts");
    expect(shape.kind == ShapeKind::kPolygon || shape.parts.size() == 1,
           "only a polygon has several parts");
    for (const auto& part : shape.parts) {
        expect(!part.empty(), "a part has positions");
        expect(shape.kind != ShapeKind::kPoint || part.size() == 1, "a point is one position");
        for (const geo::Shape::Position& at : part) {
            expect(std::isfinite(at[0]) && std::isfinite(at[1]), "a position is finite");
            expect(!std::isinf(at[2]), "a third coordinate is finite, or there is none");
        }
    }
    expect(shape.lengths != nullptr, "a shape has the lengths of its feature");
    for (const auto& [name, number] : shape.lengths->metres)
        expect(std::isfinite(number), "a property that is a number is finite");
}

std::vector<geo::Shape> read_shapes(const std::filesystem::path& file) {
    std::vector<geo::Shape> shapes = geo::read_geojson(file, map_crs());
    std::size_t positions = 0;
    std::size_t feature = 0;
    for (const geo::Shape& shape : shapes) {
        check(shape);
        for (const auto& part : shape.parts)
            positions += part.size();
        expect(shape.feature >= feature, "parts of a feature follow each other");
        feature = shape.feature;
    }
    expect(positions <= geo::kMaxGeoJsonPositions, "positions are limited");
    return shapes;
}

/// Ground from the origin of the CRS to the north-east.
std::unique_ptr<voxel::World> land() {
    using Coord = test::ArrayWorld::Coord;
    const Coord low = {0, -2, -64};
    const Coord high = {64, 2, 0};
    auto out = std::make_unique<test::ArrayWorld>(low, high);
    out->fill(low, {64, 0, 0}, voxel::Material::kGrass);
    out->editable_info().crs = "EPSG:3794";
    out->editable_info().crs_wkt = map_wkt();
    return out;
}

void add_to_world(const std::filesystem::path& file) {
    const std::array<std::string, 1> additions{file.string()};
    const auto world = overlay::with_additions(land(), additions);
    const voxel::VoxelBounds& bounds = world->info().bounds;
    expect(bounds.min[0] == 0 && bounds.max[0] == 64 && bounds.min[2] == -64 && bounds.max[2] == 0,
           "an added object is within the data");
    expect(bounds.max[1] <= 20'000, "an added object is not too high");
    expect(!world->edition().empty(), "a world with objects has an edition");
    (void)world->box({0, 0, 0, -1});
}

void read_polygons(const std::filesystem::path& file) {
    constexpr int kCells = 32;
    const output::GeoPlacement raster{{0, 2, 0, 64, 0, -2}, map_wkt()};
    for (const auto& polygon : analyse::read_polygons(file, raster, kCells, kCells)) {
        expect(polygon.outline != nullptr && !polygon.parts.empty(), "a polygon has an outline");
        for (const overlay::Footprint& part : polygon.parts) {
            const auto middle = part.middle();
            expect(part.min()[0] <= middle[0] && middle[0] <= part.max()[0] &&
                       part.min()[1] <= middle[1] && middle[1] <= part.max()[1],
                   "the middle of a polygon is within its bounds");
        }
    }
}

}  // namespace

void run(Input input) {
    const auto file = as_file(input, "input.geojson");
    try {
        if (read_shapes(file).empty())
            return;
    } catch (const util::Error& e) {
        expect(std::string_view(e.what()).size() < kLongestMessage, "a message is short");
        return;
    }
    allow_errors([&] { add_to_world(file); });
    allow_errors([&] { read_polygons(file); });
}

}  // namespace terravox::fuzz
