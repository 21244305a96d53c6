#include "voxelserver/make/voxelize/columns/square_reader.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::test;
using voxelize::PreparedSquares;
namespace fs = std::filesystem;

namespace {

struct Fixture {
    TemporaryFolder folder;
    store::SquareFolder squares{folder.path(), std::uint64_t{1} << 30};
    const SquarePtr square = made_square(1, 5000, 12);
    const std::vector<std::string> names{"a", "b"};

    /// Changes a point of the square of the first file on disk.
    void damage() const {
        const fs::path file = files_ending(folder.path(), ".square").at(0);
        std::string bytes = read_all_bytes(file);
        bytes[bytes.size() - 1000] ^= 1;
        write_bytes(file, bytes);
    }
};

}  // namespace

TEST_CASE("without a cache folder nothing is prepared", "[voxelserver][voxelize][prepared]") {
    PreparedSquares prepared(nullptr, {"", ""});
    const SquarePtr square = made_square(1, 100, 2);
    CHECK_FALSE(prepared.holds(1));
    CHECK(prepared.find(1) == nullptr);
    CHECK(prepared.keep(1, square) == square);
    CHECK_FALSE(prepared.holds(1));
}

TEST_CASE("a square that was kept is found by later runs, under its own file",
          "[voxelserver][voxelize][prepared]") {
    Fixture f;
    PreparedSquares first(&f.squares, f.names);
    CHECK(first.find(0) == nullptr);
    const SquarePtr mapped = first.keep(0, f.square);
    CHECK(mapped != f.square);
    CHECK(same_square(*mapped, *f.square));
    PreparedSquares second(&f.squares, f.names);
    CHECK(second.holds(0));
    CHECK_FALSE(second.holds(1));
    REQUIRE(second.find(0));
    CHECK(same_square(*second.find(0), *f.square));
    CHECK(second.find(1) == nullptr);
}

TEST_CASE("a damaged square counts as absent, with a warning",
          "[voxelserver][voxelize][prepared][damage]") {
    Fixture f;
    const Warnings warnings;
    (void)PreparedSquares(&f.squares, f.names).keep(0, f.square);
    f.damage();
    PreparedSquares prepared(&f.squares, f.names);
    CHECK(prepared.holds(0));
    CHECK(prepared.find(0) == nullptr);
    CHECK(warnings.count("it is made again") == 1);
    CHECK(prepared.keep(0, f.square) != nullptr);
    CHECK(prepared.find(0));
    CHECK(warnings.count("") == 1);
}

TEST_CASE("all checksums of a square are verified once in a run, then those of what is read",
          "[voxelserver][voxelize][prepared][damage]") {
    Fixture f;
    const Warnings warnings;
    PreparedSquares prepared(&f.squares, f.names);
    (void)prepared.keep(0, f.square);
    REQUIRE(prepared.find(0));
    f.damage();
    const SquarePtr found = prepared.find(0);
    REQUIRE(found);
    CHECK(warnings.text().empty());
    CHECK_THROWS_AS(same_square(*found, *f.square), util::Error);
}
