#include "raytracer/core/output/image_writer.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <string>

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/picture_file.hpp"
#include "tests/catch.hpp"
#include "tests/common/full_disk.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/core/output/picture_reader.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;
using namespace std::string_literals;

namespace {

/// A picture with nothing known but these.
void write_plain(const output::Film& film, const std::filesystem::path& file, double exposure_ev,
                 core::ToneCurve tone, const output::ImageMetadata& metadata) {
    output::PictureInfo info;
    info.exposure_ev = exposure_ev;
    info.tone = tone;
    info.metadata = metadata;
    output::write_image(film, file, info);
}

constexpr int kImageWidth = 61;
constexpr int kImageHeight = 37;

output::Film make_film(int width, int height) {
    std::mt19937 random(21);
    std::uniform_real_distribution<float> value(0, 4);
    tiles::TileResult all;
    all.tile.x1 = width;
    all.tile.y1 = height;
    for (int i = 0; i < width * height; ++i)
        all.samples.push_back(
            {{value(random), value(random) * 1e-5f, value(random) * 1e4f},
             i % 5 / 4.0f,
             i % 7 == 0 ? std::numeric_limits<float>::infinity() : value(random) * 1000});
    output::Film film(width, height);
    film.add(all);
    return film;
}

const output::ImageMetadata kMetadata = {{"Software", "terravox test"},
                                         {"terravox:holes", "3"},
                                         {"terravox:camera", "1.5 2.5 3.5"},
                                         {"ImageDescription", "Škofja Loka"},
                                         {"Copyright", "ARSO, CC BY 4.0"}};

}  // namespace

