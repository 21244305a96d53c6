// The part of the Python package that is C++: terravox/_core. What users call is in
// terravox/*.py, which turns its plain values into those of the field.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <terravox/terravox.hpp>

#include <array>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "raytracer/apps/python/array_worlds.hpp"
#include "raytracer/apps/python/calls.hpp"

namespace terravox::python {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;
/// west, south, east, north, bottom, top
using Bounds = std::array<double, 6>;

MapBounds map_bounds(const Bounds& b) {
    return {b[0], b[1], b[2], b[3], b[4], b[5]};
}
Bounds six_numbers(const MapBounds& b) {
    return {b.west, b.south, b.east, b.north, b.bottom, b.top};
}
std::optional<MapBounds> map_bounds(const std::optional<Bounds>& b) {
    return b ? std::optional(map_bounds(*b)) : std::nullopt;
}

nb::dict make_info(const World& world) {
    const WorldInfo& info = world.info();
    nb::dict out;
    out["title"] = info.title;
    out["bounds"] = nb::cast(six_numbers(info.bounds));
    out["block"] = nb::make_tuple(nb::cast(info.block.min), nb::cast(info.block.max));
    out["voxel_m"] = info.voxel_m;
    out["map_units"] = info.map_units;
    out["levels"] = info.levels;
    out["crs"] = info.crs;
    out["crs_wkt"] = info.crs_wkt;
    out["centre"] = nb::cast(info.centre);
    out["convergence_deg"] = info.convergence_deg;
    out["licence"] = info.licence;
    out["attribution"] = info.attribution;
    return out;
}

nb::dict to_dict(Raster raster) {
    nb::dict bands;
    nb::dict units;
    for (Raster::Band& band : raster.bands) {
        units[band.name.c_str()] = band.unit;
        bands[band.name.c_str()] =
            make_array<float>(std::move(band.values), {raster.rows, raster.columns});
    }
    nb::dict out;
    out["bounds"] = nb::cast(six_numbers(raster.bounds));
    out["cell"] = raster.cell;
    out["bands"] = bands;
    out["units"] = units;
    out["holes"] = raster.holes;
    return out;
}

nb::dict to_dict(Picture picture) {
    const std::size_t height = picture.height;
    const std::size_t width = picture.width;
    nb::dict layers;
    for (Picture::Layer& layer : picture.layers) {
        if (layer.channels == 1)
            layers[layer.name.c_str()] =
                make_array<float>(std::move(layer.values), {height, width});
        else
            layers[layer.name.c_str()] =
                make_array<float>(std::move(layer.values), {height, width, layer.channels});
    }
    nb::dict out;
    out["rgb"] = make_array<std::uint8_t>(std::move(picture.rgb), {height, width, 3});
    out["light"] = make_array<float>(std::move(picture.light), {height, width, 4});
    out["depth_m"] = make_array<float>(std::move(picture.depth_m), {height, width});
    out["layers"] = layers;
    out["holes"] = picture.holes;
    return out;
}

World open_world(std::vector<std::string> inputs, OpenOptions options) {
    return interruptible(
        nb::none(), [inputs = std::move(inputs), options = std::move(options)](
                        const Control& control) { return World::open(inputs, options, control); });
}

nb::object voxels(const World& world, const std::optional<Bounds>& bounds, int level, int threads,
                  const nb::object& progress) {
    VoxelGrid grid = interruptible(
        progress, [world, wanted = map_bounds(bounds), level, threads](const Control& control) {
            return world.voxels(world.block_of(wanted, level), threads, control);
        });
    const auto [layers, rows, columns] = grid.shape;
    return nb::make_tuple(
        make_array<std::uint8_t>(std::move(grid.materials), {layers, rows, columns}),
        nb::cast(six_numbers(grid.bounds)), grid.holes);
}

nb::dict surface(const World& world, const std::optional<Bounds>& area, int level, int threads,
                 const nb::object& progress) {
    return to_dict(interruptible(
        progress, [world, wanted = map_bounds(area), level, threads](const Control& control) {
            return world.surface(wanted, level, threads, control);
        }));
}

CastOptions cast_options(int level, double range_m, int threads) {
    CastOptions out;
    out.level = level;
    out.range_m = range_m;
    out.threads = threads;
    return out;
}

nb::object cast(const World& world, RayArray origins, RayArray directions, int level,
                double range_m, int threads, const nb::object& progress) {
    const std::size_t count = origins.shape(0);
    const auto rays = shared_with_threads(std::pair(std::move(origins), std::move(directions)));
    RayHits hits = interruptible(
        progress,
        [world, rays, options = cast_options(level, range_m, threads)](const Control& control) {
            return world.cast(list_numbers(rays->first), list_numbers(rays->second), options,
                              control);
        });
    return nb::make_tuple(make_array<double>(std::move(hits.distance_m), {count}),
                          make_array<std::int32_t>(std::move(hits.voxel), {count, 3}),
                          make_array<std::int8_t>(std::move(hits.face), {count}),
                          make_array<std::uint8_t>(std::move(hits.material), {count}), hits.holes);
}

nb::object occluded(const World& world, RayArray origins, RayArray directions, int level,
                    double range_m, int threads, const nb::object& progress) {
    const std::size_t count = origins.shape(0);
    const auto rays = shared_with_threads(std::pair(std::move(origins), std::move(directions)));
    Occlusion found = interruptible(
        progress,
        [world, rays, options = cast_options(level, range_m, threads)](const Control& control) {
            return world.occluded(list_numbers(rays->first), list_numbers(rays->second), options,
                                  control);
        });
    return nb::make_tuple(make_array<bool>(std::move(found.occluded), {count}), found.holes);
}

nb::dict render(const World& world, std::string toml, Fields fields, int threads,
                const nb::object& progress) {
    return to_dict(interruptible(
        progress, [world, scene = SceneText{std::move(toml), std::move(fields)}, threads](
                      const Control& control) { return world.render(scene, threads, control); }));
}

nb::dict analyse(const World& world, AnalysisOptions options, const nb::object& progress) {
    return to_dict(
        interruptible(progress, [world, options = std::move(options)](const Control& control) {
            return world.analyse(options, control);
        }));
}

nb::object convert(const World& world, std::string out, ConvertOptions options,
                   const nb::object& progress) {
    const ConvertReport report = interruptible(
        progress, [world, out = std::move(out), options = std::move(options)](
                      const Control& control) { return world.convert(out, options, control); });
    return nb::make_tuple(nb::cast(report.files), report.voxels, report.holes);
}

std::vector<std::string> survey(SurveyRequest request, const nb::object& progress) {
    return interruptible(progress, [request = std::move(request)](const Control& control) {
        return make_survey(request, control);
    });
}

std::vector<std::tuple<int, std::string, std::array<int, 3>>> material_list() {
    std::vector<std::tuple<int, std::string, std::array<int, 3>>> out;
    for (const Material& material : materials())
        out.emplace_back(material.number, material.name,
                         std::array<int, 3>{material.rgb[0], material.rgb[1], material.rgb[2]});
    return out;
}

void finish() {
    const nb::gil_scoped_release without_lock;
    Calls::all().finish();
}

}  // namespace
}  // namespace terravox::python

