// From what the steps found to voxels: runs, and the attributes of a box's voxels.
#include "voxelserver/make/voxelize/steps/runs.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/decks/bridges.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
using voxel::Material;
using voxel::Rgb8;

namespace {

using Returns = MadeLand::Returns;
constexpr Rgb8 kRed{200, 10, 20};
constexpr Rgb8 kSeen{1, 2, 3};

/// The runs of a land without holes or wide gaps; water of the columns' own levels, 2 m deep.
struct Made {
    PatchRuns runs;
    explicit Made(const MadeLand::ReturnsAt& returns, bool has_colour = false,
                  std::int32_t floor_y = 0, const Settings& given = {},
                  Material special = Material::kAir, double voxel_m = 1) {
        MadeLand land(returns, has_colour);
        Settings settings = given;
        settings.water.min_depth_m = 2;
        const Window window = land.window({0, 0});
        auto water = fill_water(window, nullptr);
        level_bed(settings.water.min_depth_m, water);
        const auto ground = fill_ground(window, Grid<char, GroundHeights::kMargin>(1),
                                        [](auto, auto) { return kNoHeight; });
        const auto crowns = fill_crowns(window, asprs(), ground, settings, 1);
        runs = make_runs({window, asprs(), settings, Margined<char>(1), water, ground,
                          fill_buildings(window, settings.buildings, 1), fill_decks(window), crowns,
                          Margined<Material>(special), Margined<char>(), PlaceNumbers(), floor_y,
                          voxel_m});
    }
    /// A letter for each voxel of a column from the bottom up: see kLetters.
    [[nodiscard]] std::string column(int x, int z, std::int32_t from, std::int32_t to,
                                     const SurfaceAppearance& appearance = plain()) const {
        std::string out;
        for (std::int32_t y = from; y < to; ++y) {
            const auto box = serialize({0, 0, voxel::floor_div(y, 256), 0}, runs, appearance);
            const auto v = box ? box->voxel(x, y & 255, z) : std::nullopt;
            out += v ? kLetters[static_cast<std::size_t>(v->material)] : '.';
        }
        return out;
    }
    [[nodiscard]] std::optional<voxel::VoxelAttr> at(
        int x, std::int32_t y, int z, const SurfaceAppearance& appearance = plain()) const {
        const auto box = serialize({0, 0, voxel::floor_div(y, 256), 0}, runs, appearance);
        return box ? box->voxel(x, y & 255, z) : std::nullopt;
    }
    static SurfaceAppearance plain() {
        SurfaceAppearance out;
        out.own = std::make_shared<PatchAppearance>();
        return out;
    }
    /// An image of one colour over the whole patch.
    static SurfaceAppearance with_image() {
        auto own = std::make_shared<PatchAppearance>();
        own->raster.width = own->raster.height = grid::kPatchSize;
        own->raster.colour.assign(grid::kPatchColumns, kSeen);
        own->raster.nir.assign(grid::kPatchColumns, 0);
        own->raster.red = own->raster.nir;
        own->raster.flags.assign(grid::kPatchColumns, imagery::Raster::kColour);
        SurfaceAppearance out;
        out.own = own;
        return out;
    }
    static constexpr const char* kLetters = ".RSGglmhWrOYFwbocaiTxsn?t";
};

bool bump(int x, int z) {
    return x >= 30 && x < 34 && z >= 30 && z < 34;
}

}  // namespace

TEST_CASE("columns are what stands in them, from the rock up", "[voxelserver][voxelize][runs]") {
    struct Case {
        const char* name;
        std::vector<Return> returns;
        const char* column;
    };  // of four by four columns in flat ground, at its edge, y from 8 to 24
    const auto c = GENERATE(values<Case>({
        {"flat ground hides soil and rock", {{10.5, kGroundClass}}, "RRG............."},
        {"a road", {{10.5, 11}}, "RRo............."},
        {"a pit shows soil next to it", {{8.5, kGroundClass}}, "G..............."},
        {"a house", {{18.5, kBuilding}, {18.4, kBuilding}}, "RRRWWWWWWWr....."},
        {"a canopy",
         {{16.5, kBuilding}, {16.4, kBuilding}, {10.5, kGroundClass}},
         "RRG.....r......."},
        {"a roof in the ground", {{9.5, kBuilding}, {9.4, kBuilding}}, "RRr............."},
        {"a bridge over ground",
         {{20.5, kBridge}, {20.5, kBridge}, {10.5, kGroundClass}},
         "RRG.........b..."},
        {"water over its bed", {{10.5, kWater}}, "sww............."},
        {"a wire", {{10.5, kGroundClass}, {20.5, kWire}}, "RRG.........i..."},
        {"grass on the ground", {{10.5, kGroundClass}, {10.9, kLow}}, "RRg............."},
        {"a class without a name", {{10.5, kGroundClass}, {12.5, 200}}, "RRG.m..........."},
        {"an unsorted bush",
         {{10.5, kGroundClass}, {11.8, kUnsorted}, {12.2, kUnsorted}},
         "RRGmm..........."},
    }));
    DYNAMIC_SECTION(c.name) {
        const Made made([&](int x, int z, Returns& out) {
            if (bump(x, z))
                out = c.returns;
            else
                out.push_back({10.5, kGroundClass});
        });
        CHECK(made.column(30, 31, 8, 24) == c.column);
    }
}

