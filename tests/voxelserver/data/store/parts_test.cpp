// Files of which only parts are decoded: the voxels must be those of the whole.

#include "tests/catch.hpp"
#include "tests/voxelserver/data/lidar/read_points.hpp"
#include "tests/voxelserver/data/store/strip.hpp"
#include "voxelserver/data/lidar/las_file.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

const fs::path kCopc = fs::path(TERRAVOX_SHARED_DATA) / "copcjs" / "ellipsoid.copc.laz";

/// A cache folder in which only the chunk index of a file is left.
void leave_index(const fs::path& file, const fs::path& cache) {
    auto options = OpenWorld::with(file);
    options.cache_dir = cache;
    TimedWorld world(options);
    (void)world->box(all_keys(world->info(), 0).front());
    for (const auto& square : files_ending(cache / "squares", ".square"))
        fs::remove(square);
    REQUIRE(files_ending(cache / "squares", ".chunks").size() == 1);
}

/// Copies the points of a file in a random order.
void write_shuffled(const lidar::LasInfo& info, const fs::path& to) {
    std::vector<pointcloud::Point> points;
    lidar::read_las_points(info, {0, info.point_count},
                           [&](const pointcloud::Point& p) { points.push_back(p); });
    std::shuffle(points.begin(), points.end(), std::mt19937(8));
    lidar::LasWriterOptions options;
    options.point_format = info.point_format;
    options.scale = info.scale;
    options.offset = info.offset;
    if (info.crs)
        options.wkt = info.crs->wkt();
    lidar::LasWriter writer(to, options);
    for (const pointcloud::Point& p : points) {
        REQUIRE_FALSE((p.withheld || p.overlap));
        lidar::LasWritePoint out;
        out.x = p.x;
        out.y = p.y;
        out.z = p.z;
        out.classification = p.classification;
        out.rgb = p.rgb;
        out.return_number = p.return_number;
        out.return_count = p.return_count;
        writer.write(out);
    }
    writer.close();
}

}  // namespace

TEST_CASE("chunk indices that another world has kept spare most of a file, where they are read",
          "[voxelserver][store][parts]") {
    const Strip& strip = Strip::get();
    REQUIRE(strip.stretches >= 6);
    REQUIRE(solid_boxes(strip.boxes) >= 40);
    const TemporaryFolder kept;
    auto options = OpenWorld::with(strip.sorted);
    options.chunk_indices = kept.path();
    const auto one_box = [&] {
        TimedWorld world(options);
        const auto keys = all_keys(world->info(), 0);
        const auto middle = keys[keys.size() / 2];
        const auto box = world->box(middle);
        CHECK((box ? box->checksum() : 0) == strip.boxes.at(middle));
        return world.count("point load");
    };
    CHECK(one_box() == strip.stretches);
    CHECK(files_ending(kept.path(), ".chunks").size() == 1);
    CHECK(one_box() == strip.stretches);
    options.reads_chunk_indices = true;
    const auto some = one_box();
    CHECK(some >= 1);
    CHECK(some <= strip.stretches / 2);
    CHECK((TimedWorld(options).boxes(3) == strip.boxes));
    const fs::path index = files_ending(kept.path(), ".chunks").front();
    const std::string bytes = read_all_bytes(index);
    write_bytes(index, bytes.substr(0, bytes.size() / 2));
    CHECK(one_box() == strip.stretches);
    CHECK(read_all_bytes(index) == bytes);
}

TEST_CASE("a file in which every part lies everywhere gives the same boxes",
          "[voxelserver][store][parts]") {
    const Strip& strip = Strip::get();
    const Checksums whole = TimedWorld(OpenWorld::with(strip.mixed)).boxes();
    const TemporaryFolder cache;
    leave_index(strip.mixed, cache.path());
    auto options = OpenWorld::with(strip.mixed);
    options.cache_dir = cache.path();
    TimedWorld world(options);
    CHECK((world.boxes(5) == whole));
    CHECK(world.count("point load") <= 3 * strip.stretches);
}

TEST_CASE(
    "a COPC file makes the same boxes through its hierarchy, in parts and whole, as its points in "
    "any order",
    "[voxelserver][store][parts][data]") {
    if (!fs::exists(kCopc)) {
        WARN("skipped: " << kCopc.string() << " is not there");
        return;
    }
    const auto info = lidar::read_las_info(kCopc);
    const TemporaryFolder folder;
    write_shuffled(info, folder.path() / "plain.laz");
    auto plain = OpenWorld::with(folder.path() / "plain.laz");
    plain.voxel_m = 0.5;  // so that the thing is more than a few boxes
    if (!info.crs)
        plain.crs = kCrs;
    // Ground far from any point is looked for far around, which takes long where no memory is left
    // to remember it.
    plain.settings = folder.path() / "settings.toml";
    write_bytes(plain.settings, "[steps]\nground_fill = false\n");
    auto copc = plain;
    copc.files = {kCopc};
    const Checksums wanted = TimedWorld(plain).boxes();
    INFO(wanted.size() << " boxes, " << info.point_count << " points");
    CHECK(solid_boxes(wanted) > 4);
    copc.memory_bytes = GENERATE(std::size_t{4} << 30, std::size_t{1});
    TimedWorld world(copc);
    CHECK((world.boxes(3) == wanted));
}
