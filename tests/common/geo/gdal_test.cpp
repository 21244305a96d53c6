#include "common/geo/gdal.hpp"

#include <gdal.h>

#include <cstdlib>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("GDAL keeps no more of images than its limit", "[common][geo][gdal]") {
    if (std::getenv("GDAL_CACHEMAX") != nullptr)
        return;  // the user's own limit takes precedence
    geo::start_gdal();
    geo::start_gdal();
    CHECK(GDALGetCacheMax64() == geo::kGdalCache_bytes);
    CHECK(GDALGetDriverByName("GTiff") != nullptr);
}
