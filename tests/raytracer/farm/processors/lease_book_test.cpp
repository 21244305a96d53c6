#include "raytracer/farm/processors/lease_book.hpp"

#include <algorithm>
#include <random>
#include <set>

#include "raytracer/core/tiles/tile_codec.hpp"
#include "raytracer/core/tiles/tile_plan.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using Answer = processors::LeaseBook::Answer;
using Time = processors::LeaseBook::Time;

namespace {

/// The correct pixels of a band: a function of the position.
tiles::TileResult made(const tiles::RenderTile& band, float lie = 0) {
    tiles::TileResult out;
    out.tile = band;
    band.each_pixel([&](int x, int y) {
        tiles::PixelSample s;
        s.colour = {static_cast<float>(x), static_cast<float>(y),
                    static_cast<float>(band.first_sample) + lie};
        s.alpha = 1;
        s.depth_m = static_cast<float>(x + y);
        out.samples.push_back(s);
    });
    return out;
}

bool is_right(const tiles::TileResult& whole) {
    const tiles::TileResult wanted = made(whole.tile);
    return whole.samples.size() == wanted.samples.size() &&
           std::equal(whole.samples.begin(), whole.samples.end(), wanted.samples.begin(),
                      [](const tiles::PixelSample& a, const tiles::PixelSample& b) {
                          return a.colour.r == b.colour.r && a.colour.g == b.colour.g &&
                                 a.colour.b == b.colour.b;
                      });
}

std::vector<tiles::RenderTile> plan(int width, int height, int tile) {
    return tiles::plan_tiles(width, height, 1, tile, core::TileOrder::kRows).front();
}

}  // namespace

