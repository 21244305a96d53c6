#include "voxelserver/data/imagery/filters.hpp"

#include <fstream>
#include <map>
#include <random>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/data/imagery/palette_file.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::imagery;
using voxel::Material;

namespace {

constexpr std::array kSome = {Material::kAir,       Material::kGround,   Material::kGrass,
                              Material::kRoad,      Material::kWater,    Material::kConcrete,
                              Material::kRoof,      Material::kGreyRoof, Material::kFlatRoof,
                              Material::kOrangeRoof};

MaterialSet bits(std::initializer_list<Material> materials) {
    MaterialSet out = 0;
    for (const Material m : materials)
        out |= to_bit(m);
    return out;
}

FilterRow row(MaterialSet of, MaterialSet by, std::optional<Material> to, double radius_m,
              int permille) {
    return {"test", of, by, to, radius_m, permille, -1};
}

/// A grid from letters: '.' air, g grass, r road, w water.
Grid make_grid(const std::vector<std::string>& lines, int margin) {
    const std::map<char, Material> letters{{'.', Material::kAir},
                                           {'g', Material::kGrass},
                                           {'r', Material::kRoad},
                                           {'w', Material::kWater}};
    Grid grid;
    grid.width = static_cast<int>(lines[0].size());
    grid.height = static_cast<int>(lines.size());
    grid.margin = margin;
    for (const auto& line : lines)
        for (const char c : line)
            grid.material.push_back(letters.at(c));
    return grid;
}

Material middle(const Grid& grid) {
    return grid.material[static_cast<std::size_t>(grid.height / 2 * grid.width + grid.width / 2)];
}

/// Patches of one material with speckles, and some columns fixed or silent.
Grid random_grid(int width, int height, int margin, std::mt19937& numbers) {
    Grid grid{width, height, margin, {}, {}};
    std::vector<Material> coarse;
    for (int i = 0; i < 4096; ++i)
        coarse.push_back(kSome[numbers() % kSome.size()]);
    for (int z = 0; z < height; ++z)
        for (int x = 0; x < width; ++x) {
            const auto dice = numbers();
            grid.material.push_back(
                dice % 4 == 0 ? kSome[dice / 4 % kSome.size()]
                              : coarse[static_cast<std::size_t>(z / 7 % 64 * 64 + x / 9 % 64)]);
            grid.flags.push_back(dice >> 20 & (dice >> 22 & dice >> 24 & 3U));
        }
    return grid;
}

/// The rows one after another over all of a grid, disc by disc; discs are cut at the grid's edge.
Grid by_definition(Grid grid, const Filters& filters, double voxel_m) {
    const auto radii = list_radii(filters, voxel_m);
    for (std::size_t f = 0; f < filters.size(); ++f) {
        const FilterRow& filter = filters[f];
        const Grid before = grid;
        for (int z = 0; z < grid.height; ++z)
            for (int x = 0; x < grid.width; ++x) {
                const auto at = static_cast<std::size_t>(z * grid.width + x);
                const Material own = before.material[at];
                if ((filter.of & to_bit(own)) == 0 ||
                    (!before.flags.empty() && (before.flags[at] & Grid::kFixed) != 0))
                    continue;
                std::map<Material, int> votes;
                int area = 0;
                int total = 0;
                const int r = radii[f];
                for (int dz = -r; dz <= r; ++dz)
                    for (int dx = -r; dx <= r; ++dx) {
                        if (dx * dx + dz * dz > r * r + r)
                            continue;
                        ++area;
                        if (x + dx < 0 || z + dz < 0 || x + dx >= grid.width ||
                            z + dz >= grid.height)
                            continue;
                        const auto other = static_cast<std::size_t>((z + dz) * grid.width + x + dx);
                        if (before.material[other] == Material::kAir ||
                            (!before.flags.empty() && (before.flags[other] & Grid::kSilent) != 0))
                            continue;
                        ++votes[before.material[other]];
                    }
                if (filter.at_most_permille >= 0) {
                    if (votes[own] * 1000 <= filter.at_most_permille * area)
                        grid.material[at] = *filter.to;
                    continue;
                }
                Material winner = Material::kAir;
                int best = 0;
                for (const auto& [m, n] : votes) {
                    if ((filter.by & to_bit(m)) == 0 && !(filter.to && m == *filter.to))
                        continue;
                    total += n;
                    if (filter.to ? m == *filter.to : n > best) {
                        best = n;
                        winner = m;
                    }
                }
                if (best == 0 ||
                    (!filter.to && votes[own] == best && (filter.by & to_bit(own)) != 0))
                    continue;
                if (best * 1000 >= filter.at_least_permille * total)
                    grid.material[at] = winner;
            }
    }
    return grid;
}

Filters random_filters(std::mt19937& numbers) {
    Filters filters;
    const auto count = 1 + numbers() % 7;
    for (unsigned i = 0; i < count; ++i) {
        FilterRow f;
        f.name = std::to_string(i);
        f.of = numbers() & 0x1FFFEU;
        f.by = numbers() & 0x1FFFEU;
        if (numbers() % 2 == 0)
            f.to = kSome[1 + numbers() % (kSome.size() - 1)];
        f.radius_m = 0.5 + numbers() % 60 * 0.1;
        f.at_least_permille = 200 + static_cast<int>(numbers() % 700);
        if (numbers() % 4 == 0) {
            f.at_most_permille = static_cast<int>(numbers() % 400);
            f.to = Material::kGround;
        }
        filters.push_back(f);
    }
    return filters;
}

}  // namespace

