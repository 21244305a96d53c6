// Files with bytes changed at random: each is tried in a child of its own, so that a crash or a
// hang is a failure with its number.
#include <algorithm>
#include <functional>
#include <random>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/child.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "voxelserver/tools/laz/laz_commands.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

TEST_CASE("damaged files end in one line, never in a crash", "[voxelserver][laz][damage]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "a.las";
    const fs::path laz = folder.path() / "a.laz";
    const fs::path bad = folder.path() / "bad.las";
    const fs::path out = folder.path() / "out.laz";
    const int format = GENERATE(3, 7);
    write_sample(las, format, 3000, "LOCAL_CS[\"x\"]");
    (void)laz::compress(las, laz);
    for (const fs::path& from : {las, laz}) {
        const std::string good = file_bytes(from);
        for (unsigned seed = 0; seed < 24; ++seed) {
            CAPTURE(format, from.string(), seed);
            std::mt19937 random(seed);
            std::string bytes = good;
            // Half of them in the header and its records, where counts and offsets are.
            for (int i = 0; i < 4; ++i)
                bytes[random() % (seed % 2 == 0 ? std::min<std::size_t>(bytes.size(), 600)
                                                : bytes.size())] = static_cast<char>(random());
            if (seed % 5 == 0)
                bytes.resize(random() % bytes.size());
            write_bytes(bad, bytes);
            for (const auto& work : std::vector<std::function<void()>>{
                     [&] { (void)laz::check(bad); }, [&] { (void)laz::info_json(bad); },
                     [&] { (void)laz::compress(bad, out); }, [&] { (void)laz::write_lax(bad); }}) {
                CHECK(complaint(in_child(work)) == "");
            }
        }
    }
}
