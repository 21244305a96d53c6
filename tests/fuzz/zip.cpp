// ZIP files that should hold a Minecraft world: names, entries, and the world that they make.
#include <algorithm>

#include "voxelserver/make/worlds/minecraft/source.hpp"

#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::fuzz {
namespace {

constexpr std::size_t kCache_bytes = std::size_t{16} << 20;
constexpr std::size_t kMaxWhole_bytes = std::size_t{1} << 20;
constexpr std::size_t kMaxRead = 8;

void read_entries(const std::filesystem::path& path) {
    const auto source = minecraft::open_zip(path, kCache_bytes);
    const auto& entries = source->entries();
    for (std::size_t i = 0; i < std::min(entries.size(), kMaxRead); ++i) {
        expect(
            entries[i].path.find("..") == std::string::npos ||
                std::filesystem::path(entries[i].path).lexically_normal().native().rfind("..", 0) !=
                    0,
            "no entry leads outside");
        expect(entries[i].path.front() != '/', "no entry begins at the root");
        allow_errors([&] {
            expect(source->head(i, 100).size() <= 100, "no more is returned than was requested");
        });
        allow_errors([&] {
            expect(source->whole(i, kMaxWhole_bytes).size() <= kMaxWhole_bytes,
                   "no more is handed out than was allowed");
        });
    }
}

void read_world(const std::filesystem::path& path) {
    const minecraft::WorldFolder world(path, kCache_bytes);
    (void)world.title();
    for (const auto& dimension : world.dimensions()) {
        const minecraft::ChunkStore store(world, dimension, 1);
        minecraft::ChunkReader reader(store);
        worlds::DamageLog damage;
        const auto chunks = store.chunks();
        for (std::size_t i = 0; i < std::min(chunks.size(), kMaxRead); ++i)
            allow_errors([&] { (void)reader.read(chunks[i], damage); });
    }
}

}  // namespace

void run(Input input) {
    const auto path = as_file(input, "input.zip");
    allow_errors([&] { read_entries(path); });
    read_world(path);
}

}  // namespace terravox::fuzz
