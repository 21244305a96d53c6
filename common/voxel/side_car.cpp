#include "common/voxel/side_car.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/json_text.hpp"
#include "common/voxel/facts_json.hpp"

namespace terravox::voxel {
namespace {

using nlohmann::json;
constexpr int kSideCarVersion = 1;

}  // namespace

SideCar make_side_car(const WorldInfo& world, int level,
                      const std::array<std::int32_t, 3>& offset) {
    const double scale = static_cast<double>(std::int64_t{1} << level);
    SideCar car;
    car.world = world;
    car.world.voxel_m *= scale;
    car.world.crs_units_per_voxel *= scale;
    car.offset = offset;
    return car;
}

void write_side_car(const std::filesystem::path& file, const SideCar& car) {
    json blocks = json::object();
    for (const auto& [name, material] : car.blocks)
        blocks[name] = std::string(material_name(material));
    json out = facts_to_json(car.world, kSideCarVersion);
    out["offset"] = car.offset;
    out["axes"] =
        "x east, y up, z south; easting = (x + offset[0]) * crs_units_per_voxel, northing "
        "= -(z + offset[2]) * crs_units_per_voxel, height_m = (y + offset[1]) * voxel_m";
    out["blocks"] = blocks;
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
        read_facts(in, car.world);
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
    } catch (const json::exception& e) {
        fail(e.what());
    }
    if (!(car.world.voxel_m > 0 && car.world.voxel_m <= 1e6))
        fail("voxel_m = " + std::to_string(car.world.voxel_m) +
             "; allowed: above 0, up to 1000000");
    if (!(car.world.crs_units_per_voxel > 0 && std::isfinite(car.world.crs_units_per_voxel)))
        fail("crs_units_per_voxel is not a positive number");
    return car;
}

}  // namespace terravox::voxel
