// Coordinate reference systems as texts, as in point clouds, archives and replies of servers.
#include "common/geo/crs.hpp"

#include "common/geo/gdal_messages.hpp"
#include "common/util/error.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {
namespace {

/// As text from a file or another program, else as text that a user types.
geo::Crs read(const std::string& text) {
    try {
        return geo::Crs::from_wkt(text);
    } catch (const util::Error&) {
        return geo::Crs::from_text(text);
    }
}

}  // namespace

void run(Input input) {
    const geo::GdalErrorScope errors;
    const geo::Crs crs = read(as_text(input));
    (void)crs.name();
    (void)crs.wkt();
    (void)crs.metres_per_unit();
    (void)crs.vertical_metres_per_unit();
    (void)crs.vertical_datum();
    (void)crs.pseudo_mercator();
    expect(crs.same_horizontal(crs), "a system is the same as itself");
}

}  // namespace terravox::fuzz