TEST_CASE("what ends below a box hides what stands on it", "[voxelserver][voxelize][runs]") {
    // The ground ends where the upper box begins. Hidden voxels are read as rock.
    const Made made([](int x, int z, Returns& out) {
        if (bump(x, z))
            out = {{263.5, kBuilding}, {263.4, kBuilding}};
        else
            out.push_back({255.5, kGroundClass});
    });
    CHECK(made.column(30, 31, 254, 264) == "RRWWWWWWWr");
    CHECK(made.column(31, 31, 254, 264) == "RRRRRRRRRr");
}

TEST_CASE("a tree's trunk leaves no air between the ground and its crown",
          "[voxelserver][voxelize][runs]") {
    const Made made([](int x, int z, Returns& out) {
        const double d = std::hypot(x - 31, z - 31);
        if (d <= 3)
            out.push_back({22.5 - 2 * d, kTree});
        if (d > 3 || dice(x, z, 1) < 0.3)
            out.push_back({10.5, kGroundClass});
    });
    const std::string column = made.column(31, 31, 10, 24);
    INFO(column);
    CHECK(column.find('t') == 1);  // on the ground
    CHECK(column.find('.') == 13);
    CHECK(column.find_last_of('t') + 1 == column.find('h'));
    CHECK(made.column(33, 31, 10, 24).find('t') == std::string::npos);
}

TEST_CASE("on a roof stand things of the roof and plants; on its walls nothing",
          "[voxelserver][voxelize][runs]") {
    struct Case {
        const char* name;
        int x;
        std::vector<Return> returns;  // besides those of the house, x from 30 to 33, or the ground
        const char* column;           // y from 10 to 26
    };
    const auto c = GENERATE(values<Case>({
        {"a chimney", 30, {{20.5, kUnsorted}, {20.5, kUnsorted}}, "RWWWWWWWrrr....."},
        {"a tree", 30, {{21.5, kTree}, {21.5, kTree}}, "RWWWWWWWrhhh...."},
        {"a bough high above", 30, {{24.5, kTree}}, "RWWWWWWWr.....h."},
        {"a balcony", 29, {{13.5, kUnsorted}, {16.5, kUnsorted}}, "G..............."},
        {"scatter of a plant's class", 29, {{14.5, kTree}, {16.5, kTree}}, "G..............."},
    }));
    DYNAMIC_SECTION(c.name) {
        Settings settings;
        settings.points.drop_isolated = false;
        const Made made(
            [&](int x, int z, Returns& out) {
                if (bump(x, z))
                    out.insert(out.end(), {{18.5, kBuilding}, {18.4, kBuilding}});
                else
                    out.push_back({10.5, kGroundClass});
                if (x == c.x && z == 31)
                    out.insert(out.end(), c.returns.begin(), c.returns.end());
            },
            false, 0, settings);
        CHECK(made.column(c.x, 31, 10, 26) == c.column);
    }
}

TEST_CASE("soil lies on the rock, but not on cliffs", "[voxelserver][voxelize][runs]") {
    const double drop = GENERATE(2.0, 6.0);
    const Made made([&](int x, int, Returns& out) {
        out.push_back({x < 32 ? 20.5 : 20.5 - drop, kGroundClass});
    });
    CHECK(made.column(31, 20, 21 - static_cast<int>(drop), 22) == (drop > 3 ? "RRRRRG." : "SG."));
}

