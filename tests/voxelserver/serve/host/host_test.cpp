#include "voxelserver/serve/host/host.hpp"

#include <algorithm>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "tests/catch.hpp"
#include "tests/voxelserver/serve/host/http_client.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "voxelserver/serve/http/router.hpp"

using namespace terravox;
using test::HttpClient;
using test::HttpReply;

namespace {

// A client of a test may be held up for long between two of its requests: no connection times out.
http::HostOptions local() {
    http::HostOptions o;
    o.port = 0;
    o.request_timeout = o.keep_alive_timeout = std::chrono::minutes(5);
    return o;
}

struct ServerFixture {
    explicit ServerFixture(const http::HostOptions& options = local()) : server(router, options) {}
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes{world, times, {.makers = 4, .queue = 64, .ahead = false}};
    http::Router router{http::Service{world, times, boxes}};
    http::Host server;
};

std::string header(const HttpReply& r, const std::string& name) {
    const auto at = r.headers.find(name);
    return at == r.headers.end() ? "" : at->second;
}

}  // namespace

TEST_CASE("a connection serves several requests, one after the other or at once",
          "[voxelserver][http][server]") {
    ServerFixture f;
    HttpClient client(f.server.port());
    const HttpReply world = client.get("/v2/world");
    CHECK(world.status == 200);
    CHECK(header(world, "connection") == "keep-alive");
    const HttpReply box = client.get("/v2/boxes/0/0/0/0?ignored=1");
    CHECK(box.status == 200);
    CHECK(
        client.get("/v2/boxes/0/0/0/0", "If-None-Match: " + header(box, "etag") + "\r\n").status ==
        304);
    CHECK(client.get("/v2/boxes/0/0/1/0").status == 204);
    const HttpReply head = client.get("/v2/boxes/0/0/0/0", "", "HEAD");
    CHECK(header(head, "content-length") == std::to_string(box.body.size()));
    CHECK(client.get("/nothing", "", "HEAD").status == 404);
    CHECK(client.get("/nothing").status == 404);

    client.send(
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
        "GET /v2/boxes/0/0/0/0 HTTP/1.1\r\nHost: localhost\r\n\r\n");
    CHECK(client.read_reply()->body == "ok\n");
    CHECK((client.read_reply()->body == box.body));

    CHECK(header(client.get("/healthz", "Connection: close\r\n"), "connection") == "close");
    CHECK(client.read_to_end().empty());
    HttpClient with_body(f.server.port());
    with_body.send("HEAD /v2/world HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n");
    CHECK(with_body.read_reply(true)->status == 413);
    CHECK(with_body.read_to_end().empty());
    HttpClient old(f.server.port());
    old.send("GET /healthz HTTP/1.0\r\n\r\n");
    CHECK(header(*old.read_reply(), "connection") == "close");
    CHECK(old.read_to_end().empty());
}

TEST_CASE("what is no proper request is refused with a problem, and the connection closed",
          "[voxelserver][http][server]") {
    struct Case {
        const char* name;
        std::string bytes;
        int status;
    };
    std::string many_headers = "GET / HTTP/1.1\r\n";
    for (int i = 0; i < 100; ++i)
        many_headers += "X-" + std::to_string(i) + ": 1\r\n";
    const auto c = GENERATE_REF(values<Case>({
        {"noise", "\x01\x02\x03\r\n\r\n", 400},
        {"TLS instead of HTTP",
         std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 15), 400},
        {"no version", "GET /\r\n\r\n", 400},
        {"unknown method", "BREW / HTTP/1.1\r\n\r\n", 400},
        {"another version", "GET / HTTP/3.0\r\n\r\n", 505},
        {"a header without colon", "GET / HTTP/1.1\r\nnonsense\r\n\r\n", 400},
        {"a long address", "GET /" + std::string(20000, 'a') + " HTTP/1.1\r\n\r\n", 400},
        {"a long header", "GET / HTTP/1.1\r\nX: " + std::string(20000, 'a') + "\r\n\r\n", 400},
        {"many headers", many_headers + "\r\n", 431},
        {"a length of 10^12",
         "GET /v2/world HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000000\r\n\r\n", 413},
        {"another Host, and a body",
         "POST /v2/boxes HTTP/1.1\r\nHost: attacker.example\r\nContent-Length: 20\r\n\r\n", 421},
        {"no Host", "GET /v2/world HTTP/1.1\r\n\r\n", 400},
        {"chunks",
         "GET /v2/world HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
         400},
        {"a body that looks like a request",
         "POST /v2/world HTTP/1.1\r\nHost: localhost\r\nContent-Length: 33\r\n\r\nGET "
         "/v2/boxes/0/0/0/0 HTTP/1.1\r\n\r\n",
         413},
    }));
    static ServerFixture f;  // one server for all cases: each must leave it as it was
    DYNAMIC_SECTION(c.name) {
        HttpClient client(f.server.port());
        client.send(c.bytes);
        const auto reply = client.read_reply();
        REQUIRE(reply);
        CHECK(reply->status == c.status);
        CHECK(header(*reply, "content-type") == "application/problem+json");
        CHECK(nlohmann::json::parse(reply->body)["status"] == c.status);
        CHECK(header(*reply, "connection") == "close");
        CHECK(client.read_to_end().empty());
        CHECK(HttpClient(f.server.port()).get("/healthz").status == 200);
        CHECK(f.world.requests == 0);
    }
}

