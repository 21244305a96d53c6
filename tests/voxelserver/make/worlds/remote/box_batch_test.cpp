#include "voxelserver/make/worlds/remote/batch_client.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/remote/batch_bytes.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::last_record;
using terravox::test::record;

namespace {

constexpr std::size_t kMax_bytes = 1000;

struct Taken {
    voxel::BoxKey key;
    std::uint32_t status = 0;
    std::string payload;
    friend bool operator==(const Taken&, const Taken&) = default;
};

/// @param cut says where the next part ends, at most at `left`
template <class Cut>
std::vector<Taken> collect_taken(remote::BatchStream& stream, std::string_view bytes,
                                 const Cut& cut) {
    std::vector<Taken> out;
    while (!bytes.empty()) {
        const std::size_t size = cut(bytes.size());
        stream.feed(std::as_bytes(std::span(bytes.substr(0, size))),
                    [&](const remote::BatchRecord& r) {
                        out.push_back(
                            {r.key,
                             r.status,
                             {reinterpret_cast<const char*>(r.payload.data()), r.payload.size()}});
                    });
        bytes.remove_prefix(size);
    }
    return out;
}

std::vector<Taken> collect_taken(remote::BatchStream& stream, const std::string& bytes) {
    return collect_taken(stream, bytes, [](std::size_t left) { return left; });
}

}  // namespace

TEST_CASE("records are the same in parts of any size", "[raytracer][batch]") {
    const std::vector<Taken> wanted = {
        {{0, 1, -2, 3}, 200, std::string(999, 'x')},
        {{3, -7, 0, 0}, 204, ""},
        {{0, -2147483647 - 1, 5, 2147483647}, 500, "the disk is gone"}};
    std::string bytes;
    for (const Taken& t : wanted)
        bytes += record(t.key, t.status, t.payload);
    bytes += last_record(wanted.size());
    for (const std::uint32_t seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
        INFO("seed " << seed);
        std::minstd_rand random(seed);
        remote::BatchStream stream(wanted.size(), kMax_bytes);
        const auto taken = collect_taken(stream, bytes, [&](std::size_t left) {
            return std::min<std::size_t>(left, 1 + random() % (seed * 40));
        });
        CHECK(taken == wanted);
        CHECK(stream.whole());
    }
}

TEST_CASE("a stream that is cut anywhere gives what came, and is not whole", "[raytracer][batch]") {
    const std::string first = record({0, 1, 2, 3}, 200, "abc");
    const std::string second = record({0, 1, 2, 4}, 204, "");
    const std::string all = first + second + last_record(2);
    for (std::size_t size = 0; size < all.size(); ++size) {
        INFO(size << " of " << all.size() << " bytes");
        remote::BatchStream stream(2, kMax_bytes);
        CHECK(collect_taken(stream, all.substr(0, size)).size() ==
              (size >= first.size() + second.size() ? 2u
               : size >= first.size()               ? 1u
                                                    : 0u));
        CHECK_FALSE(stream.whole());
    }
}

TEST_CASE("bytes that are no batch are refused, however they come", "[raytracer][batch]") {
    const std::string one = record({0, 1, 2, 3}, 204, "");
    struct Case {
        const char* name;
        std::string bytes;
        const char* said;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"a record that is too long", record({0, 0, 0, 0}, 200, std::string(kMax_bytes + 1, 'x')),
         "a record of 1001 bytes; allowed: up to 1000"},
        {"one that says so, without its bytes",
         record({0, 0, 0, 0}, 200, std::string(kMax_bytes + 1, 'x')).substr(0, 24),
         "a record of 1001 bytes"},
        {"more boxes than were requested", one + one + one, "more than the 2 boxes"},
        {"the end too early", one + last_record(2), "a last record after 1 boxes"},
        {"the end of another batch", one + one + last_record(3), "that states 3"},
        {"an end of fewer than none", one + one + record({-1, -2, 0, 0}, 0, ""), "that states -2"},
        {"an end with bytes", one + one + record({-1, 2, 0, 0}, 0, "x"), "a last record"},
        {"an end with a status", one + one + record({-1, 2, 0, 0}, 200, ""), "a last record"},
        {"bytes after the end", one + one + last_record(2) + "x", "bytes after the last record"},
        {"a record after the end", one + one + last_record(2) + one, "bytes after the last record"},
        {"a page", std::string(100, '<'), "a record of"},
    }));
    DYNAMIC_SECTION(c.name) {
        for (const std::size_t step : {std::size_t{1}, std::size_t{7}, std::size_t{100'000}}) {
            remote::BatchStream stream(2, kMax_bytes);
            const auto feed = [&] {
                (void)collect_taken(stream, c.bytes,
                                    [&](std::size_t left) { return std::min(left, step); });
            };
            CHECK_THROWS_WITH(feed(), contains("read a batch of boxes: ") && contains(c.said));
        }
    }
}