NB_MODULE(_core, module) {
    using namespace terravox;
    using namespace terravox::python;
    namespace nb = nanobind;
    using namespace nb::literals;

    module.attr("__version__") = version();
    add_errors(module);
    module.def("set_log_level", &set_log_level, "level"_a);
    module.def("materials", &material_list);
    module.def("finish", &finish);
    module.def(
        "survey",
        [](std::string folder, std::uint64_t seed, double density,
           const std::array<int, 2>& squares, int square_m, int threads,
           const nb::object& progress) {
            return survey(
                {std::move(folder), seed, density, squares[0], squares[1], square_m, threads},
                progress);
        },
        "folder"_a, "seed"_a, "density"_a, "squares"_a, "square_m"_a, "threads"_a,
        "progress"_a.none());

    nb::class_<World>(module, "World")
        .def_static(
            "open",
            [](std::vector<std::string> inputs, std::string crs, std::string classes,
               std::optional<double> voxel_m, std::vector<std::string> orthophotos,
               std::vector<std::string> additions, std::string cache, Fields fields) {
                return open_world(std::move(inputs), {std::move(crs), std::move(classes), voxel_m,
                                                      std::move(orthophotos), std::move(additions),
                                                      std::move(cache), std::move(fields)});
            },
            "inputs"_a, "crs"_a, "classes"_a, "voxel_m"_a.none(), "orthophotos"_a, "additions"_a,
            "cache"_a, "fields"_a)
        .def("info", &make_info)
        .def("damage", &World::damage)
        .def("voxels", &voxels, "bounds"_a.none(), "level"_a, "threads"_a, "progress"_a.none())
        .def("surface", &surface, "area"_a.none(), "level"_a, "threads"_a, "progress"_a.none())
        .def("cast", &cast, "origins"_a, "directions"_a, "level"_a, "range_m"_a, "threads"_a,
             "progress"_a.none())
        .def("occluded", &occluded, "origins"_a, "directions"_a, "level"_a, "range_m"_a,
             "threads"_a, "progress"_a.none())
        .def("render", &render, "toml"_a, "fields"_a, "threads"_a, "progress"_a.none())
        .def(
            "analyse",
            [](const World& world, std::string kind, const std::optional<Bounds>& area,
               std::optional<double> resolution_m, std::optional<int> level,
               std::vector<std::array<double, 3>> observers, std::string weather,
               std::string horizon, std::string toml, Fields fields, int threads,
               const nb::object& progress) {
                return analyse(world,
                               {std::move(kind),
                                map_bounds(area),
                                resolution_m,
                                level,
                                std::move(observers),
                                std::move(weather),
                                std::move(horizon),
                                {std::move(toml), std::move(fields)},
                                threads},
                               progress);
            },
            "kind"_a, "area"_a.none(), "resolution_m"_a.none(), "level"_a.none(), "observers"_a,
            "weather"_a, "horizon"_a, "toml"_a, "fields"_a, "threads"_a, "progress"_a.none())
        .def(
            "convert",
            [](const World& world, std::string out, std::string format, int level,
               const std::optional<Bounds>& area, bool overwrite, int threads,
               const nb::object& progress) {
                return convert(world, std::move(out),
                               {std::move(format), level, map_bounds(area), overwrite, threads},
                               progress);
            },
            "out"_a, "format"_a, "level"_a, "area"_a.none(), "overwrite"_a, "threads"_a,
            "progress"_a.none());
    add_array_worlds(module);
}
