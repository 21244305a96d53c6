#include "common/util/files.hpp"

#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using terravox::UsageError;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
using terravox::util::expand_folders;

TEST_CASE("folders become their files, sorted, by ending in any case", "[common][util][files]") {
    const TemporaryFolder folder;
    for (const char* name : {"b.laz", "a.LAZ", "c.las", "notes.txt", ".hidden.laz", "other.zip"}) std::ofstream(folder.path() / name) << "x";
    using Paths = std::vector<std::filesystem::path>;
    CHECK(expand_folders({folder.path()}, {".laz", ".las"}, "LiDAR data") == Paths{folder.path() / "a.LAZ", folder.path() / "b.laz", folder.path() / "c.las"});
    CHECK(expand_folders({folder.path() / "notes.txt"}, {".laz"}, "LiDAR data") == Paths{folder.path() / "notes.txt"});
    CHECK(expand_folders({folder.path() / "b.laz", folder.path()}, {".laz"}, "LiDAR data") == Paths{folder.path() / "b.laz", folder.path() / "a.LAZ"});
    CHECK(expand_folders({}, {".laz"}, "LiDAR data").empty());
}

TEST_CASE("a path without data is a mistake that is named", "[common][util][files]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "notes.txt") << "x";
    CHECK_THROWS_AS(expand_folders({folder.path()}, {".laz", ".las"}, "LiDAR data"), UsageError);
    CHECK_THROWS_WITH(expand_folders({folder.path()}, {".laz", ".las"}, "LiDAR data"),
                      contains("LiDAR data") && contains(folder.path().string()) && contains(".laz .las"));
    CHECK_THROWS_AS(expand_folders({folder.path() / "absent"}, {".laz"}, "LiDAR data"), UsageError);
    CHECK_THROWS_WITH(expand_folders({folder.path() / "absent"}, {".laz"}, "LiDAR data"), contains("absent: no such file or folder"));
}
