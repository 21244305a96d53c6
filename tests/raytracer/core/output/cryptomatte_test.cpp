#include "raytracer/core/output/cryptomatte.hpp"

#include <bit>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("names are hashed as MurmurHash3 says", "[raytracer][output][cryptomatte]") {
    struct Case {
        const char* text;
        std::uint32_t seed;
        std::uint32_t hash;
    };
    // The first ones are test vectors of the algorithm, the last two stand in manifests of other
    // programs.
    for (const Case c : {Case{"", 0, 0},
                         {"", 1, 0x514e28b7},
                         {"test", 0, 0xba6bd213},
                         {"Hello, world!", 0, 0xc0363e43},
                         {"The quick brown fox jumps over the lazy dog", 0, 0x2e4ff723},
                         {"bunny", 0, 0x13851a76},
                         {"default", 0, 0x42c9679f}}) {
        INFO("'" << c.text << "' seed " << c.seed);
        CHECK(output::murmur3_32(c.text, c.seed) == c.hash);
    }
}

TEST_CASE("the id of a name is always an ordinary float", "[raytracer][output][cryptomatte]") {
    int changed = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::string name = "square " + std::to_string(i);
        const std::uint32_t hash = output::murmur3_32(name);
        const std::uint32_t id = output::cryptomatte_id(name);
        INFO(name);
        const bool ordinary = std::isnormal(std::bit_cast<float>(hash));
        CHECK_FALSE(!std::isnormal(std::bit_cast<float>(id)));
        CHECK_FALSE(id != (ordinary ? hash : hash ^ 0x00800000u));
        changed += ordinary ? 0 : 1;
    }
    CHECK(changed > 50);  // one of 128
}

TEST_CASE("ranks stand by share, things of one name together, and unnamed ones as unknown",
          "[raytracer][output][cryptomatte]") {
    const output::Cryptomatte mattes("CryptoSquare", {"462_101", "463_101", "462_101"});
    tiles::Matte matte;
    matte.add(0, 0.2f);
    matte.add(1, 0.4f);
    matte.add(2, 0.1f);
    matte.add(77, 0.15f);
    matte.add(1, 0.05f);
    const auto ranks = mattes.find_ranks(matte);
    const auto id = [](const char* name) {
        return std::bit_cast<float>(output::cryptomatte_id(name));
    };
    CHECK(ranks[0] == id("463_101"));
    CHECK(ranks[1] == Approx(0.45));
    CHECK(ranks[2] == id("462_101"));
    CHECK(ranks[3] == Approx(0.3));
    CHECK(ranks[4] == id("unknown"));
    CHECK(ranks[5] == Approx(0.15));
    for (std::size_t i = 6; i < ranks.size(); ++i)
        CHECK(ranks[i] == 0);
}

TEST_CASE("the manifest names each id, whatever the names hold",
          "[raytracer][output][cryptomatte]") {
    const std::string odd = "\"Žabnica\"\n\\";
    const std::string broken = "\xff\xfe";
    const output::Cryptomatte mattes("CryptoMaterial", {"water", odd, broken});
    std::string manifest;
    for (const auto& [key, value] : mattes.metadata()) {
        // 7 digits of the hash of the type's name.
        CHECK(key.substr(0, 20) == "cryptomatte/" + [] {
            char t[9];
            std::snprintf(t, sizeof t, "%08x", output::murmur3_32("CryptoMaterial"));
            return std::string(t, 7);
        }() + "/");
        if (key.ends_with("/manifest"))
            manifest = value;
    }
    const auto json = nlohmann::json::parse(manifest);
    CHECK(json.size() == 4);
    char id[9];
    std::snprintf(id, sizeof id, "%08x", output::cryptomatte_id(odd));
    CHECK(json.at(odd) == id);
    CHECK(json.contains("water"));
    CHECK(json.contains("unknown"));
}
