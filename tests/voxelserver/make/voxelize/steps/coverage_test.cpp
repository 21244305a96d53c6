// Which columns belong to the survey: gaps between points do, wide voids do not.
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Bounds = Grid<char, Window::kMargin>;
using InMask = std::function<bool(int x, int z)>;

Window find_window(const InMask& occupied) {
    return MadeLand([&](std::int32_t x, std::int32_t z, MadeLand::Returns& out) {
               if (occupied(x, z))
                   out.push_back({10, kGroundClass});
           })
        .window({0, 0});
}

Bounds measure_bounds(const InMask& inside) {
    Bounds out;
    Bounds::each([&](int x, int z) { out.at(x, z) = inside(x, z) ? 1 : 0; });
    return out;
}

/// A picture of 192 x 192 with sums over rectangles: the plain way to test any or all columns of
/// a square.
class Sums {
public:
    explicit Sums(const InMask& set) : m_sum(193 * 193) {
        for (int z = 0; z < 192; ++z)
            for (int x = 0; x < 192; ++x)
                at(x + 1, z + 1) =
                    at(x, z + 1) + at(x + 1, z) - at(x, z) + (set(x - 64, z - 64) ? 1 : 0);
    }
    /// How many of [x - r, x + r] x [z - r, z + r] are set, and how many there are.
    [[nodiscard]] std::pair<int, int> around(int x, int z, int r) const {
        const int x0 = std::max(x - r + 64, 0);
        const int x1 = std::min(x + r + 65, 192);
        const int z0 = std::max(z - r + 64, 0);
        const int z1 = std::min(z + r + 65, 192);
        return {at(x1, z1) - at(x0, z1) - at(x1, z0) + at(x0, z0), (x1 - x0) * (z1 - z0)};
    }

private:
    [[nodiscard]] int& at(int x, int z) { return m_sum[static_cast<std::size_t>(z * 193 + x)]; }
    [[nodiscard]] int at(int x, int z) const {
        return m_sum[static_cast<std::size_t>(z * 193 + x)];
    }
    std::vector<int> m_sum;
};

constexpr int kRim = 2;  // of water cells two columns wide, as MadeLand makes them

/// Closing as the book has it: a column is covered when every square around it that could be empty
/// holds something. Squares around places outside the bounds keep the rim's distance.
Margined<char> closed_naively(const InMask& occupied, const InMask& inside, int radius) {
    const Sums seen([&](int x, int z) { return occupied(x, z) && inside(x, z); });
    const auto empty = [&](int x, int z) { return seen.around(x, z, radius).first == 0; };
    const Sums within([&](int x, int z) { return inside(x, z) && empty(x, z); });
    const Sums beyond([&](int x, int z) { return !inside(x, z) && empty(x, z); });
    Margined<char> out;
    Margined<char>::each([&](int x, int z) {
        const bool hole = within.around(x, z, radius).first > 0 ||
                          beyond.around(x, z, std::max(radius - kRim, 0)).first > 0;
        out.at(x, z) = inside(x, z) && !hole ? 1 : 0;
    });
    return out;
}

const InMask kEverywhere = [](int, int) { return true; };

}  // namespace

TEST_CASE("a void is closed up to twice the radius, and open when wider",
          "[voxelserver][voxelize][coverage]") {
    struct Case {
        const char* name;
        int radius;
        int x0;
        int z0;
        int wide;
        int deep;
        bool open;
    };
    const auto c = GENERATE(values<Case>({
        {"twice the radius", 8, 20, 20, 16, 16, false},
        {"one more", 8, 20, 20, 17, 17, true},
        {"long and narrow: a street", 8, -64, 20, 192, 16, false},
        {"long and a column wider", 8, -64, 20, 192, 17, true},
        {"across the patch's corner", 8, -10, -10, 20, 20, true},
        {"the greatest radius", 31, 0, 0, 62, 62, false},
        {"one more", 31, 0, 0, 63, 63, true},
    }));
    DYNAMIC_SECTION(c.name << ", radius " << c.radius) {
        const auto in_void = [&](int x, int z) {
            return x >= c.x0 && x < c.x0 + c.wide && z >= c.z0 && z < c.z0 + c.deep;
        };
        const Window window = find_window([&](int x, int z) { return !in_void(x, z); });
        const auto covered = find_coverage(window, measure_bounds(kEverywhere), c.radius);
        int wrong = 0;
        Margined<char>::each([&](int x, int z) {
            wrong += (covered.at(x, z) != 0) == (c.open && in_void(x, z)) ? 1 : 0;
        });
        CHECK(wrong == 0);
    }
}

