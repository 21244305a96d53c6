#include "voxelserver/serve/http/route_answers.hpp"

#include <thread>

#include "common/voxel/box.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "voxelserver/serve/http/router.hpp"

using namespace terravox;

namespace {

struct Record {
    voxel::BoxKey key;
    std::uint32_t status = 0;
    std::string payload;
};

// Written from docs/formats/http.md alone.
std::vector<Record> parse_records(std::string_view bytes) {
    std::vector<Record> out;
    while (!bytes.empty()) {
        REQUIRE(bytes.size() >= 24);
        const auto word = [&](int i) {
            std::uint32_t value = 0;
            for (int b = 0; b < 4; ++b)
                value |= static_cast<std::uint32_t>(
                             static_cast<unsigned char>(bytes[static_cast<std::size_t>(4 * i + b)]))
                         << (8 * b);
            return value;
        };
        Record r{{static_cast<int>(word(0)), static_cast<std::int32_t>(word(1)),
                  static_cast<std::int32_t>(word(2)), static_cast<std::int32_t>(word(3))},
                 word(4),
                 {}};
        REQUIRE(bytes.size() >= 24 + word(5));
        r.payload = bytes.substr(24, word(5));
        bytes.remove_prefix(24 + word(5));
        out.push_back(std::move(r));
    }
    return out;
}

struct BatchFixture {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes{world, times, {.makers = 2, .ahead = false}};
    http::Router router{http::Service{world, times, boxes}};

    http::Response post(const std::string& body, const std::string& type = "application/json") {
        const std::string length = std::to_string(body.size());
        return router.handle(
            {"POST", "/v2/boxes", {{"Content-Type", type}, {"Content-Length", length}}, {}, body});
    }
    std::string stream(const std::string& body) {
        const auto reply = post(body);
        REQUIRE(reply.status == 200);
        REQUIRE(reply.stream);
        CHECK(reply.header("Content-Type") == http::kBatchMediaType);
        std::string out;
        reply.stream([&](std::string_view part) {
            out += part;
            return true;
        });
        return out;
    }
};

}  // namespace

TEST_CASE("a batch gives every requested box, air and failures too, and an end",
          "[voxelserver][http][batch]") {
    BatchFixture f;
    f.world.failing.insert({0, 0, 0, 0});
    const auto records = parse_records(f.stream(
        R"({"boxes": [[0,0,-1,0], [0,0,0,0], [0,1,1,-1], [1,0,-1,0], [0,99,0,0], [0,0,-1,0]]})"));
    REQUIRE(records.size() == 7);
    std::map<voxel::BoxKey, std::vector<Record>> by_key;
    for (const Record& r : records)
        by_key[r.key].push_back(r);
    CHECK(by_key[{0, 0, -1, 0}].size() == 2);
    for (const Record& r : by_key[{0, 0, -1, 0}]) {
        CHECK(r.status == 200);
        CHECK(voxel::decompress_box(std::as_bytes(std::span(r.payload)), "the record")->key() ==
              r.key);
    }
    CHECK(by_key[{0, 0, 0, 0}].at(0).status == 500);
    CHECK(by_key[{0, 0, 0, 0}].at(0).payload.find("damaged") != std::string::npos);
    CHECK(by_key[{0, 1, 1, -1}].at(0).status == 204);
    CHECK(by_key[{1, 0, -1, 0}].at(0).status == 200);
    CHECK(by_key[{0, 99, 0, 0}].at(0).status == 204);
    CHECK(records.back().key == voxel::BoxKey{-1, 6, 0, 0});
    CHECK(records.back().status == 0);
}

TEST_CASE("a batch sends what is ready before what is still being made",
          "[voxelserver][http][batch]") {
    BatchFixture f;
    (void)f.boxes.find_or_make({0, 1, 0, 0});
    f.world.hold();
    std::atomic<int> parts{0};
    const auto reply = f.post(R"({"boxes": [[0,0,0,0], [0,1,0,0]]})");
    std::string out;
    std::thread sending([&] {
        reply.stream([&](std::string_view part) {
            out += part;
            ++parts;
            return true;
        });
    });
    while (parts == 0)
        std::this_thread::yield();
    f.world.release();
    sending.join();
    const auto records = parse_records(out);
    REQUIRE(records.size() == 3);
    CHECK(records[0].key == voxel::BoxKey{0, 1, 0, 0});
}

TEST_CASE("a client that goes away ends its batch", "[voxelserver][http][batch]") {
    BatchFixture f;
    int parts = 0;
    f.post(R"({"boxes": [[0,0,0,0], [0,1,0,0], [0,0,-1,0], [0,1,-1,0]]})")
        .stream([&](std::string_view) {
            ++parts;
            return false;
        });
    CHECK(parts <= 2);  // those of a second lane may have been under way
}

TEST_CASE("a list of boxes that is none is refused in one line", "[voxelserver][http][batch]") {
    BatchFixture f;
    for (const char* body :
         {R"({"boxes": []})", R"({"boxes": [[0,0,0]]})", R"({"boxes": [[0,0,0,0,0]]})",
          R"({"boxes": [[0,0,0,0.5]]})", R"({"boxes": [[0,0,0,"1"]]})", R"({"boxes": [[3,0,0,0]]})",
          R"({"boxes": [[-1,0,0,0]]})", R"({"boxes": [[0,2147483648,0,0]]})",
          R"({"boxes": [[0,18446744073709551615,0,0]]})", R"({"boxes": [[0,1e999,0,0]]})",
          R"({"boxes": 1})", "[]", "{", "\xff\xfe", "[[[[[[[[[[[[[[[["}) {
        INFO(body);
        CHECK(f.post(body).status == 400);
    }
    for (const char* type : {"text/plain", ""})
        CHECK(f.post(R"({"boxes": [[0,0,0,0]]})", type).status == 415);
    std::string many = R"({"boxes": [[0,0,0,0])";
    for (std::size_t i = 0; i < http::kMaxBatchBoxes; ++i)
        many += ",[0,0,0,0]";
    CHECK(f.post(many + "]}").status == 400);
    CHECK(f.post(std::string(100'000, '[')).status == 400);
    CHECK(f.world.requests == 0);
}

TEST_CASE("too many batches at once are refused, and their places come back",
          "[voxelserver][http][batch]") {
    BatchFixture f;
    const std::string body = R"({"boxes": [[0,0,0,0]]})";
    std::vector<http::Response> held;
    for (int i = 0; i < 8; ++i)
        held.push_back(f.post(body));
    for (const auto& r : held)
        CHECK(r.status == 200);
    CHECK(f.post(body).status == 503);
    held.clear();
    CHECK(f.post(body).status == 200);
}