TEST_CASE("voxels carry class and colour; what was not seen from above has no colour",
          "[voxelserver][voxelize][serialize]") {
    const Made made(
        [](int x, int z, Returns& out) {
            if (!bump(x, z))
                out.push_back({10.5, 11, kRed});
            else if (x < 32)
                out.insert(out.end(), {{18.5, kBuilding, kRed}, {18.5, kBuilding, kRed}});
            else
                out.push_back({10.5, kWater, kRed});
        },
        true);
    struct Case {
        const char* name;
        int x;
        int y;
        Material material;
        int source_class;
        bool own;
        bool with_image;
    };
    const auto c = GENERATE(values<Case>({
        {"road", 5, 10, Material::kRoad, 11, true, true},
        {"roof", 30, 18, Material::kRoof, kBuilding, true, true},
        {"wall", 30, 15, Material::kWall, kBuilding, false, false},
        {"water keeps its points' colour", 33, 10, Material::kWater, kWater, true, true},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto own = made.at(c.x, c.y, 31);
        const auto seen = made.at(c.x, c.y, 31, Made::with_image());
        REQUIRE(own);
        REQUIRE(seen);
        CHECK((own->material == c.material && own->source_class == c.source_class &&
               seen->material == c.material && seen->source_class == c.source_class));
        CHECK(own->has_colour() == c.own);
        if (c.own)
            CHECK(own->colour == kRed);
        CHECK(seen->has_colour() == c.with_image);
        if (c.with_image)
            CHECK(seen->colour == (c.material == Material::kWater ? kRed : kSeen));
    }
}

TEST_CASE("an image shows what lies on top, and not what is beneath a deck",
          "[voxelserver][voxelize][serialize]") {
    const Made made(
        [](int x, int z, Returns& out) {
            out.push_back({10.5, kGroundClass, kRed});
            if (bump(x, z))
                out.insert(out.end(), {{20.5, kBridge, kRed}, {20.5, kBridge, kRed}});
        },
        true);
    const auto appearance = Made::with_image();
    CHECK(made.at(31, 20, 31, appearance)->colour == kSeen);
    CHECK(made.at(31, 10, 31, appearance)->colour == kRed);
    CHECK(made.at(5, 10, 5, appearance)->colour == kSeen);
}

TEST_CASE("special materials are the surface's: of the ground next to a house, of the roof on it",
          "[voxelserver][voxelize][runs]") {
    const auto returns = [](int x, int z, Returns& out) {
        if (bump(x, z))
            out.insert(out.end(), {{18.5, kBuilding}, {18.5, kBuilding}});
        else
            out.push_back({10.5, kGroundClass});
    };
    CHECK(Made(returns, false, 0, {}, Material::kSnow).column(5, 5, 10, 12) == "n.");
    CHECK(Made(returns, false, 0, {}, Material::kSnow).column(30, 31, 10, 20) == "RWWWWWWWn.");
}

TEST_CASE("boxes are cut from columns at every 256 voxels, and air is no box",
          "[voxelserver][voxelize][serialize]") {
    const double height = GENERATE(-300.5, -0.5, 255.5, 256.5);
    INFO(height);
    const auto top = static_cast<std::int32_t>(std::floor(height));
    const Made made([&](int, int, Returns& out) { out.push_back({height, kGroundClass}); }, false,
                    top - 300);
    CHECK(made.runs.min_y() == top - 300);
    CHECK(made.runs.max_y() == top + 1);
    const auto appearance = Made::plain();
    for (std::int32_t by = voxel::floor_div(top - 300, 256) - 1;
         by <= voxel::floor_div(top, 256) + 1; ++by) {
        const auto box = serialize({0, 0, by, 0}, made.runs, appearance);
        INFO("box " << by);
        REQUIRE((box != nullptr) == (by * 256 <= top && by * 256 + 256 > top - 300));
        if (!box)
            continue;
        for (int y = 0; y < 256; ++y)
            REQUIRE(box->solid(7, y, 9) == (by * 256 + y >= top - 300 && by * 256 + y <= top));
    }
    CHECK(made.at(7, top, 9)->material == Material::kGround);
}

TEST_CASE("more soil than a run can count is as much as it can count",
          "[voxelserver][voxelize][runs]") {
    const double voxel_m = GENERATE(1.0, 0.01, 0.001, 1e-9);
    INFO("voxels of " << voxel_m << " m");
    Settings settings;
    settings.ground.soil_m = 100;
    const Made made([](int, int, Returns& out) { out.push_back({40'000.5, kGroundClass}); }, false,
                    0, settings, Material::kAir, voxel_m);
    const auto column = made.runs.column(30, 30);
    REQUIRE(column.size() == 1);
    CHECK(column[0].soil == std::min(std::lround(100 / voxel_m), 32'767L));
}
