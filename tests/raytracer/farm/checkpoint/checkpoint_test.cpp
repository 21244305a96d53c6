#include "raytracer/farm/checkpoint/checkpoint.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>

#include "common/util/error.hpp"
#include "raytracer/core/tiles/tile_codec.hpp"
#include "tests/catch.hpp"
#include "tests/common/flushes.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/farm/checkpoint/small_picture.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;
using enum farm::Checkpoint::Existing;

namespace {

using Hashes = std::vector<std::uint64_t>;

Hashes hashes(farm::Checkpoint& checkpoint) {
    Hashes out;
    checkpoint.each([&](tiles::TileResult&& tile) { out.push_back(tiles::hash_of_pixels(tile)); });
    return out;
}

Hashes hashes(const std::vector<tiles::TileResult>& tiles) {
    Hashes out;
    for (const tiles::TileResult& tile : tiles)
        out.push_back(tiles::hash_of_pixels(tile));
    return out;
}

std::string read_all_bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

/// A checkpoint with these tiles, closed.
void make(const fs::path& file, const std::vector<tiles::TileResult>& tiles,
          bool with_layers = false) {
    farm::Checkpoint checkpoint(file, small_key(with_layers), kRefuse);
    for (const tiles::TileResult& tile : tiles)
        checkpoint.add(tile);
    checkpoint.close();
}

}  // namespace

TEST_CASE("tiles are read from a checkpoint in the order of the picture",
          "[raytracer][checkpoint]") {
    const bool with_layers = GENERATE(false, true);
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.exr.tiles";
    const auto tiles = small_tiles(with_layers),
               spiral = small_tiles(with_layers, 1, core::TileOrder::kSpiral);
    {
        farm::Checkpoint checkpoint(file, small_key(with_layers), kResume);
        for (std::size_t i = 0; i < 5; ++i) {
            CHECK_FALSE(checkpoint.has(spiral[i].tile));
            checkpoint.add(spiral[i]);
            CHECK(checkpoint.has(spiral[i].tile));
            CHECK(checkpoint.count() == i + 1);
        }
    }
    farm::Checkpoint checkpoint(file, small_key(with_layers), kResume);
    CHECK(checkpoint.count() == 5);
    int there = 0;
    for (const tiles::TileResult& tile : tiles)
        there += checkpoint.has(tile.tile) ? 1 : 0;
    CHECK(there == 5);
    for (std::size_t i = 5; i < 9; ++i)
        checkpoint.add_encoded(tiles::encode_tile(spiral[i]));
    CHECK(hashes(checkpoint) == hashes(tiles));
    checkpoint.finish();
    CHECK_FALSE(fs::exists(file));
}

TEST_CASE("tiles are on the disk when a checkpoint is closed", "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    farm::Checkpoint checkpoint(folder.path() / "a.tiles", small_key(false), kRefuse);
    const int before = flushes();
    checkpoint.add(small_tiles(false).front());
    checkpoint.close();
    CHECK(flushes() > before);
}

TEST_CASE("the last of several results of a tile counts, and none once it is forgotten",
          "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    const auto tiles = small_tiles(), others = small_tiles(false, 99);
    {
        farm::Checkpoint checkpoint(file, small_key(), kResume);
        for (const std::size_t i : {3U, 4U, 5U})
            checkpoint.add(tiles[i]);
        checkpoint.add(others[4]);
        checkpoint.forget(tiles[5].tile);
        checkpoint.forget(tiles[8].tile);
        CHECK(checkpoint.count() == 2);
        CHECK(hashes(checkpoint) ==
              Hashes{tiles::hash_of_pixels(tiles[3]), tiles::hash_of_pixels(others[4])});
    }
    farm::Checkpoint checkpoint(file, small_key(), kResume);
    CHECK(checkpoint.count() == 2);
    CHECK_FALSE(checkpoint.has(tiles[5].tile));
    CHECK(hashes(checkpoint) ==
          Hashes{tiles::hash_of_pixels(tiles[3]), tiles::hash_of_pixels(others[4])});
    checkpoint.add(tiles[5]);
    CHECK(checkpoint.has(tiles[5].tile));
}

