#include "raytracer/apps/pmtiles/archive_writer.hpp"

#include <random>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/apps/pmtiles/archive_reader.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

const pmtiles::ArchiveFacts kFacts{
    pmtiles::TileFormat::kPng, 14, 18, {14.5, 46.05, 14.52, 46.0556}, R"({"name":"Škofja Loka"})"};

/// Writes tiles and reads them back.
ArchiveReader make_archive(const std::map<std::uint64_t, std::string>& tiles) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "map.pmtiles";
    pmtiles::ArchiveWriter writer(file);
    for (const auto& [id, bytes] : tiles)
        writer.add(id, bytes);
    writer.finish(kFacts);
    return ArchiveReader(read_all_bytes(file));
}

}  // namespace

TEST_CASE("each tile of an archive is found by its number", "[pmtiles]") {
    const unsigned seed = GENERATE(range(1U, 9U));
    std::mt19937 random(seed);
    std::map<std::uint64_t, std::string> tiles;
    std::set<std::string> kinds;
    std::uint64_t id = random() % 1000;
    for (int i = 0; i < 3000; ++i) {
        // Few kinds of tiles, so that some follow each other and others come again.
        tiles[id] = std::string(1 + random() % 3, static_cast<char>('a' + random() % 5));
        kinds.insert(tiles[id]);
        id += random() % 4 == 0 ? 1 + random() % (std::uint64_t{1} << (random() % 20)) : 1;
    }
    const ArchiveReader archive = make_archive(tiles);
    CHECK(archive.tiles() == tiles);
    CHECK(archive.metadata() == R"({"name":"Škofja Loka"})");
    CHECK(archive.number<std::uint64_t>(72) == tiles.size());
    CHECK(archive.number<std::uint64_t>(80) < tiles.size());
    CHECK(archive.number<std::uint64_t>(88) == kinds.size());
    std::size_t stored = 0;
    for (const std::string& kind : kinds)
        stored += kind.size();
    CHECK(archive.number<std::uint64_t>(64) == stored);
}

TEST_CASE("the header tells what the archive holds", "[pmtiles]") {
    const ArchiveReader archive = make_archive({{7, "tile"}});
    CHECK(archive.number<std::uint8_t>(96) == 1);  // in order
    CHECK(archive.number<std::uint8_t>(97) == 2);  // directories: gzip
    CHECK(archive.number<std::uint8_t>(98) == 1);  // tiles: as they are
    CHECK(archive.number<std::uint8_t>(99) == 2);  // PNG
    CHECK(archive.number<std::uint8_t>(100) == 14);
    CHECK(archive.number<std::uint8_t>(101) == 18);
    CHECK(archive.number<std::int32_t>(102) == 145'000'000);
    CHECK(archive.number<std::int32_t>(106) == 460'500'000);
    CHECK(archive.number<std::int32_t>(110) == 145'200'000);
    CHECK(archive.number<std::int32_t>(114) == 460'556'000);
    CHECK(archive.number<std::int32_t>(119) == 145'100'000);
    CHECK(archive.number<std::int32_t>(123) == 460'528'000);
}

TEST_CASE("the root of a large archive fits into the first request", "[pmtiles]") {
    std::mt19937 random(1);
    std::map<std::uint64_t, std::string> tiles;
    for (std::uint64_t id = 0; tiles.size() < 20'000; id += 1 + random() % 100)
        tiles[id] = std::to_string(random()) + std::string(random() % 300, 'x');
    const ArchiveReader archive = make_archive(tiles);
    CHECK(archive.root_bytes() + 127 <= 16'384);
    CHECK(archive.leaf_bytes() > 0);
    CHECK(archive.tiles() == tiles);
}

TEST_CASE("an archive has its name when it is complete", "[pmtiles]") {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "map.pmtiles";
    {
        pmtiles::ArchiveWriter writer(file);
        writer.add(1, "tile");
        CHECK_FALSE(exists(file));
    }
    CHECK(is_empty(folder.path()));
}

TEST_CASE("tiles without order, without bytes, and none at all are refused", "[pmtiles]") {
    const TemporaryFolder folder;
    pmtiles::ArchiveWriter writer(folder.path() / "map.pmtiles");
    CHECK_THROWS_AS(writer.finish(kFacts), util::Error);
    CHECK_THROWS_AS(writer.add(4, ""), util::Error);
    writer.add(4, "a");
    writer.add(5, "a");
    CHECK_THROWS_AS(writer.add(5, "b"), util::Error);
    CHECK_THROWS_AS(writer.add(3, "b"), util::Error);
    CHECK_NOTHROW(writer.add(6, "a"));
}