TEST_CASE("the share of the votes counts, and what has no vote does not",
          "[voxelserver][imagery][filters]") {
    const auto run = [](const std::vector<std::string>& lines, int permille,
                        std::optional<Material> to = Material::kWater) {
        Grid grid = make_grid(lines, 1);
        apply_filters(grid,
                      {row(bits({Material::kGrass}), bits({Material::kGrass, Material::kWater}), to,
                           1, permille)},
                      1);
        return middle(grid);
    };
    CHECK(run({"www", "wgg", "ggg"}, 444) == Material::kWater);  // 4 of 9
    CHECK(run({"www", "wgg", "ggg"}, 445) == Material::kGrass);
    CHECK(run({"ww.", "wg.", "..."}, 750) == Material::kWater);  // air has no vote: 3 of 4
    CHECK(run({"wwr", "wgr", "rrr"}, 750) == Material::kWater);  // roads have no vote
    CHECK(run({"rrr", "rgr", "rrr"}, 1) == Material::kGrass);    // no water at all
    CHECK(run({"www", "wgg", "gg."}, 1, std::nullopt) == Material::kGrass);  // 4 to 4: it stays
    CHECK(run({"...", ".r.", "..."}, 1) == Material::kRoad);  // not of those that may change
}

TEST_CASE("radii follow the voxel and the margin stays bounded",
          "[voxelserver][imagery][filters]") {
    const auto all = bits({Material::kGrass, Material::kRoad});
    CHECK(list_radii({row(all, all, std::nullopt, 3, 500)}, 1) == std::vector<int>{3});
    CHECK(list_radii({row(all, all, std::nullopt, 3, 500)}, 2) == std::vector<int>{2});
    CHECK(list_radii({row(all, all, std::nullopt, 3, 500)}, 100) == std::vector<int>{1});
    CHECK(list_radii({row(all, all, std::nullopt, 3, 500)}, 0.25) == std::vector<int>{6});
    const Filters chain(7, row(all, all, std::nullopt, 6, 500));
    CHECK(measure_margin(chain, 1) == kMaxMargin);
    CHECK(list_radii(chain, 1) == std::vector<int>{4, 4, 4, 3, 3, 3, 3});
    const auto roofs = bits({Material::kGreyRoof, Material::kFlatRoof});
    CHECK(measure_margin(
              {row(all, all, std::nullopt, 6, 500), row(roofs, roofs, std::nullopt, 5, 500)},
              1) == 6);  // they do not read each other
    CHECK(measure_margin({}, 1) == 0);
    for (const double voxel_m : {0.1, 0.25, 0.5, 1.0, 2.0, 10.0}) {
        const Filters shipped = load_filters("default");
        CHECK(shipped.size() >= 7);
        CHECK(measure_margin(shipped, voxel_m) >= 1);
        CHECK(measure_margin(shipped, voxel_m) <= kMaxMargin);
    }
}

