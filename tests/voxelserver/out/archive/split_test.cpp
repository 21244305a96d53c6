#include "voxelserver/out/archive/split.hpp"

#include <chrono>
#include <fstream>
#include <functional>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/synthetic_world.hpp"
#include "voxelserver/out/archive/archive_files.hpp"
#include "voxelserver/out/archive/verify.hpp"

using namespace terravox;
namespace fs = std::filesystem;
using terravox::test::read_content;

namespace {

fs::path write_archive(const fs::path& file) {
    test::SyntheticWorld world({{0, 0, 0}, {150, 200, 90}});
    voxel::ArchiveWriter writer(file, world.info(), 0);
    for (std::int32_t bx = 0; bx < 3; ++bx)
        if (const auto box = world.box({0, bx, 0, 0}))
            writer.add(box->key(), voxel::archive::Kind::kBox, voxel::compress(*box));
    writer.finish();
    return file;
}

/// A file to which something happens before one of the reads.
class Interrupted final : public voxel::archive::ByteSource {
public:
    Interrupted(const fs::path& file, int before, std::function<void()> what)
        : m_source(voxel::archive::file_source(file)), m_left(before), m_what(std::move(what)) {}
    [[nodiscard]] const std::string& name() const noexcept override { return m_source->name(); }
    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                  std::vector<std::byte>& room) override {
        if (--m_left == 0)
            m_what();
        return m_source->read(offset, bytes, room);
    }

private:
    std::unique_ptr<voxel::archive::ByteSource> m_source;
    int m_left;
    std::function<void()> m_what;
};

std::vector<fs::path> list_paths(const fs::path& folder,
                                 const std::vector<archive_tools::FilePart>& parts) {
    std::vector<fs::path> out;
    for (const auto& part : parts)
        out.push_back(folder / part.name);
    return out;
}

}  // namespace

TEST_CASE("parts of an archive are the archive, none larger than the limit", "[archive]") {
    const test::TemporaryFolder folder;
    const fs::path archive = write_archive(folder.path() / "place.tvx");
    const std::string bytes = read_content(archive);
    const std::uint64_t size = bytes.size();
    const std::uint64_t limit = GENERATE_COPY(100, size - 1, size, size + 1, size / 3);
    const auto parts = archive_tools::split(archive, folder.path(), limit);
    std::string joined;
    for (const archive_tools::FilePart& part : parts) {
        const std::string one = read_content(folder.path() / part.name);
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

TEST_CASE("an archive that changes while it is split gives parts of one state, or none",
          "[archive]") {
    const test::TemporaryFolder folder;
    const fs::path archive = write_archive(folder.path() / "place.tvx");
    const std::string bytes = read_content(archive);
    const fs::path parts = folder.path() / "parts";
    const auto cut = [&](const std::function<void()>& meanwhile) {
        Interrupted source(archive, 3, meanwhile);
        return archive_tools::write_parts(source, bytes.size(), "place", parts, bytes.size() / 5);
    };
    SECTION("overwritten") {
        const auto overwrite = [&] {
            const auto before = fs::last_write_time(archive);
            std::ofstream(archive, std::ios::binary) << std::string(bytes.size(), 'x');
            fs::last_write_time(archive, before + std::chrono::seconds(1));
        };
        CHECK_THROWS_AS(cut(overwrite), voxel::ChangedError);
        CHECK(fs::is_empty(parts));
    }
    SECTION("another one put in its place") {
        std::string joined;
        for (const auto& part :
             cut([&] { fs::rename(write_archive(folder.path() / "other.tvx"), archive); }))
            joined += read_content(parts / part.name);
        CHECK((joined == bytes));
    }
}

TEST_CASE("an archive is read, verified and joined from its parts", "[archive]") {
    const test::TemporaryFolder folder;
    const fs::path archive = write_archive(folder.path() / "place.tvx");
    const std::uint64_t limit = GENERATE(64, 1000, 4001);
    const auto parts =
        list_paths(folder.path(), archive_tools::split(archive, folder.path(), limit));
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
    CHECK((read_content(joined) == read_content(archive)));
}

TEST_CASE("names of parts sort by their numbers, and so do files that are named like parts",
          "[archive]") {
    CHECK(archive_tools::part_name("place", 7, 12) == "place-0007.part");
    CHECK(archive_tools::part_name("place", 7, 9'999) == "place-0007.part");
    CHECK(archive_tools::part_name("place", 7, 10'000) == "place-00007.part");
    CHECK(archive_tools::part_name("place", 10'000, 10'000) == "place-10000.part");
    const std::vector<fs::path> by_name{"a/b-0001.part", "a/b-10000.part", "a/b-2000.part"};
    const std::vector<fs::path> by_number{"a/b-0001.part", "a/b-2000.part", "a/b-10000.part"};
    CHECK(archive_tools::in_order_of_numbers(by_name) == by_number);
    for (const fs::path other : {"a/c-0000.part", "b/b-0000.part", "a/b-0000.tvx", "a/b.part"}) {
        INFO(other);
        std::vector<fs::path> with_others = by_name;
        with_others.push_back(other);
        CHECK(archive_tools::in_order_of_numbers(with_others) == with_others);
    }
}

TEST_CASE("a part that changes while others are read is noticed", "[archive]") {
    const test::TemporaryFolder folder;
    const fs::path archive = write_archive(folder.path() / "place.tvx");
    const std::uint64_t bytes = fs::file_size(archive);
    const auto parts =
        list_paths(folder.path(), archive_tools::split(archive, folder.path(), bytes / 100));
    const auto source = archive_tools::ArchiveFiles(parts).open();
    std::vector<std::byte> room;
    REQUIRE(source->read(0, 1, room).size() == 1);
    REQUIRE(source->read(0, bytes, room).size() == bytes);
    // The first is no longer open.
    const fs::path other = folder.path() / "other";
    fs::copy_file(parts.front(), other);
    fs::rename(other, parts.front());
    CHECK_THROWS_AS(source->read(0, 1, room), voxel::ChangedError);
    CHECK(source->read(bytes - 1, 1, room).size() == 1);
}

TEST_CASE("parts that are missing, or not in their place, are refused", "[archive]") {
    const test::TemporaryFolder folder;
    const fs::path archive = write_archive(folder.path() / "place.tvx");
    const auto parts = list_paths(
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
