#include "common/geo/crs.hpp"

#include <ogr_spatialref.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/open_watch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::geo;
using terravox::test::contains;
using terravox::test::OpenWatch;
using terravox::test::replaced;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

const std::string kGrs80 = R"(SPHEROID["GRS 1980",6378137,298.257222101])";
const std::string kEllipsoid = R"(ELLIPSOID["GRS 1980",6378137,298.257222101])";
const std::string kDegrees = R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433])";
const std::string kGeogcs = "GEOGCS[\"x\",DATUM[\"y\"," + kGrs80 + "]," + kDegrees + "]";
const std::string kLatLonAxes = R"(CS[ellipsoidal,2],AXIS["lat",north],AXIS["lon",east],)"
                                R"(ANGLEUNIT["degree",0.0174532925199433])";
const std::string kGeogcrs = "GEOGCRS[\"x\",DATUM[\"y\"," + kEllipsoid + "]," + kLatLonAxes + "]";
const std::string kMetreAxes =
    R"(CS[Cartesian,2],AXIS["e",east],AXIS["n",north],LENGTHUNIT["metre",1])";

std::string projcs(const std::string& end) {
    return "PROJCS[\"x\"," + kGeogcs +
           R"(,PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0])"
           R"(,PARAMETER["central_meridian",15],PARAMETER["scale_factor",1])"
           R"(,PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1])" +
           end + "]";
}

std::string vert_cs(const std::string& end_of_datum) {
    return R"(VERT_CS["h",VERT_DATUM["n",2005)" + end_of_datum +
           R"(],UNIT["metre",1],AXIS["Up",UP]])";
}

std::string bound(const std::string& method) {
    return "BOUNDCRS[SOURCECRS[" + kGeogcrs + "],TARGETCRS[" + kGeogcrs +
           "],ABRIDGEDTRANSFORMATION[\"t\"," + method + "]]";
}

/// All that a reader of a world does with a text that it takes.
void use(const std::string& text, bool as_a_person) {
    const Crs crs = as_a_person ? Crs::from_text(text) : Crs::from_wkt(text);
    (void)to_lat_lon(crs, 5, 5);
}

}  // namespace

TEST_CASE("no text of a coordinate reference system opens a file that it names",
          "[common][geo][crs][hostile]") {
    const TemporaryFolder folder;
    const fs::path secret = folder.path() / "secret";
    std::ofstream(secret) << "nobody's business\n";
    struct Case {
        const char* name;
        std::string text;
    };
    // PROJ (9.1) opens all but those marked with *, when the text is read or when the first place
    // is transformed.
    const auto c = GENERATE(values<Case>({
        {"a grid in a PROJ string", "+proj=longlat +ellps=GRS80 +nadgrids=@FILE +type=crs"},
        {"a grid without the mark for 'if there'",
         "+proj=longlat +ellps=GRS80 +nadgrids=FILE +no_defs"},
        {"several grids", "+proj=longlat +ellps=GRS80 +nadgrids=@null,FILE +no_defs"},
        {"a grid without a plus", "proj=longlat ellps=GRS80 nadgrids=FILE type=crs"},
        {"a geoid in a PROJ string *", "+proj=longlat +ellps=GRS80 +geoidgrids=FILE +no_defs"},
        {"an init file", "+init=FILE:key"},
        {"an init file without a plus *", "init=FILE:key"},
        {"a pipeline *", "+proj=pipeline +step +proj=hgridshift +grids=FILE"},
        {"a grid in a datum", "GEOGCS[\"x\",DATUM[\"y\"," + kGrs80 +
                                  ",EXTENSION[\"PROJ4_GRIDS\",\"FILE\"]]," + kDegrees + "]"},
        {"the same in round brackets", "GEOGCS(\"x\",DATUM(\"y\"," + kGrs80 +
                                           ",EXTENSION(\"PROJ4_GRIDS\",\"FILE\"))," + kDegrees +
                                           ")"},
        {"a PROJ string in WKT",
         projcs(
             ",EXTENSION[\"PROJ4\",\"+proj=utm +zone=33 +ellps=GRS80 +nadgrids=FILE +type=crs\"]")},
        {"an init file in WKT", projcs(",EXTENSION[\"PROJ4\",\"+init=FILE:key\"]")},
        {"a PROJ string for a method",
         "PROJCRS[\"x\",BASEGEOGCRS[\"x\",DATUM[\"y\"," + kEllipsoid +
             "]],CONVERSION[\"c\",METHOD[\"PROJ hgridshift grids=FILE\"]]," + kMetreAxes + "]"},
        {"a grid of a bound system",
         bound(
             R"(METHOD["NTv2",ID["EPSG",9615]],)"
             R"(PARAMETERFILE["Latitude and longitude difference file","FILE",ID["EPSG",8656]])")},
        {"the same in the geoid's name",
         bound(R"(METHOD["NTv2",ID["EPSG",9615]],)"
               R"(PARAMETERFILE["Geoid (height correction) model file","FILE",ID["EPSG",8656]])")},
        {"a geoid of a vertical datum *", "COMPD_CS[\"a\"," + projcs("") + "," +
                                              vert_cs(",EXTENSION[\"PROJ4_GRIDS\",\"FILE\"]") +
                                              "]"},
        {"a geoid model *", "COMPOUNDCRS[\"a\"," + kGeogcrs +
                                ",VERTCRS[\"h\",VDATUM[\"n\"],CS[vertical,1],AXIS[\"h\",up],"
                                "LENGTHUNIT[\"metre\",1],GEOIDMODEL[\"PROJ FILE\"]]]"},
        {"the file itself *", "FILE"},
        {"the file as an address *", "file://FILE"},
    }));
    DYNAMIC_SECTION(c.name) {
        const std::string text = replaced(c.text, "FILE", secret.string());
        const OpenWatch watch(secret);
        CHECK_THROWS_AS(use(text, true), util::UsageError);
        CHECK_THROWS_AS(use(text, false), util::Error);
        CHECK_FALSE(watch.was_opened());
        CHECK_FALSE(fault_of_crs_text(text).empty());
    }
}

