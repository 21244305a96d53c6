#include "voxelserver/archive/split.hpp"

#include <fstream>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box_codec.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/synthetic_world.hpp"
#include "voxelserver/archive/archive_files.hpp"
#include "voxelserver/archive/verify.hpp"

using namespace terravox;
namespace fs = std::filesystem;
using terravox::test::contains;

namespace {

std::string text_in(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

fs::path write_archive(const fs::path& file) {
    test::SyntheticWorld world({{0, 0, 0}, {150, 200, 90}});
    voxel::ArchiveWriter writer(file, world.info(), 0);
    for (std::int32_t bx = 0; bx < 3; ++bx)
        if (const auto box = world.box({0, bx, 0, 0}))
            writer.add(box->key(), voxel::archive::Kind::kBox, voxel::compress(*box));
    writer.finish();
    return file;
}

std::vector<fs::path> paths_of(const fs::path& folder,
                               const std::vector<archive_tools::FilePart>& parts) {
    std::vector<fs::path> out;
    for (const auto& part : parts)
        out.push_back(folder / part.name);
    return out;
}

}  // namespace

TEST_CASE("parts of an archive are the archive, none larger than the limit", "[archive]") {
    const test::TemporaryFolder folder;
    std::string bytes;
    for (int i = 0; i < 1000; ++i)
        bytes += static_cast<char>(i * 7);
    const fs::path archive = folder.path() / "place.tvx";
    std::ofstream(archive, std::ios::binary) << bytes;
    const std::uint64_t limit = GENERATE(1, 999, 1000, 1001, 333);
    const auto parts = archive_tools::split(archive, folder.path(), limit);
    std::string joined;
    for (const archive_tools::FilePart& part : parts) {
        const std::string one = text_in(folder.path() / part.name);
        REQUIRE(one.size() == part.bytes);
        CHECK(part.bytes <= limit);
        joined += one;
    }
    CHECK(joined == bytes);
    CHECK((parts.size() == 1) == (limit >= bytes.size()));
    CHECK(archive_tools::parts_in(folder.path(), "place").size() ==
          (parts.size() == 1 ? 0 : parts.size()));
    CHECK(archive_tools::parts_in(folder.path(), "plac").empty());
    CHECK(fs::exists(archive));
}

TEST_CASE("an archive is read, verified and joined from its parts", "[archive]") {
    const test::TemporaryFolder folder;
    const fs::path archive = write_archive(folder.path() / "place.tvx");
    const std::uint64_t limit = GENERATE(64, 1000, 4001);
    const auto parts = paths_of(folder.path(), archive_tools::split(archive, folder.path(), limit));
    REQUIRE(parts.size() > 1);
    CHECK(archive_tools::is_first_part(parts.front()));
    CHECK(!archive_tools::is_first_part(archive));
    CHECK(!archive_tools::is_first_part(parts.back()));
    const archive_tools::ArchiveFiles files(parts);
    CHECK(files.bytes() == fs::file_size(archive));
    CHECK(archive_tools::verify(files, 2).problems == archive_tools::verify(archive, 2).problems);
    CHECK(archive_tools::verify_stored(files, 2).problems == 0);
    const fs::path joined = folder.path() / "joined.tvx";
    CHECK(archive_tools::join_parts(parts, joined, 1).boxes == 3);
    const bool is_same = text_in(joined) == text_in(archive);
    CHECK(is_same);
}

TEST_CASE("parts that are missing, or not in their place, are refused", "[archive]") {
    const test::TemporaryFolder folder;
    const fs::path archive = write_archive(folder.path() / "place.tvx");
    const auto parts = paths_of(
        folder.path(), archive_tools::split(archive, folder.path(), fs::file_size(archive) / 4));
    REQUIRE(parts.size() >= 4);
    const fs::path joined = folder.path() / "joined.tvx";
    for (const std::size_t left_out : {std::size_t{1}, parts.size() - 1}) {
        std::vector<fs::path> some = parts;
        some.erase(some.begin() + static_cast<std::ptrdiff_t>(left_out));
        CHECK_THROWS_AS(archive_tools::join_parts(some, joined, 1), util::Error);
    }
    std::vector<fs::path> turned = parts;
    std::swap(turned[1], turned[2]);
    CHECK_THROWS_AS(archive_tools::join_parts(turned, joined, 1), util::Error);
    CHECK(!fs::exists(joined));
}
