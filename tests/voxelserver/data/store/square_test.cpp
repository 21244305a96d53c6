// Points by patch and column: the same bytes however they came.
#include <algorithm>
#include <cstring>
#include <random>

#include "tests/catch.hpp"
#include "voxelserver/data/store/square.hpp"

using namespace terravox;
using namespace terravox::store;

namespace {

struct Placed {
    grid::PatchKey patch;
    store::VoxelPoint point;
};

/// Many points in few columns, so that equal columns, heights, classes and places all occur.
std::vector<Placed> some_points(unsigned seed, std::size_t count) {
    std::mt19937 random(seed);
    std::vector<Placed> out;
    for (std::size_t i = 0; i < count; ++i) {
        Placed p;
        p.patch = {static_cast<std::int32_t>(random() % 4) - 2,
                   static_cast<std::int32_t>(random() % 4) - 2};
        const bool crowded = random() % 2 == 0;
        p.point.x = static_cast<std::uint16_t>(crowded ? random() % 4 : random());
        p.point.z = static_cast<std::uint16_t>(crowded ? random() % 4 + 60'000 : random());
        p.point.y = static_cast<std::int32_t>(random() % 8) * 1000 - 4000;
        p.point.source_class = static_cast<std::uint8_t>(random() % 3 == 0 ? 201 : 2);
        p.point.colour = {static_cast<std::uint8_t>(random() % 2), 0,
                          static_cast<std::uint8_t>(random() % 2)};
        out.push_back(p);
    }
    return out;
}

std::shared_ptr<const store::Square> binned(const std::vector<Placed>& points, std::size_t parts,
                                            unsigned seed, int threads) {
    std::mt19937 random(seed);
    std::vector<store::PatchedPoints> dealt(parts);
    for (const Placed& p : points)
        dealt[random() % parts].add(p.patch, p.point);
    return store::bin_points(std::move(dealt), {}, threads);
}

bool same_bytes(const store::Square& a, const store::Square& b) {
    return a.all().size() == b.all().size() &&
           std::memcmp(a.all().data(), b.all().data(), a.all().size_bytes()) == 0 &&
           a.patches().size() == b.patches().size() &&
           std::memcmp(a.patches().data(), b.patches().data(), a.patches().size_bytes()) == 0;
}

}  // namespace

TEST_CASE("binned points do not depend on their order, nor on how they were dealt into parts",
          "[voxelserver][voxelize][square]") {
    const unsigned seed = GENERATE(range(1u, 4u));
    auto points = some_points(seed, 20'000);
    const auto reference = binned(points, 1, seed, 1);
    for (std::size_t parts = 1; parts <= 7; parts += 2) {
        std::shuffle(points.begin(), points.end(),
                     std::mt19937(seed + static_cast<unsigned>(parts)));
        const auto other = binned(points, parts, seed, static_cast<int>(parts % 3));
        INFO("seed " << seed << ", " << parts << " parts");
        CHECK(same_bytes(*reference, *other));
    }
}

TEST_CASE("each patch holds its points and no others, by column and rising height",
          "[voxelserver][voxelize][square]") {
    const auto points = some_points(77, 5'000);
    const auto square = binned(points, 3, 1, 2);
    CHECK(std::is_sorted(
        square->patches().begin(), square->patches().end(),
        [](const store::PatchEntry& a, const store::PatchEntry& b) { return a.key < b.key; }));
    std::size_t seen = 0;
    for (std::int32_t pz = -3; pz < 3; ++pz)
        for (std::int32_t px = -3; px < 3; ++px) {
            const auto mine = square->points({px, pz});
            seen += mine.size();
            const auto wanted = std::count_if(points.begin(), points.end(), [&](const Placed& p) {
                return p.patch == grid::PatchKey{px, pz};
            });
            INFO("patch " << px << ", " << pz);
            CHECK(mine.size() == static_cast<std::size_t>(wanted));
            CHECK(std::is_sorted(mine.begin(), mine.end(),
                                 [](const store::VoxelPoint& a, const store::VoxelPoint& b) {
                                     return a.column() != b.column() ? a.column() < b.column()
                                                                     : a.y < b.y;
                                 }));
        }
    CHECK(seen == points.size());
}
