#include "raytracer/farm/processors/pool_results.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/farm/processors/pool_parts.hpp"

using namespace terravox;
using namespace terravox::test;
using processors::LeaseBook;
using processors::MemberId;
using processors::ResultValidator;
using Answer = LeaseBook::Answer;

namespace {

const LeaseBook::Holes kHole{voxel::BoxKey{0, 1, 2, 3}};

/// A validator with its book and its members, and one tile of sixteen rows to compute.
struct ValidatorBench {
    LeaseBook book;
    processors::MemberRegistry members;
    ResultValidator validator;

    explicit ValidatorBench(int check_every)
        : validator(book, members, processors::CheckPolicy(check_every, 1)) {
        book.add(tile_of_rows(0, 16));
    }
    MemberId add(processors::MemberSpec spec) {
        return members.add(std::move(spec), false, at_s(0));
    }
    tiles::RenderTile lease(MemberId id, std::size_t pixels = 1'000'000) {
        const auto band = book.lease(id, pixels, at_s(0));
        REQUIRE(band);
        return *band;
    }
    tiles::RenderTile lease_check(MemberId id) {
        const auto band = book.lease_check(id, at_s(0));
        REQUIRE(band);
        return *band;
    }
    [[nodiscard]] ResultValidator::Verdict answer(MemberId id, const tiles::RenderTile& band,
                                                  float error = 0, LeaseBook::Holes holes = {}) {
        tiles::TileResult result = computed(band, error);
        result.holes = std::move(holes);
        return validator.validate(id, *members.find(id), std::move(result), at_s(1));
    }
};

}  // namespace

TEST_CASE("an answer without a lease changes nothing", "[raytracer][sched]") {
    ValidatorBench bench(0);
    const MemberId id = bench.add(worker_spec());
    CHECK(bench.members.find(id)->set_late());
    const auto verdict = bench.answer(id, tile_of_rows(0, 16));
    CHECK(verdict.answer == Answer::kUnrequested);
    CHECK_FALSE(verdict.whole);
    CHECK(bench.members.find(id)->bands() == 0);
    CHECK(bench.members.find(id)->is_on_probation());
}

TEST_CASE("some rows of a worker's first band are checked by a trusted member",
          "[raytracer][sched]") {
    ValidatorBench bench(1'000'000'000);
    const MemberId worker = bench.add(worker_spec());
    const MemberId trusted = bench.add(trusted_spec());
    const auto first = bench.lease(worker, 1);
    const auto second = bench.lease(worker);
    SECTION("it is right") {
        CHECK(bench.answer(worker, first).untrusted == 0);
        const auto verdict = bench.answer(trusted, bench.lease_check(trusted));
        CHECK(verdict.answer == Answer::kChecked);
        CHECK(verdict.untrusted == 0);
        CHECK(bench.answer(worker, second).answer == Answer::kFirst);
        CHECK_FALSE(bench.book.checks_wait());
    }
    SECTION("it is wrong") {
        CHECK(bench.answer(worker, first, 0.5f).untrusted == 0);
        const auto verdict = bench.answer(trusted, bench.lease_check(trusted));
        CHECK(verdict.answer == Answer::kFalse);
        CHECK(verdict.untrusted == worker);
        CHECK(verdict.reason == "its pixels of rows 0 to 8 of tile 0 are wrong");
    }
    SECTION("a hole of the check explains the difference: the next band is checked instead") {
        CHECK(bench.answer(worker, first).untrusted == 0);
        const auto verdict = bench.answer(trusted, bench.lease_check(trusted), 0.5f, kHole);
        CHECK(verdict.answer == Answer::kUndecided);
        CHECK(verdict.untrusted == 0);
        CHECK(bench.answer(worker, second).answer == Answer::kFirst);
        CHECK(bench.book.checks_wait());
    }
}

TEST_CASE("a worker that disagrees with a trusted member is wrong, whichever answered first",
          "[raytracer][sched]") {
    ValidatorBench bench(0);
    const MemberId worker = bench.add(worker_spec());
    const MemberId trusted = bench.add(trusted_spec());
    const auto band = bench.lease(worker);
    (void)bench.book.lease_again(trusted, band, at_s(0));
    SECTION("the worker was first") {
        CHECK(bench.answer(worker, band, 0.5f).answer == Answer::kFirst);
        const auto verdict = bench.answer(trusted, band);
        CHECK(verdict.answer == Answer::kUnequal);
        CHECK(verdict.untrusted == worker);
        CHECK(verdict.reason == "it disagrees with another about rows 0 to 16 of tile 0");
    }
    SECTION("the trusted member was first") {
        CHECK(bench.answer(trusted, band).answer == Answer::kFirst);
        CHECK(bench.answer(worker, band, 0.5f).untrusted == worker);
    }
    SECTION("the trusted member met a hole that the worker did not meet") {
        CHECK(bench.answer(worker, band, 0.5f).answer == Answer::kFirst);
        const auto verdict = bench.answer(trusted, band, 0, kHole);
        CHECK(verdict.answer == Answer::kUnequal);
        CHECK(verdict.untrusted == 0);
    }
    CHECK_FALSE(bench.book.checks_wait());
}

TEST_CASE("checks of two workers that disagree decide which of them is wrong",
          "[raytracer][sched]") {
    ValidatorBench bench(0);
    const MemberId honest = bench.add(worker_spec());
    const MemberId wrong = bench.add(worker_spec());
    const auto band = bench.lease(honest);
    (void)bench.book.lease_again(wrong, band, at_s(0));
    CHECK(bench.answer(honest, band).answer == Answer::kFirst);
    const auto verdict = bench.answer(wrong, band, 0.5f);
    CHECK(verdict.answer == Answer::kUnequal);
    CHECK(verdict.untrusted == 0);
    CHECK(bench.book.open_checks() == 2);
    const MemberId trusted = bench.add(trusted_spec());
    CHECK(bench.answer(trusted, bench.lease_check(trusted)).untrusted == 0);
    CHECK(bench.answer(trusted, bench.lease_check(trusted)).untrusted == wrong);
}
