// Prepared squares and chunk indices that a crash, a disk or another program has changed.
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "voxelserver/data/store/square_folder.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

constexpr std::size_t kVersionAt = 8;  // bytes from the start of the file: behind the magic

/// Reads everything of a square. @return whether all of it is as it was; @throws Error where it is
/// not read at all
bool read_all(const std::filesystem::path& file, const store::Square& wanted) {
    const SquarePtr found = store::map_square(file);
    return found != nullptr && same_square(wanted, *found);
}

/// Every length that means something, and some between.
std::vector<std::size_t> cuts(std::size_t size, std::size_t header, std::size_t tables) {
    std::vector<std::size_t> out{0, 1, 7, 8, 11, 12, 63, 64};
    for (const std::size_t at : {header / 2, header, header + tables / 2, header + tables, size})
        out.insert(out.end(), {at - 1, at, at + 1});
    std::erase_if(out, [&](std::size_t at) { return at >= size; });
    return out;
}

}  // namespace

TEST_CASE("a prepared square that was cut short, or grew, is refused",
          "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.square";
    const SquarePtr square = made_square(3, 5000, 12);
    store::write_square(file, *square);
    const std::string good = read_all_bytes(file);
    const std::size_t tables = square->patches().size_bytes();
    const std::size_t header = good.size() - tables - square->all().size_bytes();
    for (const std::size_t size : cuts(good.size(), header, tables)) {
        INFO("cut to " << size << " of " << good.size() << " bytes");
        write_bytes(file, good.substr(0, size));
        CHECK_THROWS_AS(store::map_square(file), util::Error);
    }
    write_bytes(file, good + "x");
    CHECK_THROWS_AS(store::map_square(file), util::Error);
    write_bytes(file, good);
    CHECK(read_all(file, *square));
}

TEST_CASE("a chunk index that was cut short, or grew, is refused", "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.chunks";
    store::write_chunks(file, made_index(3, 40));
    const std::string good = read_all_bytes(file);
    const std::size_t header = [&] {
        store::write_chunks(folder.path() / "none.chunks", store::ChunkIndex{});
        return read_all_bytes(folder.path() / "none.chunks").size();
    }();
    for (const std::size_t size : cuts(good.size(), header, good.size() - header)) {
        INFO("cut to " << size << " of " << good.size() << " bytes");
        write_bytes(file, good.substr(0, size));
        CHECK_THROWS_AS(store::read_chunks(file), util::Error);
    }
    write_bytes(file, good + std::string(8, '\0'));
    CHECK_THROWS_AS(store::read_chunks(file), util::Error);
}

TEST_CASE("another version, another kind of file and no such file at all are distinguished",
          "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto square = folder.path() / "a.square";
    const auto chunks = folder.path() / "a.chunks";
    store::write_square(square, *made_square(3, 500, 2));
    store::write_chunks(chunks, made_index(3, 4));
    CHECK_THROWS_WITH(store::map_square(chunks), contains("a.chunks: not a prepared square"));
    CHECK_THROWS_WITH(store::read_chunks(square), contains("a.square: not a prepared square"));
    for (const auto& file : {square, chunks}) {
        std::string newer = read_all_bytes(file);
        newer[kVersionAt] = static_cast<char>(store::kSquareFileVersion + 1);
        write_bytes(file, newer);
    }
    const std::string said = "version " + std::to_string(store::kSquareFileVersion + 1) +
                             "; allowed: " + std::to_string(store::kSquareFileVersion);
    CHECK_THROWS_WITH(store::map_square(square), contains(said));
    CHECK_THROWS_WITH(store::read_chunks(chunks), contains(said));
}

TEST_CASE("whatever bytes of a prepared square change, no wrong point is read",
          "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.square";
    const SquarePtr square = made_square(3, 400, 12);
    store::write_square(file, *square);
    const std::string good = read_all_bytes(file);
    std::mt19937 random(2026);
    int at_once = 0;
    int later = 0;
    for (int round = 0; round < 300; ++round) {
        std::string bad = good;
        for (unsigned n = 1 + random() % 3; n > 0; --n)
            bad[random() % bad.size()] ^= static_cast<char>(1U << (random() % 8));
        if (bad == good)
            continue;
        write_bytes(file, bad);
        INFO("round " << round);
        SquarePtr found;
        try {
            found = store::map_square(file);
        } catch (const util::Error&) {
            ++at_once;
            continue;
        }
        REQUIRE(found);
        int refused = 0;
        for (const auto& patch : square->patches()) {
            std::span<const store::VoxelPoint> points;
            try {
                points = found->points(patch.key);
            } catch (const util::Error&) {
                ++refused;
                continue;
            }
            REQUIRE(same_points(points, square->points(patch.key)));
        }
        CHECK(refused > 0);
        ++later;
        // Writing it anew must not make the damage look sound.
        CHECK_THROWS_AS(store::write_square(folder.path() / "copy.square", *found), util::Error);
        CHECK_FALSE(std::filesystem::exists(folder.path() / "copy.square"));
    }
    CHECK(at_once > 25);
    CHECK(later > 25);
}

TEST_CASE(
    "a prepared square that is cut short in place while it is mapped is refused where it is gone",
    "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.square";
    const SquarePtr square = made_square(5, 200'000, 20);
    store::write_square(file, *square);
    const SquarePtr mapped = store::map_square(file);
    REQUIRE(mapped);
    const auto size = std::filesystem::file_size(file);
    std::filesystem::resize_file(file, size / 2);
    const auto map = util::MappedFile::open(file);
    std::filesystem::resize_file(file, size / 4);
    if (util::readable(map->bytes())) {
        WARN(
            "not tested: this system does not report what a map has lost (Linux does from 5.14 "
            "on)");
        return;
    }
    CHECK(std::ranges::equal(mapped->patches(), square->patches(), {}, &store::PatchEntry::key,
                             &store::PatchEntry::key));
    int refused = 0;
    int same = 0;
    for (const auto& patch : square->patches()) {
        std::span<const store::VoxelPoint> points;
        try {
            points = mapped->points(patch.key);
        } catch (const util::Error& e) {
            CHECK_THAT(e.what(), contains("damaged on disk"));
            ++refused;
            continue;
        }
        REQUIRE(same_points(points, square->points(patch.key)));
        ++same;
    }
    CHECK(refused > 10);
    CHECK(same > 3);
}

TEST_CASE("whatever bytes of a chunk index change, it is refused", "[voxelserver][store][damage]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.chunks";
    store::write_chunks(file, made_index(3, 20));
    const std::string good = read_all_bytes(file);
    std::mt19937 random(77);
    for (int round = 0; round < 200; ++round) {
        std::string bad = good;
        // Half of the rounds hit the counts and sizes, the others anything.
        const std::size_t at = round % 2 == 0 ? random() % 48 : random() % bad.size();
        bad[at] ^= static_cast<char>(1 + random() % 255);
        write_bytes(file, bad);
        INFO("round " << round << ", byte " << at);
        CHECK_THROWS_AS(store::read_chunks(file), util::Error);
    }
}