TEST_CASE("filters do what their definition says, in any patch that is cut out of a landscape",
          "[voxelserver][imagery][filters][property]") {
    const auto seed = GENERATE(take(1, random(0U, 1'000'000U)));
    INFO("seed " << seed);
    std::mt19937 numbers(seed);
    for (int i = 0; i < 20; ++i) {
        const Filters filters = i == 0 ? load_filters("default") : random_filters(numbers);
        const double voxel_m = std::array{0.25, 0.5, 1.0, 2.0}[numbers() % 4];
        const int margin = measure_margin(filters, voxel_m);
        const int side = 60 + 2 * margin;
        const Grid land = random_grid(side, side, margin, numbers);
        const Grid whole = by_definition(land, filters, voxel_m);
        for (int crop = 0; crop < 6; ++crop) {
            const int extra =
                static_cast<int>(numbers() % 3);  // a margin wider than required changes nothing
            const int w = 1 + static_cast<int>(numbers() % 50) + 2 * (margin + extra);
            const int h = 1 + static_cast<int>(numbers() % 50) + 2 * (margin + extra);
            const int x0 = static_cast<int>(numbers() % static_cast<unsigned>(side - w + 1));
            const int z0 = static_cast<int>(numbers() % static_cast<unsigned>(side - h + 1));
            Grid part{w, h, margin + extra, {}, {}};
            for (int z = 0; z < h; ++z)
                for (int x = 0; x < w; ++x) {
                    const auto at = static_cast<std::size_t>((z0 + z) * side + x0 + x);
                    part.material.push_back(land.material[at]);
                    part.flags.push_back(land.flags[at]);
                }
            apply_filters(part, filters, voxel_m);
            int wrong = 0;
            for (int z = part.margin; z < h - part.margin; ++z)
                for (int x = part.margin; x < w - part.margin; ++x)
                    wrong += part.material[static_cast<std::size_t>(z * w + x)] !=
                             whole.material[static_cast<std::size_t>((z0 + z) * side + x0 + x)];
            INFO("landscape " << i << ", crop " << x0 << " " << z0 << " " << w << " x " << h
                              << ", margin " << margin);
            REQUIRE(wrong == 0);
        }
    }
}

TEST_CASE("a bad filter is refused, naming file, field, value and what is allowed",
          "[voxelserver][imagery][filters][bad]") {
    struct Case {
        const char* name;
        std::string text;
        const char* message;
    };
    const std::string a = "name = \"a\"\n";
    const std::string roads = a + "of = [\"road\"]\n";
    const std::string by_roads = roads + "by = [\"road\"]\n";
    const std::string majority = by_roads + "to = \"majority\"\n";
    const auto c = GENERATE_COPY(values<Case>({
        {"no name", "of = [\"road\"]", "row 1 name is missing"},
        {"no of", a + "by = [\"road\"]", "'a' of is missing or empty"},
        {"no by", roads, "'a' by is missing or empty"},
        {"bad to", by_roads + "to = \"most\"", "'a' to = 'most'"},
        {"no radius", majority + "at_least = 0.5", "'a' radius_m is missing"},
        {"bad radius", majority + "at_least = 0.5\nradius_m = 99",
         "'a' radius_m = 99; allowed: 0.1 to 20"},
        {"bad share", majority + "at_least = 50\nradius_m = 2",
         "'a' at_least = 50; allowed: 0.001 to 1"},
        {"both shares", roads + "to = \"ground\"\nat_least = 0.5\nat_most = 0.1\nradius_m = 2",
         "'a' at_most goes without"},
        {"misspelt", a + "radius = 2",
         "radius is no field; allowed: name, of, by, to, radius_m, at_least, at_most"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "test.toml";
        std::ofstream(file) << "[[filter]]\n" << c.text << "\n";
        CHECK_THROWS_WITH(load_filters(file.string()),
                          contains("test.toml") && contains(c.message));
    }
}
