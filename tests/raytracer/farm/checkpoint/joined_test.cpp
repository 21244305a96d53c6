#include "raytracer/farm/render/joined_pictures.hpp"

#include <fstream>

#include "common/util/error.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/core/output/picture_reader.hpp"
#include "tests/raytracer/farm/checkpoint/small_picture.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;
using enum farm::Checkpoint::Existing;

namespace {

std::string read_file_bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

fs::path write(const TemporaryFolder& folder, const std::string& name,
               const std::vector<tiles::TileResult>& tiles,
               const farm::PictureKey& key = small_key()) {
    farm::Checkpoint checkpoint(folder.path() / name, key, kResume);
    for (const tiles::TileResult& tile : tiles)
        checkpoint.add(tile);
    checkpoint.close();
    return folder.path() / name;
}

std::vector<tiles::TileResult> some(const std::vector<tiles::TileResult>& tiles,
                                    std::initializer_list<std::size_t> which) {
    std::vector<tiles::TileResult> out;
    for (const std::size_t i : which)
        out.push_back(tiles[i]);
    return out;
}

/// A coordinator's run of a part.
fs::path render_part(const fs::path& file, Job& job, const farm::Part& part) {
    const scene::Scene& scene = job.view.scene;
    const auto [width, height] = scene.output.size_px;
    farm::Checkpoint checkpoint(file, farm::to_key(scene, job.world->info(), {"landscape"}),
                                kResume);
    processors::ThreadProcessor processor(job.view, job.blocks, 2);
    const int edge = scene.quality.tile.in_picture(width);
    const auto passes = tiles::plan_tiles(
        width, height, 1, edge,
        part.index % 2 == 0 ? core::TileOrder::kHilbert : core::TileOrder::kSpiral);
    for (const tiles::RenderTile& tile : passes.front())
        if (part.has(static_cast<std::uint32_t>(tile.x0 / edge),
                     static_cast<std::uint32_t>(tile.y0 / edge))) {
            processor.submit(tile);
            const auto result = processor.take();
            REQUIRE(result);
            checkpoint.add(*result);
        }
    processor.close();
    checkpoint.close();
    return file;
}

}  // namespace

