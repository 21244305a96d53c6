#include "voxelserver/voxelize/settings.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "common/util/config_dir.hpp"
#include "common/util/error.hpp"
#include "common/util/toml_file.hpp"
#include "voxelserver/store/bytes.hpp"

namespace terravox::voxelize {
namespace {

/// Where one field lies in a file, and what may stand there.
struct Field {
    const char *section, *name;
    bool* flag = nullptr;
    double* number = nullptr;
    double low = 0, high = 0;
    std::string* text = nullptr;
};

std::vector<Field> fields_of(Settings& s) {
    const auto flag = [](const char* section, const char* name, bool& f) {
        return Field{section, name, &f, nullptr, 0, 0, nullptr};
    };
    const auto number = [](const char* section, const char* name, double& v, double low,
                           double high) {
        return Field{section, name, nullptr, &v, low, high, nullptr};
    };
    return {
        flag("points", "drop_withheld", s.points.drop_withheld),
        flag("points", "drop_overlap", s.points.drop_overlap),
        flag("points", "drop_isolated", s.points.drop_isolated),
        flag("steps", "building_fill", s.steps.building_fill),
        flag("steps", "bridges", s.steps.bridges),
        flag("steps", "ground_fill", s.steps.ground_fill),
        flag("steps", "vegetation_fill", s.steps.vegetation_fill),
        flag("steps", "specialization", s.steps.specialization),
        flag("steps", "neighbourhood_filters", s.steps.neighbourhood_filters),
        flag("steps", "water_equalization", s.steps.water_equalization),
        flag("steps", "water_deepening", s.steps.water_deepening),
        number("buildings", "storey_m", s.buildings.storey_m, 1, 20),
        number("buildings", "steep_roof_m", s.buildings.steep_roof_m, 0, 50),
        number("bridges", "thickness_m", s.bridges.thickness_m, 0.1, 20),
        flag("bridges", "recognise", s.bridges.recognise),
        number("bridges", "widest_m", s.bridges.widest_m, 1, 15),
        number("bridges", "least_drop_m", s.bridges.least_drop_m, 0.5, 20),
        number("bridges", "above_water_m", s.bridges.above_water_m, 0.5, 50),
        number("bridges", "above_land_m", s.bridges.above_land_m, 0.5, 50),
        number("ground", "soil_m", s.ground.soil_m, 0, 100),
        number("ground", "cliff_m", s.ground.cliff_m, 0, 1000),
        number("ground", "depth_m", s.ground.depth_m, 0, 10'000),
        number("vegetation", "low_m", s.vegetation.low_m, 0, 50),
        number("vegetation", "medium_m", s.vegetation.medium_m, 0, 50),
        number("vegetation", "canopy_gap_m", s.vegetation.canopy_gap_m, 0, 50),
        number("vegetation", "trunk_from_m", s.vegetation.trunk_from_m, 0, 100),
        number("vegetation", "clutter_m", s.vegetation.clutter_m, 0, 10),
        flag("water", "from_class", s.water.from_class),
        flag("water", "from_orthophoto", s.water.from_orthophoto),
        flag("water", "from_voids", s.water.from_voids),
        number("water", "slope", s.water.slope, 0, 10),
        number("water", "min_depth_m", s.water.min_depth_m, 0, 100),
        number("water", "max_depth_m", s.water.max_depth_m, 0, 100),
        Field{"specialization", "palette", nullptr, nullptr, 0, 0, &s.palette},
    };
}

}  // namespace

voxel::Fingerprint print_of(const Settings& settings) {
    Settings copy = settings;  // fields are found to be set
    store::ByteWriter out;
    for (const Field& f : fields_of(copy)) {
        if (f.text != nullptr)
            continue;
        out.add(std::string(f.section)), out.add(std::string(f.name));
        if (f.flag != nullptr)
            out.add(*f.flag);
        else
            out.add(*f.number);
    }
    return out.print();
}

Settings load_settings(const std::filesystem::path& given) {
    const std::filesystem::path file = given.empty() ? util::config_dir() / "voxelize.toml" : given;
    const auto fail = [&](const std::string& what) {
        throw UsageError("read the voxelization settings " + file.string() + ": " + what);
    };
    const toml::table root = util::read_toml(file, fail);
    Settings out;
    const auto fields = fields_of(out);
    std::vector<std::string> sections;
    for (const Field& f : fields)
        if (sections.empty() || sections.back() != f.section)
            sections.emplace_back(f.section);
    for (const auto& [section, node] : root) {
        const auto* table = node.as_table();
        if (table == nullptr ||
            std::find(sections.begin(), sections.end(), section.str()) == sections.end())
            fail(std::string(section.str()) +
                 fmt::format(" is no section; allowed: {}", fmt::join(sections, ", ")));
        for (const auto& [name, value] : *table) {
            const std::string path = std::string(section.str()) + "." + std::string(name.str());
            const Field* field = nullptr;
            std::string allowed;
            for (const Field& f : fields) {
                if (f.section != section.str())
                    continue;
                allowed += (allowed.empty() ? "" : ", ") + std::string(f.name);
                if (f.name == name.str())
                    field = &f;
            }
            if (field == nullptr)
                fail(path + " is unknown; allowed in [" + std::string(section.str()) +
                     "]: " + allowed);
            if (field->flag != nullptr) {
                if (!value.is_boolean())
                    fail(path + " is not true or false");
                *field->flag = value.value_or(false);
            } else if (field->number != nullptr) {
                const auto v = value.value<double>();
                if (!v || !(*v >= field->low && *v <= field->high))
                    fail(path + (v ? fmt::format(" = {}", *v) : " is no number") +
                         fmt::format("; allowed: {} to {}", field->low, field->high));
                *field->number = *v;
            } else {
                if (!value.is_string())
                    fail(path + " is no text");
                *field->text = value.value_or(std::string());
            }
        }
    }
    if (out.water.min_depth_m > out.water.max_depth_m)
        fail(fmt::format("water.min_depth_m = {} is above water.max_depth_m = {}",
                         out.water.min_depth_m, out.water.max_depth_m));
    return out;
}

}  // namespace terravox::voxelize
