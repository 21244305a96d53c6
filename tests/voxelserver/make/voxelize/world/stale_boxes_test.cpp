#include <fstream>
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/patchwork.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

struct Outcome {
    int boxes = 0;    ///< that were kept
    int changed = 0;  ///< whose bytes are others now
    int refused = 0;  ///< whose fingerprint is another now
    int stale = 0;    ///< changed, but not refused
    std::string first_stale;
};

/// Makes all boxes again after a change of the inputs, and looks which kept ones would have been
/// used.
Outcome compare(const Kept& kept, voxelize::LidarWorld& now) {
    Outcome out;
    for (const auto& [key, one] : kept.boxes) {
        if (key.level >= now.info().levels)
            continue;
        const auto box = now.box(key);
        const bool same = one.checksum == (box ? box->checksum() : 0);
        const bool valid = now.fingerprint(one.reach) == one.fingerprint;
        ++out.boxes;
        out.changed += same ? 0 : 1;
        out.refused += valid ? 0 : 1;
        if (same || !valid)
            continue;
        if (out.stale++ == 0)
            out.first_stale = "level " + std::to_string(key.level) + " " + std::to_string(key.bx) +
                              ", " + std::to_string(key.by) + ", " + std::to_string(key.bz);
    }
    return out;
}

/// Images are taken as they are: their light would hang on the land all around.
voxelize::LidarWorldOptions raw_options(const Patchwork& patchwork) {
    auto out = patchwork.options();
    out.photo = "raw";
    return out;
}

/// The patchwork with two images that overlap in its west, and all its boxes; made once.
struct Before {
    Patchwork patchwork;
    Kept kept;
    Before() {
        patchwork.image("west.tif", 0, 0, 90, 200, {90, 160, 60});
        patchwork.image("xtra.tif", 70, 0, 60, 200, {130, 130, 130});
        kept = keep(OpenWorld(raw_options(patchwork)).world());
    }
};

/// What is left of the kept boxes after a change of a copy of it all.
Outcome after(const Change& change) {
    static const Before before;
    Patchwork patchwork(before.patchwork);
    auto options = raw_options(patchwork);
    change(patchwork, options);
    OpenWorld now(options);
    return compare(before.kept, now.world());
}

std::string text(const Outcome& o) {
    return std::to_string(o.boxes) + " boxes, " + std::to_string(o.changed) + " changed, " +
           std::to_string(o.refused) + " refused, " + std::to_string(o.stale) +
           " stale; first: " + o.first_stale;
}

}  // namespace

