#include "raytracer/core/output/credit_line.hpp"

#include <set>

#include "common/util/utf8.hpp"
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

/// What a credit makes of a small black picture.
std::vector<float> look(std::string_view text) {
    constexpr int kSide = 120;
    const output::CreditLine credit(text, kSide, kSide);
    std::vector<float> out;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            out.push_back(credit.over({}, x, y).r);
    return out;
}

}  // namespace

TEST_CASE("every letter that attributions need has a look of its own",
          "[raytracer][output][credit]") {
    std::set<std::vector<float>> looks;
    std::string_view letters =
        "čČšŠžŽćĆđĐéÉèêëàâäöüßÄÖÜçñåøæœłŁńśźżșțğıİőű©®°–§€«»"
        "ΔΩλψЖдфяґ"
        "!\"#$%&'()*+,-./"
        "0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`abcdefghijklmnopqrstuvwxyz"
        "{|}~";
    while (!letters.empty()) {
        const std::string_view one = letters.substr(0, util::first_character(letters).bytes);
        INFO(one);
        CHECK(looks.insert(look(one)).second);
        letters.remove_prefix(one.size());
    }
}

TEST_CASE("letters that cannot be set are named before and while a picture is made",
          "[raytracer][output][credit]") {
    struct Case {
        const char* name;
        const char* text;
        const char* said;
    };
    for (const Case& c : {Case{"not of the font", "Survey of 國土", "'國' (U+570B)"},
                          Case{"from right to left", "הסקר", "'ה' (U+05D4)"}}) {
        INFO(c.name);
        CHECK_THROWS_WITH(output::CreditLine(c.text, 320, 180), contains(c.said));
        CHECK_THROWS_WITH(output::check_credit(c.text), contains(c.said));
    }
    CHECK_NOTHROW(output::check_credit(kCredit));
    CHECK_NOTHROW(output::check_credit(""));
}

TEST_CASE("what is no text in a credit becomes visible, and a line break a space",
          "[raytracer][output][credit]") {
    CHECK(look("a\xff\u202e") == look("a\\xff\\u202e"));
    CHECK(look("a\nb") == look("a b"));
    CHECK(look("a\u00a0b") == look("a b"));
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