TEST_CASE("tiles with holes are rendered again", "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    auto tiles = small_tiles();
    tiles[2].holes = {{0, 1, 2, 3}};
    {
        farm::Checkpoint checkpoint(file, small_key(), kResume);
        checkpoint.add(tiles[1]);
        checkpoint.add(tiles[2]);
        CHECK(checkpoint.has(tiles[2].tile));  // it is what this run could do
    }
    {
        farm::Checkpoint checkpoint(file, small_key(), kResume);
        CHECK(checkpoint.count() == 1);
        CHECK(checkpoint.with_holes() == 1);
        CHECK_FALSE(checkpoint.has(tiles[2].tile));
        CHECK(hashes(checkpoint) == Hashes{tiles::hash_of_pixels(tiles[1])});
        tiles[2].holes.clear();
        checkpoint.add(tiles[2]);
        CHECK(checkpoint.count() == 2);
        CHECK(checkpoint.with_holes() == 0);
    }
    farm::Checkpoint checkpoint(file, small_key(), kResume);
    CHECK(checkpoint.count() == 2);
    CHECK(checkpoint.has(tiles[2].tile));
}

TEST_CASE("damage of the world's data is kept, each line once", "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    {
        farm::Checkpoint checkpoint(file, small_key(), kResume);
        checkpoint.note_damage({"b.laz: damaged", "a.laz: cut short"});
        const auto size = fs::file_size(file);
        checkpoint.note_damage({"a.laz: cut short"});
        CHECK(fs::file_size(file) == size);
    }
    farm::Checkpoint checkpoint(file, small_key(), kResume);
    checkpoint.note_damage({"c.laz: of\nanother world"});
    CHECK(checkpoint.damage() == std::vector<std::string>{"a.laz: cut short", "b.laz: damaged",
                                                          "c.laz: of another world"});
}

TEST_CASE("a checkpoint that was cut short or damaged has all other tiles, and can be completed",
          "[raytracer][checkpoint]") {
    // That it may be any byte: records_test.cpp.
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    const auto tiles = small_tiles();
    make(file, {tiles.begin(), tiles.begin() + 4});
    const std::string bytes = read_all_bytes(file);
    std::string damaged = bytes;
    damaged[bytes.size() / 2] ^= 1;
    for (const std::string& text : {bytes.substr(0, bytes.size() - 10), damaged}) {
        write(file, text);
        {
            farm::Checkpoint checkpoint(file, small_key(), kResume);
            REQUIRE(checkpoint.count() == 3);
            for (const tiles::TileResult& tile : tiles)
                if (!checkpoint.has(tile.tile))
                    checkpoint.add(tile);
        }
        farm::Checkpoint again(file, small_key(), kResume);
        REQUIRE(hashes(again) == hashes(tiles));
    }
    write(file, bytes.substr(0, 20));
    CHECK_THAT(to_message([&] { farm::Checkpoint(file, small_key(), kResume); }),
               contains("no checkpoint of a picture"));
    write(file, "a text of mine, which is not to be overwritten");
    CHECK_THROWS_AS(farm::Checkpoint(file, small_key(), kResume), util::Error);
    CHECK(read_all_bytes(file) == "a text of mine, which is not to be overwritten");
}

TEST_CASE("a tile with invalid pixels is rendered again", "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    auto tiles = small_tiles();
    const auto good = tiles::hash_of_pixels(tiles[0]);
    tiles[1].samples[5].colour.r = std::numeric_limits<float>::quiet_NaN();
    make(folder.path() / "a.tiles", {tiles[0], tiles[1]});
    farm::Checkpoint checkpoint(folder.path() / "a.tiles", small_key(), kResume);
    CHECK(hashes(checkpoint) == Hashes{good});
    CHECK_FALSE(checkpoint.has(tiles[1].tile));
    CHECK(checkpoint.count() == 1);
}

