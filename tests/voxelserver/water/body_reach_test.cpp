#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <thread>

#include "tests/catch.hpp"
#include "voxelserver/water/body_finder.hpp"

using namespace terravox;
using namespace terravox::water;

namespace {

constexpr int kSide = 8;  // cells along a patch

/// Water where `wet` says so, flat ground elsewhere; nothing beyond 12 patches.
class Made final : public CellSource {
public:
    using Wet = bool (*)(std::int32_t, std::int32_t);
    explicit Made(Wet wet) : m_wet(wet) {}
    std::shared_ptr<const CellPatch> cells(std::int32_t px, std::int32_t pz) override {
        auto out = std::make_shared<CellPatch>();
        out->side = kSide;
        for (std::int32_t z = pz * kSide; z < (pz + 1) * kSide; ++z)
            for (std::int32_t x = px * kSide; x < (px + 1) * kSide; ++x) {
                WaterCell c;
                c.covered = std::abs(px) <= 12 && std::abs(pz) <= 12;
                if (c.covered && m_wet(x, z)) {
                    c.water = 5;
                    c.water_points = 4;
                } else if (c.covered) {
                    c.ground = 7;
                    c.ground_points = 16;
                }
                out->cells.push_back(c);
            }
        return out;
    }

private:
    Wet m_wet;
};

WaterOptions options(std::size_t max_patches = 16384) {
    WaterOptions out;
    out.cell_voxels = 64 / kSide;
    out.max_body_patches = max_patches;
    return out;
}

}  // namespace

TEST_CASE("a level reaches as far as its body and one patch beyond where the body touches a border",
          "[voxelserver][water][reach]") {
    struct Case {
        const char* name;
        Made::Wet wet;
        std::int32_t cx;
        std::int32_t cz;
        voxel::InputExtent reach;
    };
    const auto c = GENERATE(values<Case>({
        {"dry land: its own patch",
         [](std::int32_t, std::int32_t) { return false; },
         3,
         3,
         {0, 0, 1, 1}},
        {"dry land south of 0",
         [](std::int32_t, std::int32_t) { return false; },
         -1,
         -9,
         {-1, -2, 0, -1}},
        {"a pond within a patch",
         [](std::int32_t x, std::int32_t z) { return x > 1 && x < 6 && z > 1 && z < 6; },
         3,
         3,
         {0, 0, 1, 1}},
        {"a pond along a border",
         [](std::int32_t x, std::int32_t z) { return x > 1 && x < 8 && z > 1 && z < 6; },
         3,
         3,
         {0, 0, 2, 1}},
        {"dry land next to that pond",
         [](std::int32_t x, std::int32_t z) { return x > 1 && x < 8 && z > 1 && z < 6; },
         0,
         0,
         {0, 0, 1, 1}},
        {"a canal of nine patches",
         [](std::int32_t x, std::int32_t z) { return z == 3 && x >= -30 && x < 42; },
         0,
         3,
         {-4, 0, 6, 1}},
        {"the other end of it",
         [](std::int32_t x, std::int32_t z) { return z == 3 && x >= -30 && x < 42; },
         41,
         3,
         {-4, 0, 6, 1}},
    }));
    DYNAMIC_SECTION(c.name) {
        Made made(c.wet);
        WaterBodies bodies(made, options());
        for (int i = 0; i < 2; ++i) {  // found, then remembered
            voxel::InputExtent reach;
            static_cast<void>(bodies.level(c.cx, c.cz, &reach));
            INFO(reach.min_bx << ", " << reach.min_bz << " to " << reach.max_bx << ", "
                              << reach.max_bz);
            CHECK(reach == c.reach);
        }
    }
}

TEST_CASE("reaches depend neither on earlier requests nor on the cache",
          "[voxelserver][water][reach][property]") {
    // Ponds, canals and single cells: many bodies in one patch.
    const Made::Wet wet = [](std::int32_t x, std::int32_t z) {
        const std::uint32_t h = (static_cast<std::uint32_t>(x) * 2654435761U ^
                                 static_cast<std::uint32_t>(z) * 2246822519U) >>
                                13;
        return h % 100 < 42 || (z == 3 && x > -60) || std::abs(x - z) < 2;
    };
    struct Case {
        const char* name;
        std::size_t patches;
        std::size_t memory;
    };
    const auto c = GENERATE(values<Case>({{"whole", 16384, std::size_t{512} << 20},
                                          {"large ones cut", 20, std::size_t{512} << 20},
                                          {"nothing remembered", 20, 0}}));
    DYNAMIC_SECTION(c.name) {
        Made made(wet);
        std::vector<CellPlace> places;
        for (std::int32_t z = -100; z < 100; z += 3)
            for (std::int32_t x = -100; x < 100; x += 3)
                places.push_back({x, z});
        const auto reaches_by = [&](unsigned seed) {
            auto o = options(c.patches);
            o.memory_bytes = c.memory;
            WaterBodies bodies(made, o);
            auto order = places;
            std::shuffle(order.begin(), order.end(), std::mt19937(seed));
            std::map<std::pair<std::int32_t, std::int32_t>, voxel::InputExtent> out;
            for (const CellPlace p : order)
                static_cast<void>(bodies.level_near(p.x, p.z, &out[{p.x, p.z}]));
            return out;
        };
        const auto first = reaches_by(1);
        std::size_t wide = 0;
        for (const auto& [place, reach] : first)
            wide += reach.max_bx - reach.min_bx > 3 ? 1 : 0;
        CHECK(wide > 0);
        CHECK(wide < first.size());
        for (unsigned seed = 2; seed < 5; ++seed)
            for (const auto& [place, reach] : reaches_by(seed)) {
                INFO("seed " << seed << ", cell " << place.first << ", " << place.second);
                CHECK(reach == first.at(place));
            }
    }
}

TEST_CASE("a body that is cut reaches everywhere", "[voxelserver][water][reach]") {
    Made made([](std::int32_t x, std::int32_t z) { return std::abs(x) < 90 && std::abs(z) < 90; });
    WaterBodies bodies(made, options(16));
    voxel::InputExtent reach;
    CHECK(bodies.level(0, 0, &reach) == 5);
    CHECK(reach == kAnywhere);
}
