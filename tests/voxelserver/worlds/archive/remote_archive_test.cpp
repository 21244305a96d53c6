#include "voxelserver/worlds/archive/remote_archive.hpp"

#include <fstream>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_world.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/worlds/remote/served_archive.hpp"

using namespace terravox;
using terravox::test::archive_bytes;
using terravox::test::BadServer;
using terravox::test::box_of;
using terravox::test::contains;
using terravox::test::Deed;
using terravox::test::part_of_archive;

namespace {

constexpr int kBoxes = test::kArchiveBoxes;

std::unique_ptr<voxel::World> open(const BadServer& server, int timeout_s = 20) {
    return voxel::open_archive(
        worlds::remote_archive(server.url() + "/a.tvx", std::chrono::seconds(timeout_s)));
}

}  // namespace

TEST_CASE("an archive on a web server gives its boxes by ranges of bytes",
          "[raytracer][world][remote_archive]") {
    std::size_t sent = 0;
    BadServer server([&](const std::string&, int, const std::string& range) {
        Deed deed = part_of_archive(range);
        sent += deed.body.size();
        return deed;
    });
    const auto world = open(server);
    CHECK(world->info().title == "far");
    CHECK(world->useful_concurrency(2) >= 8);
    for (const int i : {0, 1, 150, kBoxes - 1})
        CHECK((world->box({0, i, 0, 0})->checksum() == box_of({0, i, 0, 0})->checksum()));
    CHECK(world->box({0, 5, 1, 0}) == nullptr);
    CHECK(sent < archive_bytes().size() / 2);
    CHECK(server.requests("/a.tvx") <= 8);  // head, root, a leaf, boxes that the head did not hold
}

TEST_CASE("a late, busy, broken or damaged reply is requested again",
          "[raytracer][world][remote_archive]") {
    struct Case {
        const char* name;
        Deed (*spoil)(Deed);
    };
    const auto c = GENERATE(values<Case>({
        {"busy", [](Deed) { return test::problem(503, "Retry-After: 0\r\n"); }},
        {"busy, at length",
         [](Deed) {
             return Deed{.status = 503,
                         .type = "text/html",
                         .body = std::string(90000, 'x'),
                         .headers = "Retry-After: 0\r\n"};
         }},
        {"cut short", [](Deed d) { return d.lost = d.body.size() / 2, d; }},
        {"late", [](Deed d) { return d.late = std::chrono::milliseconds(150), d; }},
    }));
    DYNAMIC_SECTION(c.name) {
        BadServer server([&](const std::string&, int n, const std::string& range) {
            const Deed good = part_of_archive(range);
            return n % 2 == 0 ? c.spoil(good) : good;
        });
        const auto world = open(server);
        CHECK((world->box({0, 77, 0, 0})->checksum() == box_of({0, 77, 0, 0})->checksum()));
    }
}

TEST_CASE("a server that sends whole files only is recognised, and one that has no such file",
          "[raytracer][world][remote_archive]") {
    BadServer whole([](const std::string&, int, const std::string&) {
        return Deed{.status = 200, .type = "application/octet-stream", .body = archive_bytes()};
    });
    CHECK_THROWS_WITH(open(whole), contains("range requests"));
    BadServer nothing(
        [](const std::string&, int, const std::string&) { return test::problem(404); });
    CHECK_THROWS_WITH(open(nothing), contains("404"));
    CHECK_THROWS_AS(worlds::remote_archive("ftp://127.0.0.1/a.tvx", std::chrono::seconds(1)),
                    util::UsageError);
}

TEST_CASE("a small archive that comes whole is as good", "[raytracer][world][remote_archive]") {
    const test::TemporaryFolder folder;
    voxel::WorldInfo info;
    info.title = "small";
    info.bounds = {{0, 0, 0}, {64, 256, 64}};
    voxel::ArchiveWriter writer(folder.path() / "a.tvx", info, 0);
    writer.finish();
    std::ifstream in(folder.path() / "a.tvx", std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    BadServer server([&](const std::string&, int, const std::string&) {
        return Deed{.status = 200, .type = "application/octet-stream", .body = bytes};
    });
    CHECK(open(server)->info().title == "small");
}

TEST_CASE("an archive's address holds no secret that messages would show",
          "[raytracer][world][remote_archive]") {
    BadServer server(
        [](const std::string&, int, const std::string& range) { return part_of_archive(range); });
    const std::string url = server.url() + "/a.tvx";
    for (const std::string& signed_url :
         {url + "?signature=hush", url + "#hush", "http://me:hush@" + url.substr(7)}) {
        CHECK_THROWS_AS(worlds::remote_archive(signed_url, std::chrono::seconds(1)),
                        util::UsageError);
        CHECK_THROWS_WITH(worlds::remote_archive(signed_url, std::chrono::seconds(1)),
                          contains("a.tvx'") && !contains("hush"));
    }
    CHECK(server.heads().empty());
}