TEST_CASE("whatever happens to leases, every tile is returned whole, correct and once",
          "[raytracer][sched]") {
    const auto seed = GENERATE(range(1u, 60u));
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const auto any = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    const auto tiles = plan(100 + any(200), 60 + any(200), 16 + any(100));
    processors::LeaseBook book;
    for (const tiles::RenderTile& t : tiles)
        book.add(t);
    struct Held {
        processors::LeaseBook::Member member;
        tiles::RenderTile band;
    };
    std::vector<Held> held;
    std::set<std::uint32_t> whole;
    Time now{};
    for (int step = 0; book.unfinished() > 0; ++step) {
        REQUIRE(step < 200'000);
        now += std::chrono::milliseconds(1 + any(50));
        const auto member = static_cast<processors::LeaseBook::Member>(1 + any(4));
        const int what = any(20);
        if (what < 8) {
            if (const auto band =
                    book.lease(member, static_cast<std::size_t>(1 + any(5000)), now)) {
                CHECK(book.has(member, *band));
                book.set_deadline(member, *band, now + std::chrono::milliseconds(any(400)));
                held.push_back({member, *band});
            }
        } else if (what < 10) {
            const auto open = book.open_leases();
            if (open.empty())
                continue;
            const auto& of = open[static_cast<std::size_t>(any(static_cast<int>(open.size())))];
            if (!of.alone || of.member == member)
                continue;
            held.push_back({member, book.lease_again(member, of.band, now)});
        } else if (what < 17) {
            if (held.empty())
                continue;
            const auto at = held.begin() + any(static_cast<int>(held.size()));
            const Held h = *at;
            held.erase(at);
            const auto taken = book.take(h.member, made(h.band));
            CHECK((taken.answer == Answer::kFirst || taken.answer == Answer::kLate));
            CHECK(book.take(h.member, made(h.band)).answer == Answer::kUnrequested);
            if (taken.whole) {
                CHECK(is_right(*taken.whole));
                CHECK(whole.insert(taken.whole->tile.index).second);
            }
        } else if (what == 17) {
            (void)book.expire(now);
        } else if (what == 18) {
            (void)book.give_back(member);
            std::erase_if(held, [&](const Held& h) { return h.member == member; });
        } else if (!held.empty()) {
            const Held h = held.back();
            held.pop_back();
            book.give_back(h.member, h.band);
        }
    }
    CHECK(whole.size() == tiles.size());
    CHECK(book.pending_pixels() == 0);
    CHECK(book.leased_pixels() == 0);
}

TEST_CASE("a band is about as large as requested, in whole blocks, and never more than a tile",
          "[raytracer][sched]") {
    processors::LeaseBook book;
    const tiles::RenderTile tile{0, 0, 64, 64, 128, 120, 1, false, 0, 0};
    book.add(tile);
    const auto first = book.lease(1, 1000, Time{});
    REQUIRE(first);
    CHECK((first->y0 == 64 && first->y1 == 80 && first->x0 == 64 && first->x1 == 128));
    const auto rest = book.lease(1, 1'000'000, Time{});
    REQUIRE(rest);
    CHECK((rest->y0 == 80 && rest->y1 == 120));
    CHECK_FALSE(book.lease(1, 1, Time{}));
    CHECK(book.measure_load(1).pixels == 64 * 56);
}

TEST_CASE("what a revoked member has made is made again, what others made is kept",
          "[raytracer][sched]") {
    processors::LeaseBook book;
    const auto tiles = plan(64, 32, 32);
    for (const tiles::RenderTile& t : tiles)
        book.add(t);
    const auto by_liar = book.lease(1, 100'000, Time{});
    const auto honest = book.lease(2, 100'000, Time{});
    REQUIRE((by_liar && honest));
    CHECK(book.take(1, made(*by_liar, 5)).whole);
    CHECK(book.take(2, made(*honest)).whole);
    CHECK(book.unfinished() == 0);
    CHECK(book.revoke(1) == std::vector{by_liar->index});
    CHECK(book.unfinished() == 1);
    const auto again = book.lease(2, 100'000, Time{});
    REQUIRE(again);
    CHECK(*again == *by_liar);
    const auto taken = book.take(2, made(*again));
    REQUIRE(taken.whole);
    CHECK(is_right(*taken.whole));
    CHECK_FALSE(book.lease(2, 100'000, Time{}));
}

TEST_CASE("a member whose lease was withdrawn may lease the band again, and its answer counts",
          "[raytracer][sched]") {
    processors::LeaseBook book;
    book.add({0, 0, 0, 0, 32, 32, 1, false, 0, 0});
    const auto band = book.lease(1, 100'000, Time{});
    REQUIRE(band);
    (void)book.lease_again(2, *band, Time{});
    const auto first = book.take(2, made(*band));
    CHECK(first.whole);
    CHECK(first.withdraw == std::vector<processors::LeaseBook::Member>{1});  // it never answers
    (void)book.revoke(2);
    const auto again = book.lease(1, 100'000, Time{});
    REQUIRE(again);
    CHECK(book.take(1, made(*again)).answer == Answer::kFirst);
    CHECK(book.unfinished() == 0);
}

TEST_CASE("holes excuse what a check of them could not see, and nothing else",
          "[raytracer][sched]") {
    const voxel::BoxKey a{0, 0, 0, 0};
    const voxel::BoxKey b{0, 1, 0, 0};
    struct Case {
        const char* name;
        processors::LeaseBook::Holes reported;
        processors::LeaseBook::Holes met;
        float lie;
        Answer answer;
    };
    for (const Case& c :
         {Case{"no hole", {}, {}, 1, Answer::kFalse},
          Case{"the same hole", {a}, {a}, 1, Answer::kFalse},
          Case{"a hole outside of the checked rows", {a, b}, {b}, 1, Answer::kFalse},
          Case{"a reported hole, and none met", {a}, {}, 1, Answer::kFalse},
          Case{"a hole that the member had the box of", {}, {a}, 1, Answer::kUndecided},
          Case{"one of two", {a}, {a, b}, 1, Answer::kUndecided},
          Case{"equal all the same", {}, {a}, 0, Answer::kChecked},
          Case{"equal with the same hole", {a}, {a}, 0, Answer::kChecked}}) {
        INFO(c.name);
        processors::LeaseBook book;
        book.add({0, 0, 0, 0, 32, 32, 1, false, 0, 0});
        const auto band = book.lease(1, 100'000, Time{});
        REQUIRE(band);
        tiles::TileResult result = made(*band, c.lie);
        result.holes = c.reported;
        const std::uint64_t hash = tiles::hash_of_pixels(result);
        CHECK(book.take(1, std::move(result)).answer == Answer::kFirst);
        book.check(1, *band, hash, c.reported);
        const auto check = book.lease_check(2, Time{});
        REQUIRE(check);
        tiles::TileResult again = made(*check);
        again.holes = c.met;
        CHECK(book.take(2, std::move(again)).answer == c.answer);
        CHECK(book.open_checks() == 0);
    }
}

TEST_CASE("two answers that differ are unequal whatever holes they report", "[raytracer][sched]") {
    const voxel::BoxKey hole{0, 0, 0, 0};
    processors::LeaseBook book;
    book.add({0, 0, 0, 0, 32, 32, 1, false, 0, 0});
    const auto band = book.lease(1, 100'000, Time{});
    REQUIRE(band);
    (void)book.lease_again(2, *band, Time{});
    tiles::TileResult first = made(*band, 1);
    tiles::TileResult second = made(*band);
    first.holes = {hole};
    const std::uint64_t first_hash = tiles::hash_of_pixels(first);
    const std::uint64_t second_hash = tiles::hash_of_pixels(second);
    CHECK(book.take(1, std::move(first)).answer == Answer::kFirst);
    const auto taken = book.take(2, std::move(second));
    CHECK(taken.answer == Answer::kUnequal);
    CHECK((taken.other == 1 && taken.other_hash == first_hash && taken.hash == second_hash));
    CHECK((taken.other_holes == processors::LeaseBook::Holes{hole} && taken.holes.empty()));
}

TEST_CASE("a check of a member that was revoked meanwhile settles nothing any more",
          "[raytracer][sched]") {
    processors::LeaseBook book;
    book.add({0, 0, 0, 0, 32, 32, 1, false, 0, 0});
    const auto band = book.lease(1, 100'000, Time{});
    REQUIRE(band);
    (void)book.take(1, made(*band, 1));
    book.check(1, *band, 77, {});
    const auto check = book.lease_check(2, Time{});
    REQUIRE(check);
    (void)book.revoke(1);
    CHECK(book.open_checks() == 0);
    CHECK(book.take(2, made(*check)).answer == Answer::kLate);
    CHECK(book.open_checks() == 0);
    CHECK(book.unfinished() == 1);
}

TEST_CASE("passes follow each other, and the members that contributed to earlier ones are known",
          "[raytracer][sched]") {
    processors::LeaseBook book;
    auto tiles = plan(64, 64, 32);
    for (const unsigned first : {0u, 2u, 4u}) {
        for (tiles::RenderTile t : tiles) {
            t.first_sample = first;
            t.samples = 2;
            book.add(t);
        }
        std::size_t whole = 0;
        while (const auto band = book.lease(1 + first, 700, Time{}))
            if (book.take(1 + first, made(*band)).whole)
                ++whole;
        CHECK(whole == tiles.size());
    }
    CHECK(book.contributed_earlier(1));
    CHECK(book.contributed_earlier(3));
    CHECK_FALSE(book.contributed_earlier(5));
}

TEST_CASE("pixels of a band are those that it visits", "[raytracer][sched]") {
    for (const int step : {1, 2, 4})
        for (const bool refines : {false, true})
            for (int y0 = 0; y0 < 16; y0 += 8) {
                const tiles::RenderTile band{0, 0, 8, y0, 40, 32, step, refines, 0, 0};
                std::size_t n = 0;
                band.each_pixel([&](int, int) { ++n; });
                INFO("step " << step << ", refines " << refines << ", from row " << y0);
                CHECK(processors::LeaseBook::count_pixels(band) == n);
            }
}