TEST_CASE("parts of several coordinators make the picture of one",
          "[raytracer][checkpoint][merge]") {
    struct Case {
        const char* name;
        core::PictureLayers layers;
        std::uint32_t parts;
        std::size_t memory_mib;
    };
    const auto c =
        GENERATE(values<Case>({{"one part", core::PictureLayers::kBeauty, 1, 2048},
                               {"three parts", core::PictureLayers::kBeauty, 3, 2048},
                               {"layers", core::PictureLayers::kAll, 4, 2048},
                               {"tile by tile into the file", core::PictureLayers::kAll, 2, 0}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        scene::Scene scene = small_scene();
        scene.output.layers = c.layers;
        scene.output.exposure_ev = 0.37;
        scene.sun.strength = 1.0 / 3;
        Job job(scene);
        job.world->editable_info().attribution = "somebody";
        std::vector<fs::path> files;
        for (std::uint32_t i = 1; i <= c.parts; ++i)
            files.push_back(render_part(folder.path() / ("part" + std::to_string(i) + ".tiles"),
                                        job, {i, c.parts}));
        const farm::JoinedTiles tiles(files);
        REQUIRE(tiles.missing() == 0);

        const auto whole = folder.path() / "whole.exr", joined = folder.path() / "joined.exr",
                   whole_png = folder.path() / "whole.png",
                   joined_png = folder.path() / "joined.png";
        const output::Film film = render_scene(job, 2);
        render::RenderStatistics s;
        s.counts.samples = 2;
        for (const auto& file : {whole, whole_png})
            output::write_image(film, file,
                                render::picture_info(job.view, job.world->info(), s, false));
        std::vector<std::string> outputs{joined.string()};
        if (c.memory_mib > 0)
            outputs.push_back(joined_png.string());
        const render::PictureOptions options{c.memory_mib, 2};
        render::check_joined_pictures(tiles.key(), outputs, options);
        const render::RenderStatistics got = render::write_joined_pictures(tiles, outputs, options);
        CHECK(got.counts.tiles == tiles.key().grid.cells());
        CHECK(got.counts.trace.all_rays() > 0);
        CHECK_FALSE(got.has_holes());

        const PictureFile a = read_picture(whole), b = read_picture(joined);
        REQUIRE(a.names() == b.names());
        CHECK(std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0);
        CHECK(ExrHeader(joined).tiled == (c.memory_mib == 0));
        const std::string scene_there = b.text("terravox:scene");
        CHECK_FALSE(scene_there.empty());
        CHECK(a.text("terravox:scene") == scene_there);
        if (c.memory_mib > 0)
            CHECK((read_file_bytes(whole_png) == read_file_bytes(joined_png)));
    }
}

TEST_CASE("missing tiles are reported by their rows", "[raytracer][checkpoint][merge]") {
    const TemporaryFolder folder;
    const auto tiles = small_tiles();
    const auto a = write(folder, "a.tiles", some(tiles, {0, 1, 2, 4})),
               b = write(folder, "b.tiles", some(tiles, {3, 5, 8}));
    const farm::JoinedTiles joined({a, b});
    CHECK(joined.count() == 7);
    CHECK(joined.missing() == 2);
    CHECK(joined.rows_missing() == "3");
    CHECK(farm::JoinedTiles({a}).rows_missing() == "2, 3");
    CHECK(farm::JoinedTiles({b}).rows_missing() == "1 to 3");
    CHECK(farm::rows_missing({10, 100, 10}, [](std::uint32_t cell) {
              return cell == 3 || cell == 7;
          }) == "1 to 3, 5 to 7, 9, 10");
    CHECK(farm::rows_missing({10, 100, 10}, [](std::uint32_t) { return true; }).empty());

    const auto all = folder.path() / "all.tiles";
    joined.write(all);
    farm::Checkpoint goes_on(all, small_key(), kResume);
    CHECK(goes_on.count() == 7);
    CHECK_THAT(to_message([&] { joined.write(all); }), contains("it is there already"));
    goes_on.close();
    CHECK(goes_on.count() == 7);
}

TEST_CASE("tiles in several files must be equal", "[raytracer][checkpoint][merge]") {
    const TemporaryFolder folder;
    auto tiles = small_tiles();
    const auto a = write(folder, "a.tiles", some(tiles, {0, 4, 5}));
    for (tiles::TileResult& tile : tiles)
        tile.counts = {};  // the cost does not matter
    CHECK(farm::JoinedTiles({a, write(folder, "same.tiles", some(tiles, {4, 5, 6}))}).count() == 4);
    tiles[5].samples[7].colour.g = std::nextafter(tiles[5].samples[7].colour.g, 1e9f);
    const auto other = write(folder, "other.tiles", some(tiles, {1, 5}));
    CHECK_THAT(to_message([&] { farm::JoinedTiles({a, other}); }),
               contains("other.tiles: the tile in column 3, row 2 shows something else than in") &&
                   contains("a.tiles; one of the two is wrong"));
    // One with holes stands back, in either order.
    tiles[5].holes = {{0, 1, 2, 3}};
    const auto holed = write(folder, "holed.tiles", some(tiles, {1, 5}));
    for (const auto& files : {std::vector{a, holed}, std::vector{holed, a}}) {
        const farm::JoinedTiles joined(files);
        CHECK(joined.count() == 4);
        std::size_t holes = 0;
        joined.each([&](tiles::TileResult&& tile) { holes += tile.holes.size(); });
        CHECK(holes == 0);
    }
}

TEST_CASE("files of different pictures, and such as are being written, are not joined",
          "[raytracer][checkpoint][merge]") {
    const TemporaryFolder folder;
    const auto tiles = small_tiles();
    const auto a = write(folder, "a.tiles", some(tiles, {0}));
    scene::Scene scene = small_picture();
    scene.quality.seed = 3;
    const auto b = write(folder, "b.tiles", some(tiles, {1}),
                         farm::to_key(scene, landscape()->info(), {"test"}));
    CHECK_THAT(to_message([&] { farm::JoinedTiles({a, b}); }),
               contains("b.tiles: of another picture than") && contains("a.tiles") &&
                   contains("quality.seed = 0 there, 3 here"));
    CHECK_THAT(to_message([&] { farm::JoinedTiles({a, folder.path() / "none.tiles"}); }),
               contains("none.tiles: No such file"));
    farm::Checkpoint writing(a, small_key(), kResume);
    CHECK_THAT(to_message([&] { farm::JoinedTiles({a}); }),
               contains("a.tiles: a coordinator is writing to it"));
}

TEST_CASE("holes and damage of the parts are those of the picture",
          "[raytracer][checkpoint][merge]") {
    const TemporaryFolder folder;
    auto tiles = small_tiles();
    tiles[3].holes = {{0, 1, 2, 3}, {1, 1, 2, 3}};
    tiles[7].holes = {{0, 1, 2, 3}};
    const auto file = write(folder, "a.tiles", tiles);
    {
        farm::Checkpoint checkpoint(file, small_key(), kResume);
        checkpoint.note_damage({"x.laz: damaged"});
    }
    const auto out = folder.path() / "out.exr";
    const render::RenderStatistics s =
        render::write_joined_pictures(farm::JoinedTiles({file}), {out.string()}, {});
    CHECK(s.has_holes());
    CHECK(s.counts.holes.size() == 2);
    CHECK(s.damage == std::vector<std::string>{"x.laz: damaged"});
    const ExrHeader header(out);
    CHECK(header.attributes.at("terravox:holes").value == "2");
    CHECK(header.attributes.at("terravox:damage").value == "1");
}

TEST_CASE("pictures that cannot be written are refused before anything is",
          "[raytracer][checkpoint][merge]") {
    const TemporaryFolder folder;
    const auto file = write(folder, "a.tiles", small_tiles());
    const farm::JoinedTiles tiles({file});
    CHECK_THROWS_AS(render::check_joined_pictures(tiles.key(), {"a.gif"}, {}), util::UsageError);
    CHECK_THROWS_WITH(
        render::check_joined_pictures(tiles.key(), {(folder.path() / "a.png").string()}, {0, 1}),
        contains(".exr .tif"));
    CHECK(entries_in(folder.path()) == 1);
}
