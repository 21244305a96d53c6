// Files that lie: each is read in a child of its own, so that a crash or a hang is a failure with
// the file's name. In an executable of its own: children are forked, so there must be no threads.
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/lidar/child.hpp"
#include "tests/voxelserver/lidar/las_bytes.hpp"
#include "tests/voxelserver/lidar/shared_files.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

TEST_CASE("a child that crashes, hangs or takes too much is recognised",
          "[voxelserver][lidar][child]") {
    CHECK(in_child([] {}).kind == Outcome::Kind::kDone);
    CHECK(in_child([] { throw util::Error("no"); }).text == "no");
    CHECK(in_child([] { std::raise(SIGSEGV); }).kind == Outcome::Kind::kCrashed);
    const auto hang = [] {
        for (volatile int i = 0; i == 0;) {
        }
    };
    CHECK(in_child(hang, rlim_t{1} << 30, 1).kind == Outcome::Kind::kCrashed);
    if (kSanitized)
        return;  // without a limit on memory
    CHECK(in_child([] { std::vector<char> much(std::size_t{3} << 30, 'x'); }).kind ==
          Outcome::Kind::kOther);
}

TEST_CASE("every file of the zoo is read, or refused in one line, those known to be bad always",
          "[voxelserver][lidar][data]") {
    if (!there(kShared))
        return;
    std::set<std::string> bad{"chunk_table_11gb.laz",
                              "empty_layer_sigfpe.laz",
                              "layer_sizes_11gb.laz",
                              "seek_past_end.laz",
                              "garbage_nVariableLength.las",
                              "bad_vlr_count.las",
                              "Semis_2022_0906_6665_LA93_IGN69_nok.laz"};
    int files = 0;
    for (const char* set :
         {"pasture", "lazpy", "laspy", "pdal", "copcjs", "ign-pdal-tools/check_las"}) {
        if (!there(kShared / set))
            continue;
        for (const auto& entry : fs::recursive_directory_iterator(kShared / set)) {
            const fs::path& file = entry.path();
            if (file.extension() != ".las" && file.extension() != ".laz")
                continue;
            ++files;
            const Outcome outcome = in_child([&] {
                const auto info = lidar::read_las_info(file);
                for (const auto& range : lidar::split_by_chunk(info, 100'000))
                    lidar::read_las_points(info, range, [](const pointcloud::Point&) {});
            });
            INFO(file.string() << ": " << outcome.text);
            CHECK(complaint(outcome, file.filename().string()) == "");
            if (bad.erase(file.filename().string()) > 0)
                CHECK(outcome.kind == Outcome::Kind::kError);
        }
    }
    CHECK(files > 100);
    CHECK(bad.empty());
}
