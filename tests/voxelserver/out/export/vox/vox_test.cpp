#include "voxelserver/out/export/vox/vox.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/out/export/shape/painted_world.hpp"
#include "tests/voxelserver/out/export/vox/read_vox.hpp"
#include "voxelserver/out/export/shape/placing.hpp"
#include "voxelserver/out/export/vox/vox_palette.hpp"

using namespace terravox;
using namespace terravox::exports;
using voxel::Material;

namespace {

int difference(voxel::Rgb8 a, voxel::Rgb8 b) {
    return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

struct Compared {
    std::size_t wanted = 0;
    std::size_t missing = 0;
    std::size_t wrong_colour = 0;
    std::size_t wrong_material = 0;
    int farthest = 0;
};

// Every voxel of the world against the file. `near`: how far a channel may be off.
Compared compare(const test::PaintedWorld& world, const Job& job, const test::ReadVox& file,
                 int near) {
    Compared out;
    const auto& b = job.part.bounds;
    const auto o = make_origin(job.part);
    for (int y = b.min[1]; y < b.max[1]; ++y)
        for (int z = b.min[2]; z < b.max[2]; ++z)
            for (int x = b.min[0]; x < b.max[0]; ++x) {
                if (world.at(x, y, z) == Material::kAir || world.hidden(x, y, z))
                    continue;
                ++out.wanted;
                const auto found = file.voxels.find({x - o[0], o[2] - 1 - z, y - o[1]});
                if (found == file.voxels.end()) {
                    ++out.missing;
                    continue;
                }
                const auto attr = world.attr_at(x, y, z);
                const int off = difference(file.colours[static_cast<std::size_t>(found->second)],
                                           job.to_colour(attr));
                out.farthest = std::max(out.farthest, off);
                out.wrong_colour += off > near || (off > 0 && !attr.has_colour());
                const auto material = file.materials.find(found->second);
                const std::string type =
                    material == file.materials.end() ? "" : material->second.at("_type");
                const bool glass =
                    attr.material == Material::kWater || attr.material == Material::kGlass;
                const std::string wanted = glass                              ? "_glass"
                                           : attr.material == Material::kLamp ? "_emit"
                                                                              : "";
                out.wrong_material += type != wanted;
            }
    return out;
}

}  // namespace

TEST_CASE("a vox file holds every voxel that can be seen, at its place", "[convert][vox]") {
    struct Case {
        const char* name;
        std::uint32_t colours;
        int near;
        voxel::VoxelBounds bounds;
    };
    const voxel::VoxelBounds all{{-70, -12, -9}, {75, 300, 80}};
    const auto c = GENERATE_COPY(values<Case>({
        {"few enough colours to keep them all", 8, 0, all},
        {"too many colours", 5000, 255, all},
        {"a part, colours of materials", 0, 0, {{-33, -7, 2}, {66, 259, 71}}},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto world = test::lumps(21, c.colours);
        test::ExportJob e(*world, c.bounds, "a.vox");
        write_vox(e.job);
        const auto file = test::VoxReader::read(test::read_content(e.job.out));
        const Compared found = compare(*world, e.job, file, c.near);
        CHECK(found.wanted > 1000);
        CHECK(file.voxels.size() == found.wanted);
        CHECK(e.job.voxels() == found.wanted);
        CHECK(found.missing == 0);
        CHECK(file.doubles == 0);
        INFO("farthest channel: " << found.farthest);
        CHECK(found.wrong_colour == 0);
        CHECK(found.wrong_material == 0);
        CHECK(file.sizes.size() > 1);
        for (const auto& size : file.sizes)
            for (const int s : size)
                CHECK((s >= 1 && s <= 256));
        CHECK(test::files_in(e.folder.path()) ==
              std::set<std::string>{"a.vox", "a.vox.georef.json"});
    }
}

TEST_CASE("a wide part has models side by side", "[convert][vox]") {
    test::PaintedWorld world({-300, 0, -20}, {300, 3, 280}, 0);
    world.fill({-300, 0, -20}, {300, 1, 280}, Material::kGrass);
    world.editable_info().bounds = world.level_bounds();
    test::ExportJob e(world, "a.vox");
    write_vox(e.job);
    const auto file = test::VoxReader::read(test::read_content(e.job.out));
    CHECK(file.voxels.size() == 600 * 300);
    CHECK(file.sizes.size() == 6);
    CHECK(file.voxels.begin()->first == std::array<int, 3>{-300, -150, 0});
    CHECK(file.voxels.rbegin()->first == std::array<int, 3>{299, 149, 0});
}

TEST_CASE("a vox file that would be too large leaves nothing behind", "[convert][vox]") {
    const auto world = test::lumps(23, 3);
    test::ExportJob e(*world, "a.vox");
    const auto most = GENERATE(std::uint64_t{1000}, std::uint64_t{300000});
    CHECK_THROWS_WITH(write_vox(e.job, {most}),
                      test::contains("more than " + std::to_string(most) + " bytes"));
    CHECK(test::files_in(e.folder.path()).empty());
}

TEST_CASE("counting colours does not depend on their order", "[convert][vox]") {
    std::mt19937 random(5);
    std::vector<voxel::Rgb8> colours;
    const auto channel = [&](unsigned most) { return static_cast<std::uint8_t>(random() % most); };
    for (int i = 0; i < 150000; ++i)
        colours.push_back({channel(256), channel(256), channel(9)});
    ColourCounts forward;
    ColourCounts backward;
    for (std::size_t i = 0; i < colours.size(); ++i) {
        forward.add(colours[i]);
        backward.add(colours[colours.size() - 1 - i]);
    }
    const auto a = forward.cells();
    const auto b = backward.cells();
    REQUIRE(a.size() == b.size());
    CHECK(a.size() <= ColourCounts::kMaxCells);
    std::uint64_t sum = 0;
    std::uint64_t differences = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += a[i].count;
        differences +=
            a[i].key != b[i].key || a[i].count != b[i].count || !(a[i].mean == b[i].mean);
    }
    CHECK(sum == colours.size());
    CHECK(differences == 0);
    for (const voxel::Rgb8 c : {colours[0], colours[77777]})
        CHECK(std::any_of(a.begin(), a.end(),
                          [&](const auto& cell) { return cell.key == forward.to_key(c); }));
}

TEST_CASE("few colours are better than a regular cube of them, and exact when they suffice",
          "[convert][vox]") {
    // A landscape's colours: greens, browns and greys, with rare bright ones.
    std::mt19937 random(GENERATE(1u, 2u));
    ColourCounts counts;
    const auto near = [&](int v) {
        return static_cast<std::uint8_t>(
            std::clamp(v + static_cast<int>(random() % 41) - 20, 0, 255));
    };
    for (int i = 0; i < 20000; ++i) {
        using Near = std::array<int, 3>;
        const Near c = i % 50 == 0  ? Near{220, 40, 30}
                       : i % 3 == 0 ? Near{120, 110, 90}
                                    : Near{70, 100, 50};
        counts.add({near(c[0]), near(c[1]), near(c[2])});
    }
    const auto cells = counts.cells();
    const auto few = few_colours(cells, 200);
    REQUIRE(few.colours.size() == 200);
    double own = 0;
    double regular = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const voxel::Rgb8 c = cells[i].mean;
        const voxel::Rgb8 f = few.colours[few.of_cell[i]];
        const auto to_cube = [](int v) { return (v * 5 + 127) / 255 * 51; };  // 216 colours
        const auto square = [&](int r, int g, int b) {
            return static_cast<double>(cells[i].count) *
                   ((c.r - r) * (c.r - r) + (c.g - g) * (c.g - g) + (c.b - b) * (c.b - b));
        };
        own += square(f.r, f.g, f.b);
        regular += square(to_cube(c.r), to_cube(c.g), to_cube(c.b));
    }
    CHECK(own < regular / 15);
    const std::vector<ColourCounts::Cell> three(cells.begin(), cells.begin() + 3);
    const auto exact = few_colours(three, 3);
    for (std::size_t i = 0; i < 3; ++i)
        CHECK(exact.colours[exact.of_cell[i]] == three[i].mean);
    CHECK(few_colours(three, 1).colours.size() == 1);
}
