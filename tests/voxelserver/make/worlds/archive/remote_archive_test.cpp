// Archives on web servers, some of which change while they are read.
#include "voxelserver/make/worlds/archive/archive_kind.hpp"

#include <atomic>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/remote/served_archive.hpp"

using namespace terravox;
using terravox::test::archive_bytes;
using terravox::test::BadServer;
using terravox::test::contains;
using terravox::test::Deed;
using terravox::test::part_of_archive;
using terravox::test::to_box;

namespace {

constexpr int kBoxes = test::kArchiveBoxes;

std::unique_ptr<voxel::World> open(const BadServer& server, int timeout_s = 600) {
    return voxel::open_archive(
        worlds::remote_archive(server.url() + "/a.tvx", std::chrono::seconds(timeout_s)));
}

// Far behind what opening reads, so that each read is a request.
constexpr voxel::BoxKey kBefore{0, 250, 0, 0};
constexpr voxel::BoxKey kAfter{0, 260, 0, 0};
constexpr voxel::BoxKey kLast{0, 270, 0, 0};

const std::string kMonday = "Last-Modified: Mon, 05 Jan 2026 10:00:00 GMT\r\n";
const std::string kTuesday = "Last-Modified: Tue, 06 Jan 2026 10:00:00 GMT\r\n";

std::string etag(const std::string& text) {
    return "ETag: " + text + "\r\n";
}
std::string whole_size(std::size_t bytes) {
    return "Content-Range: bytes 0-1/" + std::to_string(bytes) + "\r\n";
}

/// Gives out parts of the archive with some headers, then with others.
class ChangingServer {
public:
    ChangingServer(std::string first, std::string later)
        : m_first(std::move(first)),
          m_later(std::move(later)),
          m_server([this](const std::string&, int, const std::string& range) {
              Deed deed = part_of_archive(range);
              deed.headers = m_changed ? m_later : m_first;
              return deed;
          }) {}
    void change() { m_changed = true; }
    [[nodiscard]] std::string url() const { return m_server.url() + "/a.tvx"; }
    [[nodiscard]] int requests() const { return m_server.requests("/a.tvx"); }
    [[nodiscard]] std::vector<std::string> heads() const { return m_server.heads(); }
    [[nodiscard]] std::unique_ptr<voxel::World> open() const { return ::open(m_server); }

private:
    const std::string m_first;
    const std::string m_later;
    std::atomic<bool> m_changed{false};
    BadServer m_server;
};

bool same(const std::shared_ptr<const voxel::Box>& box, const voxel::BoxKey& key) {
    return box && box->checksum() == to_box(key)->checksum();
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
        CHECK((world->box({0, i, 0, 0})->checksum() == to_box({0, i, 0, 0})->checksum()));
    CHECK(world->box({0, 5, 1, 0}) == nullptr);
    CHECK(sent < archive_bytes().size() / 2);
    CHECK(server.requests("/a.tvx") <= 8);  // head, root, a leaf, boxes that the head did not hold
}

TEST_CASE("an archive whose address redirects is read where it leads to, with each request",
          "[raytracer][world][remote_archive]") {
    BadServer store([&](const std::string& path, int, const std::string& range) {
        return path == "/b.tvx?key=1" ? part_of_archive(range) : test::problem(403);
    });
    std::atomic<bool> is_gone{false};
    BadServer server([&](const std::string&, int, const std::string&) {
        return Deed{.status = 302,
                    .body = "See elsewhere.",
                    .headers = "Location: " + store.url() +
                               (is_gone ? "/gone.tvx?key=2" : "/b.tvx?key=1") + "\r\n"};
    });
    const auto world = open(server);
    CHECK(same(world->box(kBefore), kBefore));
    CHECK(server.requests("/a.tvx") == store.requests("/b.tvx?key=1"));
    is_gone = true;
    CHECK_THROWS_WITH(world->box(kLast), contains("403") && contains(server.url() + "/a.tvx") &&
                                             contains(store.url() + "/gone.tvx") &&
                                             !contains("key"));
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
    CHECK_THROWS_WITH(
        worlds::remote_archive(nothing.url() + "/a.tvx?hush", std::chrono::seconds(1)),
        contains("a.tvx'") && !contains("hush"));
}

TEST_CASE("a small archive that comes whole is as good", "[raytracer][world][remote_archive]") {
    const test::TemporaryFolder folder;
    voxel::WorldInfo info;
    info.title = "small";
    info.bounds = {{0, 0, 0}, {64, 256, 64}};
    voxel::ArchiveWriter writer(folder.path() / "a.tvx", info, 0);
    writer.finish();
    const std::string bytes = test::read_content(folder.path() / "a.tvx");
    BadServer server([&](const std::string&, int, const std::string&) {
        return Deed{.status = 200, .type = "application/octet-stream", .body = bytes};
    });
    CHECK(open(server)->info().title == "small");
}

TEST_CASE("an archive that changes on its web server is detected by the validators of its replies",
          "[raytracer][world][remote_archive]") {
    struct Case {
        const char* name;
        std::string first;
        std::string later;
        bool differs;
    };
    const std::size_t size = archive_bytes().size();
    const std::string longest(500, 'x'), too_long(4000, 'x');
    const auto c = GENERATE_COPY(values<Case>({
        {"another entity tag", etag(R"("a")"), etag(R"("b")"), true},
        {"another long entity tag", etag('"' + longest + '"'), etag('"' + longest + "y\""), true},
        {"another weak entity tag", etag(R"(W/"a")"), etag(R"(W/"b")"), true},
        {"a weak entity tag that becomes strong", etag(R"(W/"a")"), etag(R"("a")"), false},
        {"another date alone", kMonday, kTuesday, true},
        {"another date, same entity tag", etag(R"("a")") + kMonday, etag(R"("a")") + kTuesday,
         false},
        {"same date, another entity tag", etag(R"("a")") + kMonday, etag(R"("b")") + kMonday, true},
        {"no validators", "", "", false},
        {"another size alone", whole_size(size), whole_size(size + 1), true},
        {"another size, same entity tag", etag(R"("a")") + whole_size(size),
         etag(R"("a")") + whole_size(size - 1), true},
        {"an unreadable size", whole_size(size), "Content-Range: bytes 0-1/much\r\n", false},
        {"an entity tag that goes", etag(R"("a")"), "", true},
        {"a date that goes", kMonday, "", true},
        {"an entity tag that goes, the date stays", etag(R"("a")") + kMonday, kMonday, false},
        {"an entity tag that goes, another date", etag(R"("a")") + kMonday, kTuesday, true},
        {"an entity tag that comes", "", etag(R"("a")"), false},
        {"a date that comes", "", kMonday, false},
        {"an entity tag in addition to the date", kMonday, etag(R"("a")") + kMonday, false},
        {"entity tags too long to be looked at", etag('"' + too_long + '"'),
         etag('"' + too_long + "y\""), false},
        {"an entity tag that becomes too long", etag(R"("a")"), etag('"' + too_long + '"'), true},
        {"entity tags with control characters", etag("\"a\x01\x1b[2J\""), etag("\"b\x01\""), false},
        {"entity tags with a quote within", etag(R"("a"b")"), etag(R"("b"b")"), false},
        {"dates of no form", "Last-Modified: yesterday\r\n", "Last-Modified: today\r\n", false},
    }));
    DYNAMIC_SECTION(c.name) {
        ChangingServer server(c.first, c.later);
        const auto world = server.open();
        CHECK(same(world->box(kBefore), kBefore));
        const int before = server.requests();
        server.change();
        if (!c.differs) {
            CHECK(same(world->box(kAfter), kAfter));
            return;
        }
        const std::string line = server.url() + " has changed while it was read; start again";
        CHECK_THROWS_WITH(world->box(kAfter), line);
        CHECK(server.requests() == before + 1);  // it was not requested again
        CHECK_THROWS_AS(world->box(kLast), voxel::ChangedError);
        CHECK(server.requests() == before + 1);  // nor is anything else
    }
}

TEST_CASE(
    "a later request names the archive's version with the server's strongest validator, and so "
    "does its edition",
    "[raytracer][world][remote_archive]") {
    struct Case {
        const char* name;
        std::string validators;
        std::string sent;
        std::string edition;
    };
    const std::size_t size = archive_bytes().size();
    const std::string date = "Mon, 05 Jan 2026 10:00:00 GMT";
    const std::string bytes = std::to_string(size) + " bytes";
    const auto c = GENERATE_COPY(values<Case>({
        {"an entity tag with a blank, which none may have", etag(R"("a b")"), "", ""},
        {"a strong entity tag", etag(R"("a,b")"), "If-Match: \"a,b\"\r\n", R"("a,b")"},
        {"a strong entity tag and a date", etag(R"("a")") + kMonday, "If-Match: \"a\"\r\n",
         R"("a")"},
        {"a strong entity tag and a size", etag(R"("a")") + whole_size(size), "If-Match: \"a\"\r\n",
         R"("a", )" + bytes},
        {"a weak entity tag", etag(R"(W/"a")"), "", R"(W/"a")"},
        {"a weak entity tag and a date", etag(R"(W/"a")") + kMonday,
         "If-Unmodified-Since: " + date + "\r\n", R"(W/"a")"},
        {"a date", kMonday, "If-Unmodified-Since: " + date + "\r\n", date},
        {"a size", whole_size(size), "", bytes},
        {"nothing", "", "", ""},
        {"an entity tag with control characters", etag("\"a\x01\""), "", ""},
    }));
    DYNAMIC_SECTION(c.name) {
        ChangingServer server(c.validators, "");
        const auto world = server.open();
        CHECK(world->edition() == c.edition);
        CHECK(same(world->box(kBefore), kBefore));
        const auto heads = server.heads();
        REQUIRE(heads.size() >= 2);
        CHECK_THAT(heads.front(), !contains("If-"));
        for (std::size_t i = 1; i < heads.size(); ++i) {
            if (c.sent.empty())
                CHECK_THAT(heads[i], !contains("If-"));
            else
                CHECK_THAT(heads[i], contains("\r\n" + c.sent));
            CHECK_THAT(heads[i], contains("Range: bytes=") && contains("Accept-Encoding: zstd"));
        }
    }
}

TEST_CASE("a server that refuses what has changed, or has another range of it, ends the reading",
          "[raytracer][world][remote_archive]") {
    struct Case {
        const char* name;
        std::string validators;
        Deed later;
        const char* said;
    };
    const std::string a = etag(R"("a")");
    const std::string b = etag(R"("b")");
    const std::string size = whole_size(archive_bytes().size());
    const Deed whole{.status = 200, .type = "application/octet-stream", .body = archive_bytes()};
    const auto with = [](Deed deed, const std::string& headers) {
        return deed.headers = headers, deed;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"412", a, test::problem(412), "has changed while it was read; start again"},
        {"412 for a date", kMonday, test::problem(412),
         "has changed while it was read; start again"},
        {"412 to an unconditional request", "", test::problem(412), "HTTP status 412"},
        {"416 of a shorter file", a + size, test::problem(416, a + "Content-Range: bytes */5\r\n"),
         "has changed while it was read"},
        {"416 of the same file", a + size, test::problem(416, a + size), "HTTP status 416"},
        {"200 with another entity tag", a, with(whole, b), "has changed while it was read"},
        {"200 with the same entity tag", a, with(whole, a), "does not support range requests"},
        {"200 without one", a, whole, "has changed while it was read"},
        {"200 without any validator", "", whole, "does not support range requests"},
        {"a small 200 of another size",
         a + size,
         {.status = 200, .type = "x/y", .body = "tiny", .headers = a},
         "has changed while it was read"},
        {"404", a, test::problem(404), "HTTP status 404"},
    }));
    DYNAMIC_SECTION(c.name) {
        std::atomic<bool> later{false};
        BadServer server([&](const std::string&, int, const std::string& range) {
            return later ? c.later : with(part_of_archive(range), c.validators);
        });
        const auto world = open(server);
        CHECK(same(world->box(kBefore), kBefore));
        const int before = server.requests("/a.tvx");
        later = true;
        CHECK_THROWS_WITH(world->box(kAfter), contains("/a.tvx") && contains(c.said));
        CHECK(server.requests("/a.tvx") == before + 1);
    }
}

TEST_CASE("a change is seen through replies that are late, busy or damaged",
          "[raytracer][world][remote_archive]") {
    std::atomic<bool> later{false};
    int since = 0;
    BadServer server([&](const std::string&, int, const std::string& range) {
        Deed deed = part_of_archive(range);
        deed.headers = etag(later ? R"("b")" : R"("a")");
        if (!later)
            return deed;
        ++since;
        if (since == 1)
            return test::problem(503, "Retry-After: 0\r\n");
        if (since == 2)
            deed.lost = deed.body.size() / 2;
        if (since == 3)
            deed.late = std::chrono::milliseconds(150);
        return deed;
    });
    const auto world = open(server);
    later = true;
    CHECK_THROWS_AS(world->box(kAfter), voxel::ChangedError);
    CHECK(since == 3);
}

TEST_CASE("an archive that changes while it is opened is no archive",
          "[raytracer][world][remote_archive]") {
    BadServer server([&](const std::string&, int n, const std::string& range) {
        Deed deed = part_of_archive(range);
        deed.headers = etag('"' + std::to_string(n) + '"');
        return deed;
    });
    CHECK_THROWS_AS(open(server), voxel::ChangedError);
}