TEST_CASE("a system that GDAL has read is checked like a text", "[common][geo][crs][hostile]") {
    const TemporaryFolder folder;
    const fs::path secret = folder.path() / "secret";
    std::ofstream(secret) << "nobody's business\n";
    const std::string text = GENERATE(
        as<std::string>(), "+proj=longlat +ellps=GRS80 +nadgrids=FILE +type=crs",
        projcs(",EXTENSION[\"PROJ4\",\"+proj=utm +zone=33 +ellps=GRS80 +nadgrids=FILE\"]"),
        "PROJCRS[\"x\",BASEGEOGCRS[\"x\",DATUM[\"y\"," + kEllipsoid +
            "]],CONVERSION[\"c\",METHOD[\"PROJ hgridshift grids=FILE\"]]," + kMetreAxes + "]");
    OGRSpatialReference read;
    REQUIRE(read.SetFromUserInput(replaced(text, "FILE", secret.string()).c_str()) == OGRERR_NONE);
    const OpenWatch watch(secret);
    CHECK_THROWS_WITH(Crs::from_ogr(read, "place.tif"),
                      contains("place.tif") && contains("without names of files"));
    CHECK_FALSE(watch.was_opened());
}

TEST_CASE("systems as real files state them are accepted", "[common][geo][crs]") {
    struct Case {
        const char* name;
        std::string text;
    };
    const auto c = GENERATE(values<Case>({
        {"version 1", projcs("")},
        {"round brackets", replaced(replaced(projcs(""), "[", "("), "]", ")")},
        {"line breaks", replaced(projcs(""), ",", ",\r\n\t ")},
        {"three parameters",
         "GEOGCS[\"x\",DATUM[\"y\"," + kGrs80 + ",TOWGS84[1,2,3,0,0,0,0]]," + kDegrees + "]"},
        {"Web Mercator as GDAL writes it",
         "PROJCS[\"WGS 84 / Pseudo-Mercator\"," + kGeogcs +
             ",PROJECTION[\"Mercator_1SP\"],PARAMETER[\"central_meridian\",0],PARAMETER[\"scale_"
             "factor\",1],PARAMETER[\"false_easting\",0],"
             "PARAMETER[\"false_northing\",0],UNIT[\"metre\",1],EXTENSION[\"PROJ4\",\"+proj=merc "
             "+a=6378137 +b=6378137 +lat_ts=0 +lon_0=0 "
             "+x_0=0 +y_0=0 +k=1 +units=m +nadgrids=@null +wktext "
             "+no_defs\"],AUTHORITY[\"EPSG\",\"3857\"]]"},
        {"geoids of a vertical datum by their names",
         "COMPD_CS[\"a\"," + projcs("") + "," +
             vert_cs(",EXTENSION[\"PROJ4_GRIDS\",\"g2012a_conus.gtx,g2012a_alaska.gtx\"]") + "]"},
        {"quotation marks in a name",
         R"(GEOGCS["the ""best"" one [1]",DATUM["y",)" + kGrs80 + "]," + kDegrees + "]"},
        {"version 2", kGeogcrs},
        {"a system of one's own in version 2",
         Crs::from_text("+proj=etmerc +lat_0=0 +lon_0=15 +k=1 +ellps=GRS80").wkt()},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(fault_of_crs_text(c.text).empty());
        const Crs crs = Crs::from_wkt(c.text);
        // The WKT of an accepted system is accepted, too: a server sends it to its clients.
        CHECK(Crs::from_wkt(crs.wkt()).same_horizontal(crs));
        CHECK(Crs::from_ogr(crs.ogr(), "it").same_horizontal(crs));
    }
}

TEST_CASE("a file's text is WKT, a user's may be a code or a PROJ string", "[common][geo][crs]") {
    const char* text = GENERATE("EPSG:3794", "epsg:3794", "ESRI:102100", "IGNF:LAMB93", "OGC:CRS84",
                                "EPSG:2994+6360", "+proj=utm +zone=33 +datum=WGS84");
    DYNAMIC_SECTION(text) {
        CHECK_NOTHROW(Crs::from_text(text));
        CHECK_THROWS_WITH(Crs::from_wkt(text), contains(text) && contains("no well-known text"));
    }
}

TEST_CASE("texts that are no system are refused before PROJ sees them",
          "[common][geo][crs][hostile]") {
    struct Case {
        const char* name;
        std::string text;
        const char* said;
    };
    std::string deep;
    std::string balanced;
    for (int i = 0; i < 17; ++i)
        deep += "PROJCS[";
    balanced = deep + std::string(17, ']');
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing", "", "not understood"},
        {"blanks", " \n", "not understood"},
        {"a zero byte", std::string("EPSG:37\0", 8), "not understood"},
        {"too long", "PROJCS[\"" + std::string(kLongestCrsText, 'x') + "\"]", "more than 65535"},
        {"too deep", balanced, "nested deeper than 16"},
        {"an authority that is none", "/tmp/x:3794", "not understood"},
        {"a code that is a path", "EPSG:../../x", "not understood"},
        {"an address", "http://127.0.0.1:1/crs.wkt", "not understood"},
        {"a URN", "urn:ogc:def:crs:EPSG::3794", "not understood"},
        {"JSON", "{\"type\":\"GeographicCRS\"}", "not understood"},
        {"a keyword that is not known", "PROJCS[\"x\",PARAM_MT[\"x\"]]",
         "the keyword 'PARAM_MT' is not known"},
        {"an operation", "CONCATENATEDOPERATION[\"x\"]",
         "the keyword 'CONCATENATEDOPERATION' is not known"},
        {"an operation for a method",
         "CONVERSION[\"c\",METHOD[\"PROJ-based operation method: +proj=pipeline\"]]",
         "an operation of PROJ's own"},
        {"another mark of quotation", "PROJCS[\xe2\x80\x9cx\xe2\x80\x9d]",
         "a character that stands in no well-known text"},
        {"a bracket that does not match", "PROJCS[\"x\")", "brackets that do not match"},
        {"a text without an end", "PROJCS[\"x", "a text without an end"},
        {"a bracket without an end", "PROJCS[\"x\"", "no well-known text"},
        {"two systems", "PROJCS[\"x\"]PROJCS[\"x\"]", "no well-known text"},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK_THAT(fault_of_crs_text(c.text), contains(c.said));
        CHECK_THROWS_AS(Crs::from_text(c.text), util::UsageError);
        CHECK_THROWS_AS(Crs::from_wkt(c.text), util::Error);
    }
}

TEST_CASE("damaged texts are refused or accepted, and name no file",
          "[common][geo][crs][hostile]") {
    std::mt19937 random(5);
    const std::string good = projcs(",EXTENSION[\"PROJ4\",\"+proj=merc +nadgrids=@null\"]");
    int taken = 0;
    for (int i = 0; i < 20'000; ++i) {
        std::string bad = good.substr(0, random() % 4 == 0 ? random() % good.size() : good.size());
        for (unsigned n = random() % 3; n > 0 && !bad.empty(); --n)
            bad[random() % bad.size()] = static_cast<char>(random() % 256);
        INFO(bad);
        const bool passes = fault_of_crs_text(bad).empty();
        if (passes)
            CHECK(bad.find("nadgrids=/") == std::string::npos);
        taken += passes ? 1 : 0;
    }
    CHECK(taken > 1000);
}
