#include "common/voxel/side_car.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/json_text.hpp"
#include "common/util/version.hpp"
#include "common/voxel/place_json.hpp"

namespace terravox::voxel {
namespace {

using nlohmann::json;
constexpr int kSideCarVersion = 1;

}  // namespace

SideCar make_side_car(const WorldInfo& world, int level,
                      const std::array<std::int32_t, 3>& offset) {
    const double scale = static_cast<double>(std::int64_t{1} << level);
    SideCar car;
    car.title = world.title;
    car.crs = world.crs;
    car.crs_wkt = world.crs_wkt;
    car.licence = world.licence;
    car.attribution = world.attribution;
    car.voxel_m = world.voxel_m * scale;
    car.crs_units_per_voxel = world.crs_units_per_voxel * scale;
    car.offset = offset;
    car.centre = world.centre;
    return car;
}

void write_side_car(const std::filesystem::path& file, const SideCar& car) {
    json blocks = json::object();
    for (const auto& [name, material] : car.blocks)
        blocks[name] = std::string(material_name(material));
    json out = {{"version", kSideCarVersion},
                {"software", std::string("terravox ") + kVersion},
                {"title", car.title},
                {"crs", car.crs},
                {"crs_wkt", car.crs_wkt},
                {"voxel_m", car.voxel_m},
                {"crs_units_per_voxel", car.crs_units_per_voxel},
                {"offset", car.offset},
                {"axes",
                 "x east, y up, z south; easting = (x + offset[0]) * crs_units_per_voxel, northing "
                 "= -(z + offset[2]) * crs_units_per_voxel, height_m = (y + offset[1]) * voxel_m"},
                {"blocks", blocks},
                {"licence", car.licence},
                {"attribution", car.attribution}};
    if (car.centre)
        out["centre"] = place_to_json(*car.centre);
    util::write_file_atomically(file,
                                out.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

SideCar side_car_from_json(const std::string& text, const std::string& origin) {
    const auto fail = [&](const std::string& what) {
        throw util::Error("read the side-car {}: {}", origin, what);
    };
    SideCar car;
    try {
        const json in = util::parse_json(text);
        if (in.is_discarded())
            fail("it is no JSON");
        if (const int version = in.at("version").get<int>(); version != kSideCarVersion)
            fail("version " + std::to_string(version) +
                 "; allowed: " + std::to_string(kSideCarVersion));
        car.title = in.at("title").get<std::string>();
        car.crs = in.at("crs").get<std::string>();
        car.crs_wkt = in.at("crs_wkt").get<std::string>();
        car.licence = in.at("licence").get<std::string>();
        car.attribution = in.at("attribution").get<std::string>();
        car.voxel_m = in.at("voxel_m").get<double>();
        car.crs_units_per_voxel = in.at("crs_units_per_voxel").get<double>();
        const auto offset = in.at("offset").get<std::array<std::int64_t, 3>>();
        constexpr std::int64_t kFarthest = 1 << 30;
        for (std::size_t a = 0; a < 3; ++a) {
            if (offset[a] < -kFarthest || offset[a] > kFarthest)
                fail("offset " + std::to_string(offset[a]) + "; allowed: up to 2^30 voxels");
            car.offset[a] = static_cast<std::int32_t>(offset[a]);
        }
        for (const auto& [name, material] : in.at("blocks").items()) {
            const auto known = material_from_name(material.get<std::string>());
            if (!known)
                fail("block " + name + " stands for '" + material.get<std::string>() +
                     "', which is no material");
            car.blocks.emplace(name, *known);
        }
        if (in.contains("centre"))
            car.centre = place_from_json(in["centre"]);
    } catch (const json::exception& e) {
        fail(e.what());
    }
    if (!(car.voxel_m > 0 && car.voxel_m <= 1e6))
        fail("voxel_m = " + std::to_string(car.voxel_m) + "; allowed: above 0, up to 1000000");
    if (!(car.crs_units_per_voxel > 0 && std::isfinite(car.crs_units_per_voxel)))
        fail("crs_units_per_voxel is not a positive number");
    return car;
}

}  // namespace terravox::voxel
