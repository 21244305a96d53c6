#include "voxelserver/data/store/square_folder.hpp"

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("a prepared square is read back as it was written", "[voxelserver][store]") {
    struct Case {
        const char* name;
        std::size_t points;
        int patches;
    };
    const auto c = GENERATE(values<Case>({{"empty", 0, 1},
                                          {"a single point", 1, 1},
                                          {"one patch", 3000, 1},
                                          {"twenty patches", 20'000, 20}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "a.square";
        const SquarePtr written = made_square(11, c.points, c.patches);
        store::write_square(file, *written);
        const SquarePtr read = store::map_square(file);
        REQUIRE(read);
        CHECK(read->patches().size() == written->patches().size());
        CHECK(read->all().size() == c.points);
        CHECK(read->counts().outliers == 11);
        CHECK(read->counts().kept == c.points);
        CHECK(same_square(*written, *read));
        CHECK(read->points({1000, 1000}).empty());
        CHECK(read->memory_bytes() >= std::filesystem::file_size(file));
        CHECK(files_ending(folder.path(), ".square").size() == 1);  // nothing unfinished stays
        SECTION("and so is a copy of the mapped one") {
            const auto second = folder.path() / "b.square";
            store::write_square(second, *read);
            CHECK((read_all_bytes(second) == read_all_bytes(file)));
        }
        SECTION("and it stays readable when its file goes") {
            std::filesystem::remove(file);
            CHECK(same_square(*written, *read));
        }
    }
}

TEST_CASE("a chunk index is read back as it was written", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const std::size_t chunks = GENERATE(std::size_t{0}, std::size_t{1}, std::size_t{300});
    const auto written = made_index(5, chunks);
    store::write_chunks(folder.path() / "a.chunks", written);
    const auto read = store::read_chunks(folder.path() / "a.chunks");
    REQUIRE(read);
    CHECK(read->chunks().size() == chunks);
    CHECK(same_index(written, *read));
}

TEST_CASE("a file that is not there is no error, and what is no plain file is one",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    CHECK(store::map_square(folder.path() / "none.square") == nullptr);
    CHECK(store::map_square(folder.path() / "none" / "below.square") == nullptr);
    CHECK_FALSE(store::read_chunks(folder.path() / "none.chunks"));
    write_bytes(folder.path() / "plain", "text");
    CHECK(store::map_square(folder.path() / "plain" / "below.square") == nullptr);
    std::filesystem::create_directory(folder.path() / "folder.square");
    CHECK_THROWS_WITH(store::map_square(folder.path() / "folder.square"),
                      contains("folder.square: not a plain file"));
    const auto pipe = folder.path() / "pipe.square";
    REQUIRE(std::system(("mkfifo " + pipe.string()).c_str()) == 0);
    CHECK_THROWS_WITH(store::map_square(pipe),
                      contains("not a plain file"));  // and opening it does not wait for a writer
    write_bytes(folder.path() / "empty", "");
    const auto empty = util::MappedFile::open(folder.path() / "empty");
    REQUIRE(empty);
    CHECK(empty->bytes().empty());
}

TEST_CASE("what a mapped file no longer holds is not readable", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a";
    constexpr std::size_t kPage = 65536;  // at least a page, on any machine
    write_bytes(file, std::string(4 * kPage, 'x'));
    const auto mapped = util::MappedFile::open(file);
    REQUIRE(mapped);
    const auto bytes = mapped->bytes();
    CHECK(util::readable(bytes));
    CHECK(util::readable(bytes.first(0)));
    std::filesystem::resize_file(file, 2 * kPage);  // in place: the map's end has nothing behind it
    CHECK(util::readable(bytes.first(2 * kPage)));
    CHECK(util::readable(bytes.subspan(kPage + 17, 100)));
    if (util::readable(bytes)) {
        WARN(
            "not tested: this system does not report what a map has lost (Linux does from 5.14 "
            "on)");
        return;
    }
    CHECK_FALSE(util::readable(bytes.subspan(2 * kPage, 1)));
    CHECK_FALSE(util::readable(bytes.subspan(2 * kPage - 1, 2)));
    CHECK_FALSE(util::readable(bytes.last(1)));
    std::filesystem::resize_file(file,
                                 4 * kPage);  // grown again: zeros, which the checksum detects
    CHECK(util::readable(bytes));
}

TEST_CASE("a square that cannot be written is an error that names it", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 100, 3);
    write_bytes(folder.path() / "plain", "text");
    CHECK_THROWS_WITH(store::write_square(folder.path() / "plain" / "a.square", *square),
                      contains("a.square"));
    CHECK_THROWS_AS(store::write_square("/proc/terravox/a.square", *square), util::Error);
    CHECK_THROWS_AS(store::write_chunks(folder.path() / "plain" / "a.chunks", made_index(1, 3)),
                    util::Error);
}
