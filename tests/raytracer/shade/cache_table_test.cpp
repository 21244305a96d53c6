#include "raytracer/shade/cache_table.hpp"

#include <cstdint>
#include <thread>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

shade::FaceCell cell(int i) {
    return {{i, -i, i / 7}, i % 5, static_cast<core::Face>(i % 6), i % 2 == 0};
}

/// A value that shows which key it was inserted for.
std::uint64_t value_of(const shade::FaceCell& key) {
    return key.hash();
}

}  // namespace

TEST_CASE("a cell keeps its parts apart and gives them back", "[raytracer][shade][light]") {
    const shade::FaceCell face({-5, 70'000, 1 << 30}, 19, core::Face::kSouth, true);
    const shade::FaceCell part = face.part(4, 15, 9);
    CHECK(part.level() == 19);
    CHECK(part.face() == core::Face::kSouth);
    CHECK(part.fine());
    CHECK(part.split() == 4);
    CHECK(part.u() == 15);
    CHECK(part.v() == 9);
    const shade::FaceCell key = part.light(64, true);
    CHECK(key.bounces() == 64);
    CHECK(key.seen());
    CHECK(key.cell() == part);
    CHECK_FALSE(key == part.light(64, false));
    CHECK_FALSE(key == part.light(63, true));
    CHECK(part.light(100'000, false).bounces() == shade::FaceCell::kMaxBounces);
    CHECK_FALSE(shade::FaceCell{}.used());
    CHECK(face.used());
}

TEST_CASE("a table of any size gives back what was inserted, or nothing",
          "[raytracer][shade][light]") {
    for (const std::size_t limit_bytes :
         {std::size_t{0}, std::size_t{5000}, std::size_t{1} << 20}) {
        shade::CacheTable<std::uint64_t> table(limit_bytes);
        constexpr int kCells = 3000;
        int found = 0;
        for (int i = 0; i < kCells; ++i) {
            table.insert(cell(i), value_of(cell(i)));
            std::uint64_t value = 0;
            REQUIRE(table.find(cell(i), value));  // the last one is there
            REQUIRE(value == value_of(cell(i)));
        }
        for (int i = 0; i < kCells; ++i) {
            std::uint64_t value = 0;
            if (!table.find(cell(i), value))
                continue;
            ++found;
            REQUIRE(value == value_of(cell(i)));
        }
        INFO(limit_bytes << " bytes");
        CHECK(found > 0);
        // A place takes 24 bytes; at least one group of four is kept.
        CHECK(found <= static_cast<int>(std::max<std::size_t>(limit_bytes / 24, 4)));
        if (limit_bytes == std::size_t{1} << 20)
            CHECK(found > kCells * 9 / 10);
    }
}

TEST_CASE("a table gives each of several threads whole values", "[raytracer][shade][light]") {
    shade::CacheTable<std::uint64_t> table(20'000);
    std::vector<int> wrong(4, 0);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < wrong.size(); ++t)
        threads.emplace_back([&table, &wrong, t] {
            for (int i = 0; i < 20'000; ++i) {
                const shade::FaceCell key = cell(i * static_cast<int>(t + 1) % 1500);
                std::uint64_t value = 0;
                if (!table.find(key, value))
                    table.insert(key, value_of(key));
                else if (value != value_of(key))
                    ++wrong[t];
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    for (const int count : wrong)
        CHECK(count == 0);
}