TEST_CASE("a void at the survey's edge closes only between returns along the edge",
          "[voxelserver][voxelize][coverage]") {
    constexpr int kNorth = 5;
    // The bounds' western edge lies at x = 10, the northern one at z = 5; the void begins there and
    // is `deep` and `wide` columns large.
    const auto inside = [](int x, int z) { return x >= 10 && z >= kNorth && x < 100; };
    struct Case {
        const char* name;
        int x0;
        int z0;
        int deep;
        int wide;
        bool open;
    };
    const auto c = GENERATE(values<Case>({
        {"as wide as a gap may be", 10, 10, 8, 16, false},
        {"deep, but between returns", 10, 10, 60, 16, false},
        {"wider", 10, 10, 8, 17, true},
        {"wider, and hardly deep: the rim", 10, 10, kRim, 40, false},
        {"wider, and hardly deep, all along the edge", 10, kNorth, kRim, 123, false},
        {"deeper than the rim, all along the edge", 10, kNorth, 20, 123, true},
        {"in the corner", 10, kNorth, 12, 12, true},
        {"in the corner, no larger than the rim", 10, kNorth, kRim, kRim, false},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto in_void = [&](int x, int z) {
            return x >= c.x0 && x < c.x0 + c.deep && z >= c.z0 && z < c.z0 + c.wide;
        };
        const auto covered =
            find_coverage(find_window([&](int x, int z) { return inside(x, z) && !in_void(x, z); }),
                          measure_bounds(inside), 8);
        // Beside returns a void of this size keeps at most twice the rim.
        const auto deep_in_void = [&](int x, int z) {
            for (int d = 0; d <= 2 * kRim; ++d)
                if (!in_void(x + d, z) || !in_void(x, z + d) ||
                    !in_void(x, std::max(z - d, kNorth)))
                    return false;
            return true;
        };
        int lost = 0;
        int spurious = 0;
        int left = 0;
        Margined<char>::each([&](int x, int z) {
            const bool is_covered = covered.at(x, z) != 0;
            lost += inside(x, z) && !(c.open && in_void(x, z)) && !is_covered ? 1 : 0;
            spurious += is_covered && (!inside(x, z) || (c.open && deep_in_void(x, z))) ? 1 : 0;
            left += c.open && inside(x, z) && !is_covered ? 1 : 0;
        });
        CHECK(lost == 0);
        CHECK(spurious == 0);
        CHECK((left > 0) == c.open);
    }
}

TEST_CASE("coverage is the closing by a square, at every radius",
          "[voxelserver][voxelize][coverage]") {
    const int radius = GENERATE(1, 2, 3, 8, 17, 31);
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        std::mt19937 random(seed * 100 + static_cast<unsigned>(radius));
        // Returns so rare that voids of the radius's size occur, and a rectangle without any.
        const double share = std::pow(2.0 * radius + 1, -2) * (0.5 + random() % 40 / 10.0);
        const int x0 = static_cast<int>(random() % 192) - 64;
        const int z0 = static_cast<int>(random() % 192) - 64;
        const int wide = static_cast<int>(random() % 90);
        const int deep = static_cast<int>(random() % 90);
        const int west = static_cast<int>(random() % 60) - 64;
        const int south = 128 - static_cast<int>(random() % 80);
        const auto occupied = [&](int x, int z) {
            return !(x >= x0 && x < x0 + wide && z >= z0 && z < z0 + deep) &&
                   dice(x, z, seed) < share;
        };
        const auto inside = [&](int x, int z) { return x >= west && z < south; };
        const auto found = find_coverage(find_window(occupied), measure_bounds(inside), radius);
        INFO("radius " << radius << ", seed " << seed);
        CHECK((found.values() == closed_naively(occupied, inside, radius).values()));
    }
}
