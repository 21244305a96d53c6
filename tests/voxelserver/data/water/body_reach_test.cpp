#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/water/landscapes.hpp"
#include "voxelserver/data/water/body_finder.hpp"

using namespace terravox;
using namespace terravox::water;
using namespace terravox::water::test;

namespace {

constexpr int kSide = 8;  // cells along a patch

using Wet = bool (*)(std::int32_t, std::int32_t);

/// Water where `wet` says so, flat ground elsewhere; nothing beyond 12 patches.
FunctionSource::Make made(Wet wet) {
    return [wet](std::int32_t x, std::int32_t z) {
        if (std::abs(x >> 3) > 12 || std::abs(z >> 3) > 12)
            return WaterCell{};
        return wet(x, z) ? water_at(5, 4) : ground_at(7, 16);
    };
}

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
        Wet wet;
        std::int32_t cx;
        std::int32_t cz;
        voxel::InputExtent reach;
    };
    const Wet dry = [](std::int32_t, std::int32_t) { return false; };
    const Wet pond = [](std::int32_t x, std::int32_t z) {
        return x > 1 && x < 6 && z > 1 && z < 6;
    };
    const Wet wide = [](std::int32_t x, std::int32_t z) {
        return x > 1 && x < 8 && z > 1 && z < 6;
    };
    const Wet canal = [](std::int32_t x, std::int32_t z) { return z == 3 && x >= -30 && x < 42; };
    const auto c = GENERATE_COPY(values<Case>({
        {"dry land: its own patch", dry, 3, 3, {0, 0, 1, 1}},
        {"dry land south of 0", dry, -1, -9, {-1, -2, 0, -1}},
        {"a pond within a patch", pond, 3, 3, {0, 0, 1, 1}},
        {"a pond along a border", wide, 3, 3, {0, 0, 2, 1}},
        {"dry land next to that pond", wide, 0, 0, {0, 0, 1, 1}},
        {"a canal of nine patches", canal, 0, 3, {-4, 0, 6, 1}},
        {"the other end of it", canal, 41, 3, {-4, 0, 6, 1}},
    }));
    DYNAMIC_SECTION(c.name) {
        FunctionSource source(kSide, made(c.wet));
        WaterBodies bodies(source, options());
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
    const Wet wet = [](std::int32_t x, std::int32_t z) {
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
    const auto c = GENERATE(
        values<Case>({{"whole", 16384, std::size_t{512} << 20}, {"cut and forgotten", 20, 0}}));
    DYNAMIC_SECTION(c.name) {
        FunctionSource source(kSide, made(wet));
        std::vector<CellPlace> places;
        for (std::int32_t z = -100; z < 100; z += 3)
            for (std::int32_t x = -100; x < 100; x += 3)
                places.push_back({x, z});
        const auto reaches_by = [&](unsigned seed) {
            auto o = options(c.patches);
            o.memory_bytes = c.memory;
            WaterBodies bodies(source, o);
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
        for (unsigned seed = 2; seed < 4; ++seed)
            for (const auto& [place, reach] : reaches_by(seed)) {
                INFO("seed " << seed << ", cell " << place.first << ", " << place.second);
                CHECK(reach == first.at(place));
            }
    }
}

TEST_CASE("a body that is cut reaches everywhere", "[voxelserver][water][reach]") {
    FunctionSource source(kSide, made([](std::int32_t x, std::int32_t z) {
                              return std::abs(x) < 90 && std::abs(z) < 90;
                          }));
    WaterBodies bodies(source, options(16));
    voxel::InputExtent reach;
    CHECK(bodies.level(0, 0, &reach) == 5);
    CHECK(reach == kAnywhere);
}