TEST_CASE("a stranger's body is not waited for", "[voxelserver][http][server]") {
    http::HostOptions options = local();
    options.request_timeout = std::chrono::hours(1);
    ServerFixture f;
    http::Router router(http::Service{f.world, f.times, f.boxes}, "s3cret");
    http::Host server(router, options);
    HttpClient client(server.port());
    client.send(
        "POST /v2/boxes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        "Content-Length: 200000\r\nExpect: 100-continue\r\n\r\n");
    const auto reply = client.read_reply();
    REQUIRE(reply);
    CHECK(reply->status == 401);
    CHECK(header(*reply, "connection") == "close");
    CHECK(client.read_to_end().empty());
}

TEST_CASE("every reply says that no other origin may use it", "[voxelserver][http][server]") {
    ServerFixture f;
    HttpClient client(f.server.port());
    for (const char* path : {"/", "/v2/world", "/v2/boxes/0/0/0/0", "/metrics", "/nothing"}) {
        const HttpReply reply = client.get(path);
        INFO(path);
        CHECK(header(reply, "x-content-type-options") == "nosniff");
        CHECK(header(reply, "cross-origin-resource-policy") == "same-origin");
        CHECK(header(reply, "access-control-allow-origin").empty());
    }
}

TEST_CASE("clients that do not finish their requests give their threads to others",
          "[voxelserver][http][server]") {
    http::HostOptions options = local();
    options.request_threads = 4;
    options.request_timeout = std::chrono::hours(1);
    options.keep_alive_timeout = std::chrono::hours(1);
    const std::string half_body =
        "POST /v2/boxes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        "Content-Length: 200\r\n\r\n{";
    struct Case {
        const char* name;
        std::string sent;
        bool replies;
    };
    const auto c = GENERATE_REF(values<Case>({
        {"nothing", "", false},
        {"half a header", "GET /healthz HTTP/1.1\r\nHost: localhost\r\n", false},
        {"half a body", half_body, false},
        {"nothing after a request", "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n", true},
    }));
    DYNAMIC_SECTION(c.name) {
        ServerFixture f(options);
        std::vector<std::unique_ptr<HttpClient>> slow;
        for (int i = 0; i < 20; ++i) {
            slow.push_back(std::make_unique<HttpClient>(f.server.port()));
            slow.back()->send(c.sent);
        }
        if (c.replies)
            for (const auto& client : slow)
                CHECK(client->read_reply());
        for (int i = 0; i < 5; ++i)
            CHECK(HttpClient(f.server.port()).get("/v2/boxes/0/0/0/0").status == 200);
        // Those that are too many were closed, the longest-waiting ones first. Of the idle ones
        // most were closed with their replies, as others waited: which are left cannot be said.
        if (!c.replies)
            CHECK(slow.front()->wait_for_end());
    }
}

TEST_CASE("more connections than threads are all served, and give way to each other",
          "[voxelserver][http][server]") {
    http::HostOptions options = local();
    options.request_threads = 2;
    // With clients of this test, however busy the machine is.
    options.timeout = std::chrono::hours(1);
    ServerFixture f(options);
    std::vector<std::future<int>> ok;
    for (int i = 0; i < 16; ++i)
        ok.push_back(std::async(std::launch::async, [&] {
            int count = 0;
            for (int n = 0; n < 20; ++n)
                count += HttpClient(f.server.port()).get("/v2/boxes/0/0/0/0").status == 200;
            return count;
        }));
    for (auto& o : ok)
        CHECK(o.get() == 20);
}

TEST_CASE("stopping finishes the running request and refuses new ones",
          "[voxelserver][http][server]") {
    ServerFixture f;
    f.world.hold();
    auto running = std::async(std::launch::async,
                              [&] { return HttpClient(f.server.port()).get("/v2/boxes/0/0/0/0"); });
    while (f.world.requests == 0)
        std::this_thread::yield();
    auto stopping = std::async(std::launch::async, [&] { f.server.stop(); });
    while (HttpClient(f.server.port()).get("/healthz").status != 503)
        std::this_thread::yield();
    f.world.release();
    const HttpReply reply = running.get();
    CHECK(reply.status == 200);
    CHECK(std::to_string(reply.body.size()) == header(reply, "content-length"));
    stopping.get();
    CHECK_FALSE(HttpClient(f.server.port()).connected());
    f.server.stop();  // once more changes nothing
}

TEST_CASE("a port in use or an address that is none is an error that names it",
          "[voxelserver][http][server]") {
    ServerFixture f;
    http::HostOptions taken = local();
    taken.port = f.server.port();
    CHECK_THROWS_WITH(
        http::check_can_listen(taken),
        test::contains("127.0.0.1:" + std::to_string(taken.port)) && test::contains("in use"));
    CHECK_THROWS_AS(http::Host(f.router, taken), util::Error);
    for (const char* bind : {"localhost", "127.0.0.1,8080", "", "1.2.3", "127.0.0.1s"}) {
        http::HostOptions bad = local();
        bad.bind = bind;
        INFO(bind);
        CHECK_THROWS_AS(http::check_can_listen(bad), util::UsageError);
    }
}
