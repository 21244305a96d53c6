#include "tests/bench/accuracy/errors.hpp"

#include <cmath>

#include "tests/catch.hpp"

using namespace terravox::bench;

TEST_CASE("root mean square, mean and percentiles of errors", "[bench][accuracy]") {
    Errors errors;
    for (const double v : {3.0, -4.0, 0.0, 0.0})
        errors.add(v);
    CHECK(errors.rmse() == Approx(2.5));
    CHECK(errors.bias() == Approx(-0.25));
    CHECK(errors.worst() == Approx(4));
    CHECK(errors.size_at(0.5) == Approx(0));
    CHECK(errors.size_at(0.75) == Approx(3));
    CHECK(errors.size_at(1.0) == Approx(4));
    Errors more;
    more.add(5);
    more.add(errors);
    CHECK(more.count() == 5);
    CHECK(more.worst() == Approx(5));
}

TEST_CASE("nothing measured is not a number, never a success", "[bench][accuracy]") {
    const Errors none;
    CHECK(std::isnan(none.rmse()));
    CHECK(std::isnan(none.bias()));
    CHECK(std::isnan(none.worst()));
    CHECK(std::isnan(none.size_at(0.95)));
    CHECK(std::isnan(Share{}.value()));
    CHECK(std::isnan(Overlap{}.iou()));
}

TEST_CASE("shares and overlaps count what held", "[bench][accuracy]") {
    Share share;
    for (const bool holds : {true, false, true, true})
        share.add(holds);
    CHECK(share.value() == Approx(0.75));
    Overlap overlap;
    overlap.add(true, true);
    overlap.add(true, false);
    overlap.add(false, true);
    overlap.add(false, false);
    CHECK(overlap.iou() == Approx(1.0 / 3));
}
