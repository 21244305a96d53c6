// Each step switched off: the world is there, and differs where that step has its say.
#include <random>
#include <set>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

constexpr double kNoPoint = std::numeric_limits<double>::quiet_NaN();

/// A rectangle in metres from the corner.
struct Place {
    double east0;
    double north0;
    double east1;
    double north1;
    [[nodiscard]] bool holds(double e, double n, double more = 0) const {
        return e >= east0 - more && e < east1 + more && n >= north0 - more && n < north1 + more;
    }
};
constexpr Place kHouse{20, 20, 36, 32};
constexpr Place kDeck{50, 60, 110, 66};
constexpr Place kWood{70, 10, 100, 40};
constexpr Place kLake{20, 70, 60, 115};

/// One of everything that a step works on, on flat ground, each with gaps.
void write_land(const std::filesystem::path& file) {
    Cloud cloud;
    std::mt19937 random(5);
    const auto unit = [&] { return static_cast<double>(random() % 10'000) / 10'000; };
    constexpr std::array<std::uint16_t, 3> kMeadow{0x7000, 0x8900, 0x4a00};
    constexpr std::array<std::uint16_t, 3> kAsphalt{0x7400, 0x7400, 0x7800};
    constexpr std::array<std::uint16_t, 3> kTiles{0xb200, 0x5400, 0x3800};
    for (int i = 0; i < 100'000; ++i) {
        const double e = unit() * 120;
        const double n = unit() * 120;
        if (kHouse.holds(e, n)) {
            if (unit() < 0.4)
                cloud.add(e, n, 60.4, 6, kTiles);
        } else if (kLake.holds(e, n)) {
            if (unit() < 0.1)
                cloud.add(e, n, 49.4 + 0.3 * unit(), 9);
        } else {
            if (kDeck.holds(e, n) && unit() < 0.4)
                cloud.add(e, n, 58.4, 17, kAsphalt);
            else if (kWood.holds(e, n) && unit() < 0.4)
                cloud.add(e, n, 58.4 + 6 * std::sin(e / 2) * std::sin(n / 3), 5, kMeadow);
            else if (unit() < 0.35)
                cloud.add(e, n, 50.5, 2,
                          n > 45 && n < 52 ? kAsphalt
                          : unit() < 0.02  ? kAsphalt
                                           : kMeadow);
        }
    }
    cloud.write(file, kCrs, 7);
}

OpenWorld open_with(const std::string& steps) {
    struct Land {
        Land() { write_land(file); }
        TemporaryFolder folder;
        std::filesystem::path file = folder.path() / "land.laz";
    };
    static const Land land;
    auto options = OpenWorld::with(land.file);
    options.steps = steps;
    return OpenWorld(options);
}

}  // namespace

TEST_CASE("a step that is switched off changes what it works on and nothing else",
          "[voxelserver][voxelize][settings]") {
    static OpenWorld on = open_with("");
    constexpr Place kEverywhere{-10, -10, 130, 130};
    struct Case {
        const char* off;
        Place where;
        bool solids;
    };  // solids: whether it may change which voxels are solid
    const auto c = GENERATE_COPY(values<Case>({
        {"building_fill", kHouse, true},
        {"bridges", kDeck, true},
        {"ground_fill", kEverywhere, true},
        {"vegetation", kWood, true},
        {"colour_variation", kEverywhere, false},
        {"specialization", kEverywhere, false},
        {"neighbourhood_filters", kEverywhere, false},
        {"water_equalization", kLake, true},
        {"water_deepening", kLake, false},
    }));
    DYNAMIC_SECTION(c.off) {
        OpenWorld off = open_with(std::string("-") + c.off);
        REQUIRE(off.info().bounds == on.info().bounds);
        int different = 0;
        int elsewhere = 0;
        int solids = 0;
        int boxes = 0;
        for (const auto& key : all_keys(on.info(), 0)) {
            const auto a = on.world().box(key);
            const auto b = off.world().box(key);
            boxes += b ? 1 : 0;
            if ((a ? a->checksum() : 0) == (b ? b->checksum() : 0))
                continue;
            for (int y = 0; y < 256; ++y)
                for (int z = 0; z < 64; ++z)
                    for (int x = 0; x < 64; ++x) {
                        const auto p = a ? a->voxel(x, y, z) : std::nullopt;
                        const auto q = b ? b->voxel(x, y, z) : std::nullopt;
                        if (p == q)
                            continue;
                        ++different;
                        solids += p.has_value() != q.has_value() ? 1 : 0;
                        const double e = key.bx * 64 + x + 0.5 - kEast0;
                        const double n = -(key.bz * 64 + z + 0.5) - kNorth0;
                        // Walls and shores show a voxel more of what is next to them; a cell of
                        // water is two voxels.
                        if (!c.where.holds(e, n, 3) && ++elsewhere <= 3)
                            UNSCOPED_INFO("differs at " << e << " m east, " << n
                                                        << " m north, height " << key.by * 256 + y);
                    }
        }
        CHECK(boxes >= 4);
        CHECK(different > 20);
        CHECK(elsewhere == 0);
        CHECK((solids > 0) == c.solids);
    }
}

TEST_CASE("with every step switched off there is still a world",
          "[voxelserver][voxelize][settings]") {
    OpenWorld world = open_with("none");
    std::set<voxel::Material> seen;
    for (int x = 0; x < 120; ++x)
        for (int z = 1; z < 120; ++z)
            if (const auto top = world.top_voxel(voxel_x(x + 0.5), voxel_z(z + 0.5)))
                seen.insert(top->material);
    using voxel::Material;
    CHECK(seen == std::set{Material::kGround, Material::kRoof, Material::kBridge, Material::kWater,
                           Material::kHighVegetation});
}