TEST_CASE("no kept box outlives a change of what shaped it, and those live that no change reached",
          "[voxelserver][voxelize][fingerprint]") {
    enum class Refused { kAll, kSome, kNone };
    using Point = Cloud::Point;
    struct Case {
        const char* name;
        Change change;
        Refused refused;
    };
    const auto c = GENERATE(values<Case>({
        {"the lake rises at one end",
         in_square(3,
                   [](Point& p) {
                       if (p.source_class == 9 && p.east < 60)
                           p.height += 1.5;
                   }),
         Refused::kSome},
        {"the lake is longer",
         in_square(5,
                   [](Point& p) {
                       if (p.north > 240 && p.north < 260 && p.east > 430 && p.source_class == 2) {
                           p.source_class = 9;
                           p.height = 292;
                       }
                   }),
         Refused::kSome},
        {"ground at the edge of the hall",
         in_square(0,
                   [](Point& p) {
                       if (p.source_class == 2 && p.east > 113 && p.north < 114)
                           p.height += 3;
                   }),
         Refused::kSome},
        {"a roof next to a border",
         in_square(4,
                   [](Point& p) {
                       if (p.east < 166 && p.north < 166 && p.source_class == 2) {
                           p.source_class = 6;
                           p.height += 7;
                       }
                   }),
         Refused::kSome},
        {"a square is written again with nothing changed", in_square(2, {}), Refused::kSome},
        {"one square more at the end of the lake", in_square(6, {}), Refused::kSome},
        {"one square more far away", in_square(14, {}), Refused::kNone},
        {"one square less at the lake", without("lidar/s4.las"), Refused::kSome},
        {"one square less on land", without("lidar/s2.las"), Refused::kSome},
        {"an image has another colour", image("west.tif", {0, 0, 90, 200}, {200, 60, 40}),
         Refused::kSome},
        {"one image more, which wins", image("a.tif", {60, 20, 60, 60}, {20, 40, 220}),
         Refused::kSome},
        {"one image less", without("images/west.tif"), Refused::kSome},
        {"one image more next to the world", image("far.tif", {2000, 2000, 60, 60}, {20, 40, 220}),
         Refused::kNone},
        {"images the other way round where two overlap", rename_west("zest.tif"), Refused::kSome},
        {"another name of an image, but the same order", rename_west("wert.tif"), Refused::kNone},
        {"a setting", settings("[water]\nslope = 0.31\n"), Refused::kAll},
        {"settings in other words",
         settings("# a remark\n[water]\nmin_depth_m = 0.60\n[points]\ndrop_withheld = true\n"),
         Refused::kNone},
        {"a step", settings("[steps]\nbuilding_fill = false\n"), Refused::kAll},
        {"voxels", [](Patchwork&, Options& o) { o.voxel_m = 1.25; }, Refused::kAll},
        {"the vertical unit", [](Patchwork&, Options& o) { o.vertical_unit = "ft"; },
         Refused::kAll},
        {"the CRS", [](Patchwork&, Options& o) { o.crs = "EPSG:32631"; }, Refused::kAll},
        {"the vertical unit it had, said", [](Patchwork&, Options& o) { o.vertical_unit = "m"; },
         Refused::kNone},
        {"memory, threads and a cache folder",
         [](Patchwork& p, Options& o) {
             o.memory_bytes = 100 << 20;
             o.threads = 1;
             o.cache_dir = p.root() / "cache";
         },
         Refused::kNone},
        {"a class",
         classes("extends = \"asprs\"\n[class.5]\nrole = \"drop\"\nmaterial = \"air\"\n"),
         Refused::kAll},
        {"the same classes in another file", classes("title = \"mine\"\nextends = \"asprs\"\n"),
         Refused::kNone},
        {"the palette", palette("extends = \"default\"\nlightness_weight = 0.123\n"),
         Refused::kSome},
        {"the same palette in another file",
         palette("title = \"mine\"\nextends = \"default\"\n"), Refused::kNone},
        {"the files one by one, the other way round",
         [](Patchwork& p, Options& o) {
             o.files.clear();
             for (int i = 5; i >= 0; --i)
                 o.files.push_back(p.square(i));
         },
         Refused::kNone},
    }));
    DYNAMIC_SECTION(c.name) {
        const Outcome outcome = after(c.change);
        INFO(text(outcome));
        CHECK(outcome.boxes > 0);
        CHECK(outcome.stale == 0);
        switch (c.refused) {
            case Refused::kAll: CHECK(outcome.refused == outcome.boxes); break;
            case Refused::kSome:
                CHECK((outcome.refused > 0 && outcome.refused < outcome.boxes));
                break;
            case Refused::kNone: CHECK((outcome.refused == 0 && outcome.changed == 0)); break;
        }
    }
}