TEST_CASE("another picture's checkpoint is refused, and left as it is", "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    make(file, {small_tiles()[0]});
    const std::string bytes = read_all_bytes(file);
    scene::Scene other = small_picture();
    other.camera.fov_deg = 55;
    const auto info = landscape()->info();
    CHECK_THAT(
        to_message([&] { farm::Checkpoint(file, farm::to_key(other, info, {"test"}), kResume); }),
        contains("go on with the checkpoint") &&
            contains("it is of another picture: camera.fov_deg = 40.0 there, 55.0 here"));
    CHECK_THAT(to_message([&] {
                   farm::Checkpoint(file, farm::to_key(small_picture(), info, {"else"}), kResume);
               }),
               contains("input 1 = test there, else here"));
    farm::PictureKey other_build = small_key();
    other_build.build = "0123";
    CHECK_THAT(to_message([&] { farm::Checkpoint(file, other_build, kResume); }),
               contains("this is terravox") && contains("build 0123"));
    CHECK_THROWS_AS(farm::Checkpoint(file, small_key(), kRefuse), util::UsageError);
    CHECK(read_all_bytes(file) == bytes);
    // Names need not be text.
    farm::PictureKey strange = small_key();
    strange.inputs = {"\xff\xfe.laz: 1 file"};
    make(folder.path() / "b.tiles", {});
    const auto twice = folder.path() / "c.tiles";
    for (int i = 0; i < 2; ++i) {
        farm::Checkpoint checkpoint(twice, strange, kResume);
        checkpoint.add(small_tiles()[0]);
        CHECK(checkpoint.count() == 1);
    }
}

TEST_CASE("what is no whole first tile of the picture is not taken", "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    farm::Checkpoint checkpoint(folder.path() / "a.tiles", small_key(), kResume);
    const auto taken = [&](const std::function<void(tiles::RenderTile&)>& change) {
        tiles::RenderTile tile = small_tiles()[4].tile;
        change(tile);
        return to_message([&] { checkpoint.add(tile_of_chance(tile, false, 1)); });
    };
    CHECK(taken([](tiles::RenderTile&) {}) == "nothing");
    CHECK_THAT(taken([](tiles::RenderTile& t) { t.step = 2; }),
               contains("no whole tile of a single pass"));
    CHECK_THAT(taken([](tiles::RenderTile& t) { t.refines = true; }), contains("no whole tile"));
    CHECK_THAT(taken([](tiles::RenderTile& t) { t.first_sample = 2; }), contains("no whole tile"));
    CHECK_THAT(taken([](tiles::RenderTile& t) { t.y1 -= 8; }), contains("no whole tile"));
    CHECK_THAT(taken([](tiles::RenderTile& t) {
                   t.x0 += 1;
                   t.x1 += 1;
               }),
               contains("no whole tile"));
    CHECK_THAT(taken([](tiles::RenderTile& t) {
                   t.x0 += 160;
                   t.x1 += 160;
               }),
               contains("no whole tile"));
    CHECK_THAT(to_message([&] { checkpoint.add(small_tiles(true)[0]); }),
               contains("has layers; the picture has none"));
    CHECK(checkpoint.count() == 1);
    checkpoint.close();
    CHECK_THAT(to_message([&] { checkpoint.add(small_tiles()[0]); }), contains("after the end"));
}

TEST_CASE("one coordinator at a time writes to a checkpoint", "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    {
        farm::Checkpoint first(file, small_key(), kResume);
        first.add(small_tiles()[0]);
        CHECK_THAT(to_message([&] { farm::Checkpoint(file, small_key(), kResume); }),
                   contains("a.tiles: another coordinator is writing to it"));
        first.add(small_tiles()[1]);
    }
    CHECK(farm::Checkpoint(file, small_key(), kResume).count() == 2);
}

TEST_CASE("a link at the name of a checkpoint is refused, and leads to what it led to",
          "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "precious") << "as it was";
    fs::create_symlink("precious", folder.path() / "a.tiles");
    CHECK_THAT(
        to_message([&] { farm::Checkpoint(folder.path() / "a.tiles", small_key(), kResume); }),
        contains("a.tiles is a symbolic link"));
    CHECK(fs::file_size(folder.path() / "precious") == 9);
}

TEST_CASE("a checkpoint in which there is nothing does not stay, unless it is to",
          "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "deeper" / "a.tiles";
    {
        const farm::Checkpoint checkpoint(file, small_key(), kResume);
    }
    CHECK_FALSE(fs::exists(file));
    make(file, {});
    CHECK(fs::exists(file));
    CHECK(farm::Checkpoint(file, small_key(), kResume).count() == 0);
}

