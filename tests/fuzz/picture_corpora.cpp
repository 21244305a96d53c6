// fuzz-picture-corpora FOLDER: inputs of the targets that need the ray tracer and its farm, in
// FOLDER/TARGET.
#include <cstdio>

#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/farm/checkpoint/records.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "tests/fuzz/corpus.hpp"
#include "tests/fuzz/tile_bytes.hpp"
#include "tests/raytracer/farm/checkpoint/small_picture.hpp"

namespace {

using namespace terravox;
using namespace terravox::fuzz;
namespace fs = std::filesystem;

std::string as_tile_input(const tiles::TileResult& tile, bool encoded) {
    const std::string bytes = chars(tiles::encode_tile(tile));
    if (encoded)
        return '\x01' + bytes;
    const std::size_t before = tile_head_bytes() + tile.holes.size() * kTileHole_bytes;
    const std::string frame = bytes.substr(before);
    std::string pixels(
        static_cast<std::size_t>(ZSTD_getFrameContentSize(frame.data(), frame.size())), '\0');
    ZSTD_decompress(pixels.data(), pixels.size(), frame.data(), frame.size());
    return '\x02' + bytes.substr(0, before) + pixels;
}

void tiles_and_checkpoints(const fs::path& folder) {
    const Corpus corpus(folder, "tile");
    tiles::RenderTile place;
    place.x0 = 4;
    place.x1 = 8;
    place.y1 = 3;
    for (const bool with_layers : {false, true})
        for (const bool encoded : {false, true}) {
            const auto tile = test::tile_of_chance(place, with_layers, 7);
            corpus.add(std::string(with_layers ? "layers" : "plain") + (encoded ? "-encoded" : ""),
                       as_tile_input(tile, encoded));
        }

    for (const bool with_layers : {false, true}) {
        std::string file = chars(farm::file_head(test::small_key(with_layers).to_json()));
        const auto add = [&file](farm::RecordKind kind, std::uint32_t cell,
                                 std::span<const std::byte> payload) {
            file += chars(farm::record_head(kind, cell, payload)) + chars(payload);
        };
        std::uint32_t cell = 0;
        for (const tiles::TileResult& tile : test::small_tiles(with_layers)) {
            add(farm::RecordKind::kTile, cell++, tiles::encode_tile(tile));
            if (cell == 2)
                break;
        }
        add(farm::RecordKind::kForgotten, 0, {});
        const std::string damage = "a square was damaged\n";
        add(farm::RecordKind::kDamage, 0, std::as_bytes(std::span(damage)));
        Corpus(folder, "checkpoint").add(with_layers ? "layers" : "plain", file);
    }
}

std::string message(const farm::Frame& frame) {
    const std::string bytes = frame.SerializeAsString();
    return {
        std::string{static_cast<char>(bytes.size() & 255), static_cast<char>(bytes.size() >> 8)} +
        bytes};
}

void frames(const fs::path& folder) {
    const Corpus corpus(folder, "frames");
    farm::OwnHello own;
    own.role = farm::WORKER;
    own.threads = 2;
    own.capacity = 20;
    own.name = "worker";
    farm::Frame hello;
    *hello.mutable_hello() = farm::make_hello(own);
    corpus.add("hello", message(hello));

    tiles::RenderTile place;
    place.x1 = 3;
    place.y1 = 2;
    farm::Frame task;
    task.mutable_task()->set_picture(1);
    *task.mutable_task()->add_tiles() = farm::to_frame(place, 5);
    farm::Frame done;
    done.mutable_done()->set_result(
        chars(tiles::encode_tile(test::tile_of_chance(place, true, 3))));
    farm::Frame box;
    farm::to_frame({0, 1, 0, -1}, *box.mutable_box()->mutable_key());
    box.mutable_box()->set_frame(chars(voxel::compress(*small_box({0, 1, 0, -1}))));
    corpus.add("work", message(task) + message(done) + message(box));

    farm::Frame scene;
    scene.mutable_state()->set_content(scene::to_toml(scene::Scene{}));
    farm::Frame world;
    world.mutable_state()->set_content(voxel::world_to_json(small_info()));
    corpus.add("state", message(scene) + message(world));

    const std::string whole = hello.SerializeAsString();
    farm::Frame first;
    first.mutable_piece()->set_part(whole.substr(0, whole.size() / 2));
    farm::Frame last;
    last.mutable_piece()->set_part(whole.substr(whole.size() / 2));
    last.mutable_piece()->set_last(true);
    corpus.add("pieces", message(first) + message(last));
}

void scenes(const fs::path& folder) {
    const Corpus corpus(folder, "scene");
    corpus.add("plain.toml", scene::to_toml(scene::Scene{}));
    corpus.add("small.toml", scene::to_toml(test::small_picture(true)));
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) {
        std::fputs("usage: fuzz-picture-corpora FOLDER\n", stderr);
        return 2;
    }
    try {
        const fs::path folder = arguments[1];
        tiles_and_checkpoints(folder);
        frames(folder);
        scenes(folder);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "write the corpora: %s\n", e.what());
        return 1;
    }
    return 0;
}
