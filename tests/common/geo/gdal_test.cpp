#include "common/geo/gdal.hpp"

#include <gdal.h>

#include <cstdlib>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("GDAL keeps no more of images than it is told to", "[common][geo][gdal]") {
    if (std::getenv("GDAL_CACHEMAX") != nullptr)
        return;  // the person's own limit goes before ours
    geo::start_gdal();
    geo::start_gdal();
    CHECK(GDALGetCacheMax64() == geo::kGdalCache_bytes);
    CHECK(GDALGetDriverByName("GTiff") != nullptr);
}