TEST_CASE("a full disk is reported, and all tiles that were added before are kept",
          "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    const auto tiles = small_tiles();
    make(folder.path() / "b.tiles", {tiles[0], tiles[1], tiles[2]});
    const auto three = fs::file_size(folder.path() / "b.tiles");
    ::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
    for (const std::uint64_t room : {three, three - 1, three - 500, std::uint64_t{100}}) {
        INFO(room << " bytes");
        std::error_code ignored;
        fs::remove(file, ignored);
        const rlimit limit{room, before.rlim_max};
        std::size_t added = 0;
        ::setrlimit(RLIMIT_FSIZE, &limit);
        const std::string said = to_message([&] {
            farm::Checkpoint checkpoint(file, small_key(), kResume);
            for (; added < 9; ++added)
                checkpoint.add(tiles[added]);
        });
        ::setrlimit(RLIMIT_FSIZE, &before);
        CHECK_THAT(said, contains("write the checkpoint " + file.string() + ": File too large"));
        if (room == 100) {
            CHECK_FALSE(fs::exists(file));
            continue;
        }
        CHECK(added == (room == three ? 3 : 2));
        farm::Checkpoint checkpoint(file, small_key(), kResume);
        CHECK(hashes(checkpoint) ==
              hashes({tiles.begin(), tiles.begin() + static_cast<std::ptrdiff_t>(added)}));
    }
}

TEST_CASE("a coordinator that is killed at any time loses no tile that it had added",
          "[raytracer][checkpoint]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.tiles";
    const auto tiles = small_tiles();
    const auto all = hashes(tiles);
    for (std::size_t until = 0; until < 12; ++until) {
        INFO("killed in the tile after " << until);
        std::error_code ignored;
        fs::remove(file, ignored);
        int told[2];
        int may_go[2];
        REQUIRE(::pipe(told) == 0);
        REQUIRE(::pipe(may_go) == 0);
        const pid_t child = ::fork();
        if (child == 0) {
            farm::Checkpoint checkpoint(file, small_key(), kResume);
            for (int round = 0;; ++round)
                for (const tiles::TileResult& tile : tiles) {
                    char go = 0;
                    if (::read(may_go[0], &go, 1) != 1)
                        ::_exit(1);
                    checkpoint.add(tile);
                    const char done = 1;
                    if (::write(told[1], &done, 1) != 1)
                        ::_exit(1);
                }
        }
        ::close(told[1]);
        ::close(may_go[0]);
        // Not a tile is begun before it may be: how far the child gets does not depend on which
        // process has the processor.
        const char go = 1;
        char done = 0;
        for (std::size_t i = 0; i < until; ++i) {
            REQUIRE(::write(may_go[1], &go, 1) == 1);
            REQUIRE(::read(told[0], &done, 1) == 1);
        }
        REQUIRE(::write(may_go[1], &go, 1) == 1);
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
        ::close(told[0]);
        ::close(may_go[1]);
        farm::Checkpoint checkpoint(file, small_key(), kResume);
        const auto there = hashes(checkpoint);
        INFO(there.size() << " tiles are there");
        CHECK(there.size() >= std::min<std::size_t>(until, 9));
        CHECK(there.size() <= std::min<std::size_t>(until + 1, 9));
        CHECK(std::equal(there.begin(), there.end(), all.begin()));
    }
}

TEST_CASE("checkpoints are named after their pictures, and are for pictures that can be resumed",
          "[raytracer][checkpoint]") {
    CHECK(farm::checkpoint_path("a/out.exr") == "a/out.exr.tiles");
    CHECK(farm::checkpoint_path("a/out.exr", farm::Part{2, 5}) == "a/out.exr.part-2-of-5.tiles");
    scene::Scene scene = small_picture();
    CHECK_NOTHROW(farm::check_can_checkpoint(scene));
    scene.quality.time_s = 5;
    CHECK_THROWS_AS(farm::check_can_checkpoint(scene), util::UsageError);
    scene.quality.time_s = 0;
    scene.quality.coarse_step = 8;
    CHECK_THAT(to_message([&] { farm::check_can_checkpoint(scene); }),
               contains("coarse_step = 8; allowed: 1"));
}