TEST_CASE("no kept box outlives any of many random changes of files",
          "[voxelserver][voxelize][fingerprint][property][all]") {
    Patchwork patchwork;
    Outcome all;
    Kept kept = keep(OpenWorld(patchwork.options()).world());
    for (unsigned seed = 1; seed <= 12; ++seed) {
        std::mt19937 random(seed);
        const auto unit = [&] { return static_cast<double>(random() % 10'000) / 10'000; };
        const int square = static_cast<int>(random() % 6);
        const double east = (square % 3 + unit()) * Patchwork::kSide_m;
        const double north = (square / 3 + unit()) * Patchwork::kSide_m;
        const double radius = 1 + 25 * unit() * unit();
        const int what = static_cast<int>(random() % 5);
        patchwork.write(square, [&](Cloud::Point& p) {
            if (std::hypot(p.east - east, p.north - north) > radius)
                return;
            switch (what) {
                case 0: p.source_class = Patchwork::kGone; break;
                case 1:
                    p.source_class = 9;
                    p.height = 291;
                    break;
                case 2:
                    p.source_class = 6;
                    p.height += 6;
                    break;
                case 3: p.height += 2; break;
                default:
                    p.source_class = p.source_class == 9 ? Patchwork::kGone : 1;
                    p.height -= 0.4;
            }
        });
        OpenWorld now(patchwork.options());
        const Outcome o = compare(kept, now.world());
        kept = keep(now.world());
        INFO("seed " << seed << ", square " << square << ", place " << east << ", " << north
                     << ", radius " << radius << ", change " << what);
        INFO(text(o));
        CHECK(o.stale == 0);
        all.boxes += o.boxes;
        all.changed += o.changed;
        all.refused += o.refused;
    }
    INFO("all changes: " << text(all));
    CHECK(all.changed > 0);
    CHECK(all.refused < all.boxes);
}

TEST_CASE("no kept box under a roof of 300 m outlives a change of the ground around it",
          "[voxelserver][voxelize][fingerprint]") {
    const TemporaryFolder folder;
    const auto write = [&](const char* name, double from, double to, int source_class,
                           double height) {
        Cloud cloud;
        cloud.cover(from, 0, to, 100, 1, source_class,
                    [&](double e, double) { return height + e / 200; });
        cloud.write(folder.path() / name);
    };
    write("a.las", 0, 100, 2, 300);
    write("b.las", 100, 400, 6, 320);
    write("c.las", 400, 500, 2, 300);
    OpenWorld before(folder.path());
    const Kept kept = keep(before.world());
    write("c.las", 400, 500, 2, 306);
    OpenWorld now(folder.path());
    const Outcome o = compare(kept, now.world());
    INFO(text(o));
    CHECK(o.stale == 0);
    CHECK(o.changed > 2);  // the strip itself, and what was interpolated from it
    // What is farther from the strip than anything of it was looked for stays: the ground's own
    // strip, at least.
    const voxel::BoxKey west{0, voxel_x(0) >> 6, 1, voxel_z(50) >> 6};
    CHECK(now.world().fingerprint(kept.boxes.at(west).reach) == kept.boxes.at(west).fingerprint);
    int wide = 0;
    for (const auto& [key, one] : kept.boxes)
        wide += key.level == 0 && one.reach.max_bx - one.reach.min_bx > 3 ? 1 : 0;
    CHECK(wide > 0);
}

TEST_CASE(
    "no kept box at one end of a lake outlives a change of its level, which was seen at the other "
    "end only",
    "[voxelserver][voxelize][fingerprint]") {
    const TemporaryFolder folder;
    const auto write = [&](const char* name, double from, double to, double seen_at) {
        Cloud cloud;
        cloud.cover(from, 0, to, 280, 0.5, 2, [](double e, double n) {
            return std::abs(n - 60) < 14 && e < 480 ? NAN : 297.5;
        });
        cloud.add(from + 50, 279, 290, 2);  // the lowest place: the model's base stays where it is
        if (seen_at > 0)
            cloud.cover(from + 5, 48, to - 5, 72, 2, 9, [&](double, double) { return seen_at; });
        cloud.write(folder.path() / name);
    };
    write("a.las", 0, 100, 292.5);
    write("b.las", 100, 300, 0);
    write("c.las", 300, 500, 0);
    OpenWorld before(folder.path());
    const Kept kept = keep(before.world());
    write("a.las", 0, 100, 294.5);
    OpenWorld now(folder.path());
    const Outcome o = compare(kept, now.world());
    INFO(text(o));
    CHECK(o.stale == 0);
    const voxel::BoxKey far{0, voxel_x(450) >> 6, 1, voxel_z(60) >> 6};
    const voxel::BoxKey land{0, voxel_x(490) >> 6, 1, voxel_z(275) >> 6};
    const auto box = now.world().box(far);
    REQUIRE(box);
    CHECK(box->checksum() != kept.boxes.at(far).checksum);
    CHECK(now.world().fingerprint(kept.boxes.at(land).reach) == kept.boxes.at(land).fingerprint);
}