TEST_CASE("EXR and TIFF give back every value to the last bit", "[raytracer][output]") {
    const std::string ending = GENERATE(".exr", ".EXR", ".tif", ".tiff");
    INFO(ending);
    const TemporaryFolder folder;
    const auto file = folder.path() / ("picture" + ending);
    const output::Film film = make_film(kImageWidth, kImageHeight);
    write_plain(film, file, 3, core::ToneCurve::kPhotographic,
                kMetadata);  // exposure and tone are for 8-bit pictures
    const PictureFile back = read_picture(file);
    const bool exr = back.channels.size() == 5;
    CHECK(exr == (ending == ".exr" || ending == ".EXR"));
    REQUIRE(back.width == kImageWidth);
    REQUIRE(back.height == kImageHeight);
    REQUIRE(back.channels.size() == (exr ? 5 : 4));
    int wrong = 0;
    for (int y = 0; y < kImageHeight; ++y)
        for (int x = 0; x < kImageWidth; ++x) {
            const tiles::PixelSample& p = film.at(x, y);
            wrong += same_bits(back.at(x, y, back.channel("R")), p.colour.r) &&
                             same_bits(back.at(x, y, back.channel("G")), p.colour.g) &&
                             same_bits(back.at(x, y, back.channel("B")), p.colour.b)
                         ? 0
                         : 1;
            wrong += same_bits(back.at(x, y, back.channel("A")), p.alpha) ? 0 : 1;
            if (exr)
                wrong += same_bits(back.at(x, y, back.channel("Z")), p.depth_m) ? 0 : 1;
        }
    CHECK(wrong == 0);
    if (exr)
        CHECK(back.channels[back.channel("Z")].type == "float");
    CHECK(back.channels.front().type == "float");
    CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("PNG holds the developed colours, dithered to the byte below or above",
          "[raytracer][output]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "picture.png";
    const auto tone = GENERATE(core::ToneCurve::kPhotographic, core::ToneCurve::kFilmic,
                               core::ToneCurve::kAgx, core::ToneCurve::kLinear);
    const double exposure = GENERATE(-2.0, 0.0, 1.5);
    const output::Film film = make_film(kImageWidth, kImageHeight);
    write_plain(film, file, exposure, tone, {});
    const PictureFile back = read_picture(file);
    REQUIRE(back.channels.size() == 3);
    CHECK(back.channels.front().type == "uint8");
    double worst = 0;
    for (int y = 0; y < kImageHeight; ++y)
        for (int x = 0; x < kImageWidth; ++x) {
            const voxel::Colour c = output::develop(film.at(x, y).colour, exposure, tone);
            for (int k = 0; k < 3; ++k)
                worst = std::max(
                    worst,
                    std::abs(static_cast<double>(back.at(x, y, static_cast<std::size_t>(k))) -
                             (k == 0   ? c.r
                              : k == 1 ? c.g
                                       : c.b)));
        }
    CHECK(worst <= 1.0 / 255 + 1e-6);
}

TEST_CASE("texts of strangers fit into every format, and hide nothing", "[raytracer][output]") {
    const std::string ending = GENERATE(".exr", ".png", ".tif", ".jpg");
    INFO(ending);
    const TemporaryFolder folder;
    const auto file = folder.path() / ("picture" + ending);
    // A byte of 0, a colour of a terminal, Latin-1, and what looks like the header of an EXR file.
    const std::string hostile = "a\0b\x1b[31m \xa9 terravox:holes\0string\0................"s;
    write_plain(make_film(8, 8), file, 0, core::ToneCurve::kPhotographic,
                {{"Copyright", hostile}, {"ImageDescription", std::string(100'000, 'x') + "é"}});
    const PictureFile back = read_picture(file);
    CHECK_THAT(back.text("Copyright"),
               contains("a\\x00b\\x1b[31m \\xa9 terravox:holes\\x00string\\x00...."));
    CHECK(back.text("ImageDescription").substr(0, 16384) == std::string(16384, 'x'));
}

TEST_CASE("an ending that names no format is refused before any work", "[raytracer][output]") {
    const TemporaryFolder folder;
    const std::string name =
        GENERATE("picture", "picture.", "picture.bmp", "picture.png.gz", ".png", "picture.exr ");
    INFO("'" << name << "'");
    CHECK_THROWS_AS(output::check_image_target(folder.path() / name, 4, 3), util::UsageError);
    CHECK_THROWS_WITH(output::check_image_target(folder.path() / name, 4, 3),
                      contains("allowed: .png .jpg ") && contains(" (8-bit), .exr .tif ") &&
                          contains(" (float)"));
    CHECK(entries_in(folder.path()) == 0);
}

TEST_CASE("a picture that its format cannot hold is refused before any work",
          "[raytracer][output]") {
    const TemporaryFolder folder;
    struct Case {
        const char* file;
        int width_px;
        int height_px;
        const char* allowed;
    };
    const auto c = GENERATE(values<Case>({{"a.jpg", 65501, 2, "sides up to 65500"},
                                          {"a.JPEG", 2, 65501, "sides up to 65500"},
                                          {"a.tga", 65536, 2, "sides up to 65535"},
                                          {"a.png", 50'000, 20'000, "up to 715827882 in all"}}));
    DYNAMIC_SECTION(c.file) {
        const auto file = folder.path() / c.file;
        CHECK_THROWS_WITH(output::check_image_target(file, c.width_px, c.height_px),
                          contains(c.allowed));
        CHECK_NOTHROW(output::check_image_target(file, 65500, 2));
        CHECK_NOTHROW(output::check_image_target(folder.path() / "a.tif", c.width_px, c.height_px));
    }
}

TEST_CASE("a JPEG holds the developed colours, and texts with a place in Exif",
          "[raytracer][output]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "picture.jpg";
    output::Film film(64, 48);
    tiles::TileResult all;
    all.tile.x1 = 64;
    all.tile.y1 = 48;
    all.samples.assign(std::size_t{64} * 48, {{0.2f, 0.4f, 0.1f}, 1, 10});
    film.add(all);
    write_plain(film, file, 0, core::ToneCurve::kLinear, kMetadata);
    const PictureFile back = read_picture(file);
    REQUIRE(back.names() == std::vector<std::string>{"R", "G", "B"});
    const voxel::Colour c = output::develop({0.2f, 0.4f, 0.1f}, 0, core::ToneCurve::kLinear);
    CHECK(back.at(30, 20, "R") == Approx(c.r).margin(0.02));
    CHECK(back.at(30, 20, "G") == Approx(c.g).margin(0.02));
    CHECK(back.at(30, 20, "B") == Approx(c.b).margin(0.02));
    CHECK(back.text("Software") == "terravox test");
    CHECK(back.text("Copyright") == "ARSO, CC BY 4.0");
    CHECK(back.text("ImageDescription") == "Škofja Loka");
    CHECK(back.text("ColorSpace") == "1");
    CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("what OpenImageIO writes besides holds the picture", "[raytracer][output]") {
    struct Case {
        const char* ending;
        bool has_floats;
        double margin;
    };
    const auto c = GENERATE(values<Case>({{".dpx", false, 0},
                                          {".hdr", true, 1.0 / 128},
                                          {".jxl", false, 0.02},
                                          {".tga", false, 0},
                                          {".TGA", false, 0},
                                          {".webp", false, 0.02}}));
    DYNAMIC_SECTION(c.ending) {
        const TemporaryFolder folder;
        const auto file = folder.path() / ("picture"s + c.ending);
        if (!output::can_encode(util::lower_extension(file))) {
            CHECK_THROWS_AS(output::check_image_target(file, 64, 48), util::UsageError);
            return;
        }
        output::check_image_target(file, 64, 48);
        output::Film film(64, 48);
        tiles::TileResult all;
        all.tile.x1 = 64;
        all.tile.y1 = 48;
        all.samples.assign(std::size_t{64} * 48, {{0.2f, 0.4f, 0.1f}, 1, 10});
        film.add(all);
        write_plain(film, file, 0, core::ToneCurve::kLinear, kMetadata);
        const PictureFile back = read_picture(file);
        REQUIRE(back.names() == std::vector<std::string>{"R", "G", "B"});
        const auto png = folder.path() / "picture.png";
        write_plain(film, png, 0, core::ToneCurve::kLinear, {});
        const PictureFile bytes = read_picture(png);
        for (std::size_t k = 0; k < 3; ++k) {
            const double given = std::array{0.2, 0.4, 0.1}[k];
            CHECK(back.at(30, 20, k) ==
                  Approx(c.has_floats ? given : bytes.at(30, 20, k)).margin(c.margin));
        }
        std::ifstream first(file, std::ios::binary);
        const std::string written(std::istreambuf_iterator<char>(first), {});
        write_plain(film, file, 0, core::ToneCurve::kLinear, kMetadata);
        std::ifstream second(file, std::ios::binary);
        CHECK((std::string(std::istreambuf_iterator<char>(second), {}) == written));
        CHECK(entries_in(folder.path()) == 2);
    }
}

TEST_CASE("a place that cannot be written to leaves nothing behind", "[raytracer][output]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "file") << "in the way";
    fs::create_directory(folder.path() / "picture.png");
    struct Case {
        const char *name, *target;
    };
    const auto c = GENERATE(values<Case>(
        {{"a file as the folder", "file/picture.png"}, {"a folder of that name", "picture.png"}}));
    DYNAMIC_SECTION(c.name) {
        CHECK_THROWS_AS(output::check_image_target(folder.path() / c.target, 4, 3), util::Error);
        CHECK_THROWS_AS(write_plain(make_film(8, 8), folder.path() / c.target, 0,
                                    core::ToneCurve::kPhotographic, {}),
                        util::Error);
        CHECK(entries_in(folder.path()) == 2);
    }
}

TEST_CASE("an older picture stays whole when a new one cannot be finished", "[raytracer][output]") {
    // The disk is full: a limit on the size of files, whose writes fail with EFBIG.
    const std::string ending =
        GENERATE(".exr", ".png", ".tif", ".jpg", ".dpx", ".hdr", ".tga", ".webp");
    INFO(ending);
    const TemporaryFolder folder;
    const auto file = folder.path() / ("picture" + ending);
    std::ofstream(file) << "older";
    const output::Film film = make_film(400, 300);
    const auto good = folder.path() / ("good" + file.extension().string());
    write_plain(film, good, 0, core::ToneCurve::kPhotographic, {});
    const auto whole = static_cast<rlim_t>(std::filesystem::file_size(good));
    std::filesystem::remove(good);
    // The last bytes of a file are written when it is closed, which libraries are careless about.
    const rlim_t room = GENERATE_COPY(rlim_t{20'000}, whole / 2, whole * 99 / 100, whole - 1);
    CAPTURE(room, whole);
    std::string said;
    {
        const FullDisk full(room);
        try {
            write_plain(film, file, 0, core::ToneCurve::kPhotographic, {});
        } catch (const util::Error& e) {
            said = e.what();
        }
    }
    CHECK_THAT(said, contains("write") && contains("picture"));
    CHECK(said.find('\n') == std::string::npos);
    CHECK(entries_in(folder.path()) == 1);
    std::ifstream in(file, std::ios::binary);
    CHECK((std::string(std::istreambuf_iterator<char>(in), {}) == "older"));
}

TEST_CASE("a plain TIFF is 8-bit on request", "[raytracer][output]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "picture.tif";
    const auto png = folder.path() / "picture.png";
    output::PictureInfo info;
    info.tiff_samples = core::TiffSamples::kByte;
    info.tone = core::ToneCurve::kAgx;
    info.exposure_ev = 0.5;
    const output::Film film = make_film(kImageWidth, kImageHeight);
    output::write_image(film, file, info);
    output::write_image(film, png, info);
    const PictureFile back = read_picture(file);
    CHECK(back.channels.front().type == "uint8");
    CHECK(back.pixels == read_picture(png).pixels);
}

TEST_CASE("a coarse sample stands for its block until finer ones replace it",
          "[raytracer][output][film]") {
    output::Film film(5, 3);
    tiles::TileResult coarse;
    coarse.tile.x1 = 5;
    coarse.tile.y1 = 3;
    coarse.tile.step = 4;
    coarse.samples = {{{1, 0, 0}, 1, 10}, {{2, 0, 0}, 1, 20}};
    film.add(coarse);
    CHECK(film.at(0, 0).colour.r == 1);
    CHECK(film.at(3, 2).colour.r == 1);
    CHECK(film.at(4, 2).colour.r == 2);
    tiles::TileResult finer;
    finer.tile.x1 = 5;
    finer.tile.y1 = 3;
    finer.tile.step = 2;
    finer.tile.refines = true;
    finer.tile.each_pixel([&](int x, int y) {
        finer.samples.push_back({{static_cast<float>(10 + x + 10 * y), 0, 0}, 1, 1});
    });
    film.add(finer);
    CHECK(film.at(0, 0).colour.r == 1);
    CHECK(film.at(1, 1).colour.r == 1);
    CHECK(film.at(2, 0).colour.r == 12);
    CHECK(film.at(3, 1).colour.r == 12);
    CHECK(film.at(0, 2).colour.r == 30);
    CHECK(film.at(4, 0).colour.r == 2);
}
