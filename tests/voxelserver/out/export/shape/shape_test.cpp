#include <algorithm>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "common/voxel/side_car.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/out/export/shape/painted_world.hpp"
#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/shape/byte_file.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

using namespace terravox;
using namespace terravox::exports;

TEST_CASE(
    "columns are those of squares in which something may stand, each once, square after square",
    "[convert][shape]") {
    using Places = std::set<std::pair<int, int>>;
    constexpr ColumnBlock kWide{-5, 7, 60, 50};
    struct Case {
        const char* name;
        ColumnBlock of;
        int edge;
        std::optional<Places> stand;  // nullopt: everywhere
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"less than a square", {-1, -1, 2, 1}, 8, {}},
        {"squares that do not fit", {-5, 7, 6, 14}, 4, {}},
        {"squares of one", {0, 0, 3, 2}, 1, {}},
        {"nothing", kWide, 4, Places{}},
        {"the corners", kWide, 4, Places{{-5, 7}, {59, 7}, {-5, 49}, {59, 49}}},
        {"some", kWide, 4, Places{{-5, 7}, {3, 8}, {11, 8}, {-4, 30}, {30, 30}, {31, 31}}},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto may_hold = [&](const ColumnBlock& b) {
            return !c.stand || std::any_of(c.stand->begin(), c.stand->end(), [&](const auto& at) {
                return at.first >= b.min_bx && at.first < b.max_bx && at.second >= b.min_bz &&
                       at.second < b.max_bz;
            });
        };
        std::vector<std::tuple<int, int, std::size_t>> expected;
        std::size_t square = 0;
        std::size_t squares = 0;
        for (int z0 = c.of.min_bz; z0 < c.of.max_bz; z0 += c.edge)
            for (int x0 = c.of.min_bx; x0 < c.of.max_bx; x0 += c.edge, ++square) {
                const ColumnBlock block{x0, z0, std::min(x0 + c.edge, c.of.max_bx),
                                        std::min(z0 + c.edge, c.of.max_bz)};
                if (!may_hold(block))
                    continue;
                ++squares;
                for (int z = block.min_bz; z < block.max_bz; ++z)
                    for (int x = block.min_bx; x < block.max_bx; ++x)
                        expected.emplace_back(x, z, square);
            }
        const Columns columns(c.of, static_cast<std::size_t>(c.edge), may_hold);
        std::vector<std::tuple<int, int, std::size_t>> found;
        for (std::size_t i = 0; i < columns.count(); ++i)
            found.emplace_back(columns.at(i).bx, columns.at(i).bz, columns.at(i).square);
        CHECK(found == expected);
        CHECK(columns.squares().size() == squares);
        const auto all =
            static_cast<std::size_t>((c.of.max_bx - c.of.min_bx) * (c.of.max_bz - c.of.min_bz));
        CHECK(columns.left_out() == all - expected.size());
    }
}

TEST_CASE(
    "the widest part of which little is known to stand is walked, and one of too much is refused",
    "[convert][shape]") {
    constexpr std::int32_t kFar = 1 << 25;
    const ColumnBlock all{-kFar, -kFar, kFar, kFar};
    const auto near_by = [](const ColumnBlock& b) {
        return b.min_bx < 10 && b.max_bx > -10 && b.min_bz < 3 && b.max_bz > 2;
    };
    const Columns columns(all, 8, near_by);
    CHECK(columns.count() == 4 * 64);
    CHECK(columns.at(0).bx == -16);
    CHECK(columns.at(0).bz == 0);
    CHECK_THROWS_AS(Columns(all, 8, [](const ColumnBlock&) { return true; }), util::UsageError);
}

TEST_CASE("each voxel of a box is visited once, with its attributes", "[convert][shape]") {
    const auto world = test::lumps(GENERATE(1u, 2u), 7);
    for (const voxel::BoxKey key :
         {voxel::BoxKey{0, 0, 0, 0}, voxel::BoxKey{0, -1, -1, 0}, voxel::BoxKey{0, 1, 1, 1}}) {
        const auto box = world->box(key);
        if (!box)
            continue;
        INFO(voxel::to_string(key));
        std::vector<int> visits(64 * 256 * 64);
        std::size_t wrong = 0;
        const auto visit = [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
            ++visits[static_cast<std::size_t>((y * 64 + z) * 64 + x)];
            if (box->voxel(x, y, z) != attr)
                ++wrong;
        };
        each_voxel(*box, visit, [&](int x0, int y0, int z0, int edge) {
            for (int y = y0; y < y0 + edge; ++y)
                for (int z = z0; z < z0 + edge; ++z)
                    for (int x = x0; x < x0 + edge; ++x)
                        visit(x, y, z, {});
        });
        for (int y = 0; y < 256; ++y)
            for (int z = 0; z < 64; ++z)
                for (int x = 0; x < 64; ++x)
                    if (visits[static_cast<std::size_t>((y * 64 + z) * 64 + x)] !=
                        (box->solid(x, y, z) ? 1 : 0))
                        ++wrong;
        CHECK(wrong == 0);
    }
}

TEST_CASE("what is spooled is read back, and leaves no file", "[convert][shape]") {
    test::TemporaryFolder folder;
    {
        ByteFile spool = ByteFile::spool_for(folder.path() / "a.vox");
        CHECK(test::files_in(folder.path()).empty());
        std::string text;
        for (int i = 0; i < 200000; ++i)
            text += std::to_string(i);
        spool.put(text);
        spool.put_value(std::uint32_t{0x01020304});
        std::string middle(100, ' ');
        spool.read(700000, std::as_writable_bytes(std::span(middle)));
        CHECK(middle == text.substr(700000, 100));
        ByteFile to(folder.path() / "b", "b");
        to.put("head");
        spool.copy_to(to);
        to.close();
        CHECK(test::read_content(folder.path() / "b") == "head" + text + "\x04\x03\x02\x01");
    }
    CHECK(test::files_in(folder.path()) == std::set<std::string>{"b"});
    std::string beyond(10, ' ');
    ByteFile short_one = ByteFile::spool_for(folder.path() / "c");
    short_one.put("abc");
    CHECK_THROWS_AS(short_one.read(0, std::as_writable_bytes(std::span(beyond))), util::Error);
}

TEST_CASE("the side-car leads from the file to the world", "[convert][shape]") {
    const auto world = test::lumps(1, 0);
    test::ExportJob e(*world, {{-70, -12, -9}, {31, 40, 80}}, "a.glb");
    util::AtomicFile file(e.job.out);
    util::write_file_atomically(file.temporary_path(), "a mesh");
    finish_file(e.job, file);
    CHECK(test::read_content(e.job.out) == "a mesh");
    const auto car = voxel::side_car_from_json(
        test::read_content(e.folder.path() / "a.glb.georef.json"), "the side-car");
    CHECK(car.offset == std::array<std::int32_t, 3>{-20, -12, 35});
    CHECK(car.offset == make_origin(e.job.part));
    CHECK(car.world.crs == "EPSG:3794");
    CHECK(car.world.voxel_m == 0.5);
    CHECK(e.job.files().size() == 2);
}
