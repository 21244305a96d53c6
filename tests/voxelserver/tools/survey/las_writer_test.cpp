#include "voxelserver/data/lidar/las_writer.hpp"
#include "common/util/error.hpp"
#include "survey_fixture.hpp"
#include "tests/common/full_disk.hpp"

using namespace terravox;
using namespace terravox::lidar;
using namespace terravox::survey::test;

TEST_CASE("a writer that is not closed leaves nothing behind", "[las_writer]") {
    const TemporaryFolder folder;
    {
        LasWriter writer(folder.path() / "a.laz", {});
        writer.write({});
        CHECK_FALSE(std::filesystem::exists(folder.path() / "a.laz"));
    }
    CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("a full disk is reported, however little of the file is missing", "[las_writer]") {
    const char* const extension = GENERATE(".las", ".laz");
    const TemporaryFolder folder;
    const auto write = [&](const std::filesystem::path& path) {
        LasWriter writer(path, {});
        for (int i = 0; i < 500; ++i) {
            LasWritePoint point;
            point.x = i;
            point.y = i * 7919 % 500;
            point.z = i * 104729 % 500;
            writer.write(point);
        }
        writer.close();
    };
    const auto good = folder.path() / (std::string("good") + extension);
    write(good);
    const auto whole = static_cast<rlim_t>(std::filesystem::file_size(good));
    const auto path = folder.path() / (std::string("full") + extension);
    for (const rlim_t room : {rlim_t{0}, rlim_t{100}, whole / 2, whole - 1}) {
        CAPTURE(room, whole);
        const terravox::test::FullDisk disk(room);
        CHECK_THROWS_WITH(write(path), terravox::test::contains("write " + path.string()));
        CHECK_FALSE(std::filesystem::exists(path));
    }
}

TEST_CASE("what a LAS file cannot hold is refused", "[las_writer]") {
    const TemporaryFolder folder;
    LasWriterOptions options;
    options.point_format = 4;
    CHECK_THROWS_AS(LasWriter(folder.path() / "a.laz", options), util::UsageError);
    options.point_format = 6;
    LasWriter writer(folder.path() / "a.laz", options);
    LasWritePoint point;
    point.x = 1e12;
    CHECK_THROWS_WITH(writer.write(point), terravox::test::contains("does not fit"));
    point = {};
    point.return_number = 3;
    point.return_count = 2;
    CHECK_THROWS_WITH(writer.write(point), terravox::test::contains("return 3 of 2"));
    options.point_format = 1;
    LasWriter old(folder.path() / "b.las", options);
    point = {};
    point.classification = 40;
    CHECK_THROWS_WITH(old.write(point), terravox::test::contains("class 40"));
}
