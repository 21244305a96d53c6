#include "raytracer/core/output/lettering.hpp"

#include <set>

#include "raytracer/core/output/image_writer.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/core/output/picture_reader.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

constexpr const char* kCredit =
    "© ARSO, Geodetska uprava Republike Slovenije 2023 (CC BY 4.0): Škofja Loka, Črnomelj, Žiri, "
    "Bohinj, Füssen, Zürich";

}  // namespace

TEST_CASE("every letter that attributions need has a look of its own",
          "[raytracer][output][credit]") {
    std::set<std::pair<int, std::array<std::uint8_t, output::Glyph::kRows>>> looks;
    std::u32string letters = U"čČšŠžŽćĆđĐéÉèêëàâäöüßÄÖÜçñåøæœłŁńśźżășțğıİőű©®°–§€«»";
    for (char32_t c = U'!'; c <= U'~'; ++c)
        letters.push_back(c);
    for (const char32_t c : letters) {
        const output::Glyph g = output::find_glyph(c);
        INFO("U+" << std::hex << static_cast<std::uint32_t>(c));
        CHECK((g.width >= 1 && g.width <= 8));
        CHECK(looks.insert({g.width, g.rows}).second);
        if (c != U'?')
            CHECK(g.rows != output::find_glyph(U'?').rows);
        for (const std::uint8_t row : g.rows)
            CHECK(row >> g.width == 0);
    }
    CHECK(output::find_glyph(U'\u4e2d').rows == output::find_glyph(U'?').rows);
    CHECK(output::find_glyph(U'\u00a0').rows == output::find_glyph(U' ').rows);
}

TEST_CASE("text is read as UTF-8, and what is not is marked", "[raytracer][output][credit]") {
    CHECK(output::to_letters("ač€") == U"ač€");
    CHECK(output::to_letters("\xf0\x9f\x98\x80") == U"\U0001f600");
    for (const char* bad :
         {"\xff", "\xc3", "\x80", "\xc0\x80", "\xed\xa0\x80", "\xf8\x88\x80\x80\x80", "\xe2\x82"}) {
        const auto letters = output::to_letters(bad);
        CHECK(letters.front() == U'\ufffd');
        CHECK(letters.size() == std::string(bad).size());
    }
    CHECK(output::to_letters("").empty());
}

TEST_CASE("a credit can be read on any ground and touches nothing else",
          "[raytracer][output][credit]") {
    const float ground = GENERATE(0.0f, 0.5f, 1.0f);
    INFO(ground);
    const output::CreditLine credit(kCredit, 1280, 720);
    float darkest = 1;
    float lightest = 0;
    int touched = 0;
    int wrong = 0;
    int x0 = 1280;
    int y0 = 720;
    for (int y = 0; y < 720; ++y)
        for (int x = 0; x < 1280; ++x) {
            const voxel::Colour c = credit.over({ground, ground, ground}, x, y);
            if (!credit.covers(x, y))
                wrong += c.r != ground ? 1 : 0;
            else {
                ++touched;
                x0 = std::min(x0, x);
                y0 = std::min(y0, y);
                darkest = std::min(darkest, c.r);
                lightest = std::max(lightest, c.r);
            }
        }
    CHECK(wrong == 0);
    CHECK(lightest - darkest > 0.6f);
    CHECK(touched > 1000);
    CHECK(touched < 1280 * 720 / 50);
    CHECK(x0 > 1280 / 4);
    CHECK(y0 > 720 * 9 / 10);
}

TEST_CASE(
    "a credit that is too long goes on in the next line, and a picture that is too small has none",
    "[raytracer][output][credit]") {
    const auto find_height = [](const char* text, int width, int height) {
        const output::CreditLine credit(text, width, height);
        int rows = 0;
        for (int y = 0; y < height; ++y) {
            bool any = false;
            for (int x = 0; x < width; ++x)
                any = any || credit.covers(x, y);
            rows += any ? 1 : 0;
        }
        return rows;
    };
    CHECK(find_height("ARSO", 320, 180) < 20);
    CHECK(find_height(kCredit, 320, 180) > 2 * find_height("ARSO", 320, 180));
    CHECK(find_height(
              "Donaudampfschifffahrtselektrizitätenhauptbetriebswerkbauunterbeamtengesellschaft",
              100, 180) > 30);
    CHECK(find_height("", 320, 180) == 0);
    CHECK(find_height(" \n\t", 320, 180) == 0);
    for (int size = 1; size < 40; ++size)
        CHECK(find_height(kCredit, size, size) <= size);
}

TEST_CASE("the credit stands in 8-bit pictures alone", "[raytracer][output][credit]") {
    const TemporaryFolder folder;
    output::Film film(320, 180);
    film.add(synthetic_tile(0, 0, 320, 180, false));
    output::PictureInfo plain;
    output::PictureInfo credited;
    credited.credit = kCredit;
    const auto differs = [&](const char* name) {
        output::write_image(film, folder.path() / name, plain);
        const auto before = read_picture(folder.path() / name).pixels;
        output::write_image(film, folder.path() / name, credited);
        return std::memcmp(before.data(), read_picture(folder.path() / name).pixels.data(),
                           before.size() * sizeof(float)) != 0;
    };
    CHECK(differs("a.png"));
    CHECK(differs("a.jpg"));
    CHECK_FALSE(differs("a.exr"));
    CHECK_FALSE(differs("a.tif"));
}
