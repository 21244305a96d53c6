#include "voxelserver/data/imagery/colour_map.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/data/imagery/palette_file.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::imagery;
using voxel::Material;
using voxel::Rgb8;

namespace {

/// A palette in a folder of its own.
class Palette {
public:
    explicit Palette(const std::string& text) { write("test.toml", text); }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream(m_folder.path() / name) << text;
    }
    [[nodiscard]] std::string path() const { return (m_folder.path() / "test.toml").string(); }
    [[nodiscard]] ColourMap load() const { return ColourMap::load(path()); }

private:
    TemporaryFolder m_folder;
};

const char* const kSmall = R"(
space = "rgb"
[candidates]
ground = ["grass", "road", "water"]
building = ["grey_roof"]
[[ndvi]]
above = 0.3
forbids = ["road", "water"]
[[ndvi]]
below = -0.2
darker_than = 40
only = ["water"]
[[entry]]
material = "grass"
colour = "#408040"
[[entry]]
material = "road"
colour = "#808080"
[[entry]]
material = "water"
colour = "#204060"
[[entry]]
material = "grey_roof"
colour = "#707070"
)";

/// CIELAB by the C library: the check on to_lab's own arithmetic.
Lab lab_by_libm(Rgb8 c) {
    const auto linear = [](int v) {
        return v <= 10 ? v / 255.0 / 12.92 : std::pow((v / 255.0 + 0.055) / 1.055, 2.4);
    };
    const double r = linear(c.r);
    const double g = linear(c.g);
    const double b = linear(c.b);
    const auto f = [](double t) {
        return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
    };
    const double x = f((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
    const double y = f(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
    const double z = f((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

/// The nearest entry of config/palettes/default.toml by trying all of them.
Material nearest_by_trying(Rgb8 colour, MaterialSet candidates, double& lead) {
    static const auto files = read_palette("default");
    double best = 1e300;
    double other = 1e300;
    Material out = Material::kAir;
    const Lab p = lab_by_libm(colour);
    for (const auto* row : files.back().rows("entry")) {
        const Material m = *voxel::material_from_name((*row)["material"].value_or(std::string()));
        if ((candidates & to_bit(m)) == 0)
            continue;
        const auto v = std::stoul((*row)["colour"].value_or(std::string()).substr(1), nullptr, 16);
        const Lab q = lab_by_libm({static_cast<std::uint8_t>(v >> 16),
                                   static_cast<std::uint8_t>(v >> 8 & 255),
                                   static_cast<std::uint8_t>(v & 255)});
        const double w = files.back().root()["lightness_weight"].value_or(1.0);
        const double d = std::hypot(w * (p.l - q.l), p.a - q.a, p.b - q.b);
        if (d < best) {
            if (m != out)
                other = best;
            best = d;
            out = m;
        } else if (m != out)
            other = std::min(other, d);
    }
    lead = other - best;
    return out;
}

}  // namespace

TEST_CASE("sRGB becomes CIELAB", "[voxelserver][imagery][colour]") {
    struct Case {
        Rgb8 colour;
        Lab lab;  ///< as published for sRGB and D65
    };
    for (const Case& c :
         {Case{{255, 255, 255}, {100, 0, 0}}, Case{{0, 0, 0}, {0, 0, 0}},
          Case{{255, 0, 0}, {53.24, 80.09, 67.20}}, Case{{0, 255, 0}, {87.73, -86.18, 83.18}},
          Case{{0, 0, 255}, {32.30, 79.19, -107.86}}, Case{{119, 119, 119}, {50.03, 0, 0}}}) {
        const Lab lab = to_lab(c.colour);
        INFO(int{c.colour.r} << " " << int{c.colour.g} << " " << int{c.colour.b});
        CHECK(lab.l == Approx(c.lab.l).margin(0.02));
        CHECK(lab.a == Approx(c.lab.a).margin(0.02));
        CHECK(lab.b == Approx(c.lab.b).margin(0.02));
    }
}

TEST_CASE("CIELAB and cube roots need no C library, and agree with it",
          "[voxelserver][imagery][colour]") {
    double worst = 0;
    double worst_root = 0;
    for (int r = 0; r < 256; r += 5)
        for (int g = 0; g < 256; g += 5)
            for (int b = 0; b < 256; b += 5) {
                const Rgb8 c{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
                             static_cast<std::uint8_t>(b)};
                const Lab mine = to_lab(c);
                const Lab other = lab_by_libm(c);
                worst = std::max({worst, std::abs(mine.l - other.l), std::abs(mine.a - other.a),
                                  std::abs(mine.b - other.b)});
            }
    CHECK(worst < 2e-3);  // the published white has five digits
    for (double x = 1e-6; x < 2; x *= 1.0007)
        worst_root = std::max(worst_root, std::abs(cube_root(x) / std::cbrt(x) - 1));
    CHECK(worst_root < 1e-12);
}

TEST_CASE("the nearest entry is the one that trying them all finds",
          "[voxelserver][imagery][colour][property]") {
    const ColourMap map = ColourMap::load("default");
    CHECK(map.entry_count() >= 40);
    const auto seed = GENERATE(take(1, random(0U, 1'000'000U)));
    INFO("seed " << seed);
    std::mt19937 random_numbers(seed);
    int compared = 0;
    for (int i = 0; i < 20'000; ++i) {
        const auto bits = random_numbers();
        const Rgb8 c{static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                     static_cast<std::uint8_t>(bits >> 16)};
        const Group group =
            std::array{Group::kGround, Group::kDryGround, Group::kBuilding}[(bits >> 24) % 3];
        double lead = 0;
        const Material expected = nearest_by_trying(c, map.candidates(group), lead);
        if (lead < 0.05)
            continue;  // as good as equal: places are rounded to 1/64
        ++compared;
        if (map.nearest(c, group) == expected)
            continue;
        INFO("colour " << int{c.r} << " " << int{c.g} << " " << int{c.b});
        REQUIRE(map.nearest(c, group) == expected);
    }
    CHECK(compared > 19'000);
}

TEST_CASE("the group limits what a colour can mean", "[voxelserver][imagery][colour]") {
    const ColourMap map = Palette(kSmall).load();
    CHECK(map.nearest({60, 120, 60}, Group::kGround) == Material::kGrass);
    CHECK(map.nearest({60, 120, 60}, Group::kBuilding) == Material::kGreyRoof);
    CHECK(map.nearest({60, 120, 60}, Group::kVegetation) == Material::kAir);
    CHECK(map.nearest({60, 120, 60}, Group::kNone) == Material::kAir);
}

TEST_CASE("near infrared rules out what cannot be", "[voxelserver][imagery][colour]") {
    CHECK(ndvi(200, 100) == Approx(1.0 / 3));
    CHECK(ndvi(0, 200) == -1.0F);
    CHECK(ndvi(0, 0) == 0.0F);
    const ColourMap map = Palette(kSmall).load();
    const Rgb8 grey{128, 128, 128};
    const Rgb8 dark{50, 50, 50};
    CHECK(map.nearest(grey, Group::kGround, kNoNdvi) == Material::kRoad);
    CHECK(map.nearest(grey, Group::kGround, 0.1F) == Material::kRoad);
    CHECK(map.nearest(grey, Group::kGround, 0.5F) == Material::kGrass);
    CHECK(map.nearest(grey, Group::kGround, -0.5F) == Material::kRoad);  // too bright for water
    CHECK(map.nearest(dark, Group::kGround, -0.5F) == Material::kWater);
    CHECK(map.nearest(grey, Group::kBuilding, 0.5F) ==
          Material::kGreyRoof);  // a rule that leaves a group nothing does not hold for it
    CHECK(map.by_ndvi(Group::kGround, 0.5F) == Material::kGrass);
    CHECK(map.by_ndvi(Group::kGround, -0.5F) == Material::kAir);  // how dark it is, is not known
    CHECK(map.by_ndvi(Group::kGround, kNoNdvi) == Material::kAir);
}

TEST_CASE("a palette extends another", "[voxelserver][imagery][colour]") {
    const Palette palette("extends = \"base\"\n[candidates]\nground = [\"road\"]\n");
    palette.write("base.toml", kSmall);
    const ColourMap map = palette.load();
    CHECK(map.nearest({60, 120, 60}, Group::kGround) == Material::kRoad);
    CHECK(map.nearest({60, 120, 60}, Group::kBuilding) == Material::kGreyRoof);
    CHECK(ColourMap::load("paper-rgb").entry_count() >= 40);
}

TEST_CASE("a palette of one's own extends one next to it, else one that ships with the program",
          "[voxelserver][imagery][colour]") {
    const Palette palette("extends = \"paper-rgb\"\n");
    CHECK(palette.load().entry_count() == ColourMap::load("paper-rgb").entry_count());
    const auto files = read_palette(palette.path());
    REQUIRE(files.size() == 3);  // paper-rgb extends default
    CHECK(files.front().path().stem() == "default");
    palette.write("default.toml", kSmall);
    palette.write("test.toml", "extends = \"default\"\n");
    CHECK(palette.load().entry_count() == 4);
}

TEST_CASE("a bad palette is refused, naming file, field, value and what is allowed",
          "[voxelserver][imagery][colour][bad]") {
    struct Case {
        const char* name;
        std::string text;
        std::string message;
    };
    const std::string entries =
        "[candidates]\nground = [\"road\"]\n[[entry]]\nmaterial = \"road\"\ncolour = \"#808080\"\n";
    const auto c = GENERATE_COPY(values<Case>({
        {"no TOML", "space = \n", "line 1"},
        {"space", "space = \"hsv\"\n", "space = 'hsv'; allowed: cielab, rgb"},
        {"weight", "lightness_weight = 9\n", "lightness_weight = 9; allowed: 0.05 to 4"},
        {"weight as text", "lightness_weight = \"1\"\n",
         "lightness_weight is not a number; allowed: 0.05 to 4"},
        {"colour", "[[entry]]\nmaterial = \"road\"\ncolour = \"#80808\"\n",
         "[[entry]] row 1 colour = '#80808'; allowed: \"#rrggbb\""},
        {"colour with a sign", "[[entry]]\nmaterial = \"road\"\ncolour = \"#-80808\"\n",
         "colour = '#-80808'"},
        {"material", "[[entry]]\nmaterial = \"gold\"\ncolour = \"#808080\"\n",
         "[[entry]] row 1 material = 'gold'; allowed: a material"},
        {"air", "[[entry]]\nmaterial = \"air\"\ncolour = \"#808080\"\n", "material = 'air'"},
        {"candidate", "[candidates]\nground = [\"gold\"]\n", "[candidates] ground = 'gold'"},
        {"candidates no list", "[candidates]\nground = \"road\"\n",
         "[candidates] ground is not a list"},
        {"candidate without an entry",
         "[candidates]\nground = [\"road\", \"sand\"]\n[[entry]]\nmaterial = \"road\"\ncolour = "
         "\"#808080\"\n",
         "names 'sand'"},
        {"no candidates", "title = \"x\"\n", "[candidates] is missing or empty"},
        {"misspelt", "spacing = 1\n", "spacing is no field; allowed: title"},
        {"misspelt in a row", entries + "[[ndvi]]\nabowe = 1\n",
         "[[ndvi]] row 1 abowe is no field"},
        {"index", entries + "[[ndvi]]\nabove = 3\nonly = [\"road\"]\n",
         "[[ndvi]] row 1 above = 3; allowed: -1 to 1"},
        {"rule without effect", entries + "[[ndvi]]\nabove = 0.3\n", "needs one of: only, forbids"},
        {"entries no tables", "entry = 3\n", "entry is no list of tables; allowed: [[entry]]"},
        {"circle", "extends = \"test\"\n", "is circular"},
        {"base", "extends = \"nothing\"\n",
         "extends = 'nothing'; allowed: a palette next to it, or default, paper-rgb"},
        {"base", "extends = 3\n", "extends is no text"},
    }));
    DYNAMIC_SECTION(c.name) {
        const Palette palette(c.text);
        CHECK_THROWS_WITH(palette.load(), contains("test.toml") && contains(c.message));
    }
    CHECK_THROWS_AS(ColourMap::load("no-such-palette"), util::UsageError);
    CHECK_THROWS_WITH(ColourMap::load("no-such-palette"), contains("allowed: default, paper-rgb"));
    CHECK_THROWS_WITH(ColourMap::load("/nowhere/x.toml"), contains("no such file"));
}
