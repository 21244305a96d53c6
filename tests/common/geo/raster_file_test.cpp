#include "common/geo/gdal_files.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <optional>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/geo/raster_gate.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/open_watch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::OpenWatch;
using terravox::test::replaced;
using terravox::test::TemporaryFolder;
using terravox::test::write_content;
namespace fs = std::filesystem;

namespace {

constexpr int kSide = 64;
constexpr std::uint8_t kPublic = 7;
constexpr std::uint8_t kSecret = 42;

void write_tiff(const fs::path& file, std::uint8_t value,
                const std::function<void(GDALDataset&)>& also = {}) {
    geo::start_gdal();
    fs::create_directories(file.parent_path());
    const GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        file.c_str(), kSide, kSide, 1, GDT_Byte, nullptr));
    REQUIRE(out);
    std::array<double, 6> place{460'000, 1, 0, 101'000, 0, -1};
    out->SetGeoTransform(place.data());
    out->SetSpatialRef(&geo::Crs::from_text("EPSG:3794").ogr());
    REQUIRE(out->GetRasterBand(1)->Fill(value) == CE_None);
    if (also)
        also(*out);
}

/// With two overviews, whose directories stand behind all other bytes of the file.
void write_with_overviews(const fs::path& file) {
    write_tiff(file, kPublic);
    const GDALDatasetUniquePtr data(
        GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE, geo::kRasterDrivers));
    REQUIRE(data);
    std::array<int, 2> factors{2, 4};
    REQUIRE(data->BuildOverviews("NEAREST", factors.size(), factors.data(), 0, nullptr, nullptr,
                                 nullptr) == CE_None);
}

/// Shortens a file until a directory of it, or the list of its blocks, is no longer complete.
void cut_last_directory(const fs::path& file) {
    // In steps: it takes long to look through a file, and a directory is longer than one.
    constexpr std::uintmax_t kStep = 64;
    for (auto bytes = fs::file_size(file) - 1; bytes > kStep; bytes -= kStep) {
        fs::resize_file(file, bytes);
        if (geo::find_lost_directory_of_tiff(file))
            return;
    }
    FAIL("no length of " << file << " loses a directory");
}

std::string vrt(const std::string& inside) {
    return "<VRTDataset rasterXSize=\"64\" rasterYSize=\"64\"><GeoTransform>460000, 1, 0, 101000, "
           "0, -1</GeoTransform>" +
           inside + "</VRTDataset>";
}

std::string band(const std::string& inside) {
    return vrt("<VRTRasterBand dataType=\"Byte\" band=\"1\">" + inside + "</VRTRasterBand>");
}

std::string source(const std::string& name, bool relative = true) {
    return "<SimpleSource><SourceFilename relativeToVRT=\"" + std::string(relative ? "1" : "0") +
           "\">" + name + "</SourceFilename><SourceBand>1</SourceBand></SimpleSource>";
}

/// What a reader shows of a raster: its first value and those of its overviews, or why there is
/// none.
std::string shown(const fs::path& file) {
    try {
        const GDALDatasetUniquePtr data = geo::open_raster(file, "read");
        const geo::GdalErrorScope errors;
        GDALRasterBand& first = *data->GetRasterBand(1);
        std::string out;
        for (int i = -1; i < first.GetOverviewCount(); ++i) {
            GDALRasterBand* const level = i < 0 ? &first : first.GetOverview(i);
            std::uint8_t value = 0;
            if (level == nullptr || level->RasterIO(GF_Read, 0, 0, 1, 1, &value, 1, 1, GDT_Byte, 0,
                                                    0, nullptr) != CE_None)
                return "damaged";
            out += (i < 0 ? "" : " ") + std::to_string(value);
        }
        (void)first.GetMaskFlags();
        if (const OGRSpatialReference* own = data->GetSpatialRef())
            (void)geo::to_lat_lon(geo::Crs::from_ogr(*own, file.string()), 460'000, 101'000);
        return out;
    } catch (const util::Error& e) {
        return e.what();
    }
}

/// A place with a raster to show and, outside of it, one to hide.
struct Place {
    TemporaryFolder folder;
    fs::path here = folder.path() / "here";
    fs::path elsewhere = folder.path() / "elsewhere";
    fs::path secret = elsewhere / "secret.tif";
    Place() {
        write_tiff(here / "a.tif", kPublic);
        write_tiff(here / "below" / "b.tif", kPublic);
        write_tiff(secret, kSecret);
    }
    /// HERE and SECRET stand for paths.
    [[nodiscard]] std::string filled(const std::string& text) const {
        return replaced(replaced(text, "SECRET", secret.string()), "HERE", here.string());
    }
};

/// A port of this machine that takes connections and never answers.
class Listener {
public:
    Listener() : m_socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        REQUIRE(::bind(m_socket, reinterpret_cast<const sockaddr*>(&address), size) == 0);
        REQUIRE(::listen(m_socket, 4) == 0);
        REQUIRE(::getsockname(m_socket, reinterpret_cast<sockaddr*>(&address), &size) == 0);
        m_port = ntohs(address.sin_port);
    }
    ~Listener() { ::close(m_socket); }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;
    [[nodiscard]] std::string url() const {
        return "http://127.0.0.1:" + std::to_string(m_port) + "/a.tif";
    }
    [[nodiscard]] bool was_contacted() const {
        const int peer = ::accept(m_socket, nullptr, nullptr);
        if (peer >= 0)
            ::close(peer);
        return peer >= 0;
    }

private:
    int m_socket;
    int m_port = 0;
};

}  // namespace

TEST_CASE("a virtual raster reads nothing but files beside or below it",
          "[common][geo][raster][hostile]") {
    const Place place;
    fs::create_symlink(place.secret, place.here / "link.tif");
    fs::create_directory_symlink(place.elsewhere, place.here / "door");
    write_content(place.here / "inner.vrt", place.filled(band(source("SECRET", false))));
    write_content(place.here / "one.vrt", band(source("two.vrt")));
    write_content(place.here / "two.vrt", band(source("one.vrt")));
    ::mkfifo((place.here / "pipe.tif").c_str(), 0600);
    struct Case {
        const char* name;
        std::string text;
        const char* said;
    };
    const std::string good = source("a.tif");
    const std::string of_a =
        "<VRTRasterBand dataType=\"Byte\" band=\"1\">" + good + "</VRTRasterBand>";
    const auto c = GENERATE_REF(values<Case>({
        {"an absolute path", band(source("SECRET", false)), "lies elsewhere"},
        {"an absolute path said to be relative", band(source("SECRET")), "lies elsewhere"},
        {"a path upwards", band(source("../elsewhere/secret.tif")), "lies elsewhere"},
        {"a link to a file", band(source("link.tif")), "lies elsewhere"},
        {"a link to a folder", band(source("door/secret.tif")), "lies elsewhere"},
        {"relative to where the program runs", band(source("a.tif", false)),
         "is relative to where the program runs"},
        {"a virtual raster that does so", band(source("inner.vrt")), "lies elsewhere"},
        {"one that leads back to itself", band(source("one.vrt")), "deeper than 4"},
        {"a folder", band(source("below")), "is no file"},
        {"a pipe", band(source("pipe.tif")), "is no file"},
        {"no name", band(source("")), "is no file's name"},
        {"a name of GDAL's", band(source("GTIFF_DIR:1:a.tif")), "is no plain file's name"},
        {"memory", band(source("MEM:::DATAPOINTER=4096,PIXELS=1,LINES=1")),
         "is no plain file's name"},
        {"an archive", band(source("/vsizip/HERE/a.zip/a.tif", false)), "lies elsewhere"},
        {"a name as an attribute",
         band("<SimpleSource SourceFilename=\"SECRET\"><SourceBand>1</SourceBand></SimpleSource>"),
         "is no file's name"},
        {"the second of two names",
         band("<SimpleSource><SourceFilename relativeToVRT=\"1\">a.tif</SourceFilename>"
              "<SourceFilename>SECRET</SourceFilename></SimpleSource>"),
         "lies elsewhere"},
        {"another case of letters",
         band("<simplesource><sourcefilename>SECRET</sourcefilename></simplesource>"),
         "lies elsewhere"},
        {"an overview",
         band(good + "<Overview><SourceFilename>SECRET</SourceFilename><SourceBand>1</SourceBand></"
                     "Overview>"),
         "lies elsewhere"},
        {"a mask",
         vrt("<VRTRasterBand dataType=\"Byte\" band=\"1\">" + good +
             "</VRTRasterBand><MaskBand><VRTRasterBand dataType=\"Byte\">" +
             source("SECRET", false) + "</VRTRasterBand></MaskBand>"),
         "lies elsewhere"},
        {"any file as raw values",
         vrt("<VRTRasterBand dataType=\"Byte\" band=\"1\" "
             "subClass=\"VRTRawRasterBand\"><SourceFilename>SECRET"
             "</SourceFilename><ImageOffset>0</ImageOffset></VRTRasterBand>"),
         "'subClass'"},
        {"code",
         vrt("<VRTRasterBand dataType=\"Byte\" band=\"1\" "
             "subClass=\"VRTDerivedRasterBand\"><PixelFunctionType>f</PixelFunctionType>"
             "<PixelFunctionLanguage>Python</PixelFunctionLanguage></VRTRasterBand>"),
         "'subClass'"},
        {"a warped raster",
         "<VRTDataset rasterXSize=\"64\" rasterYSize=\"64\" "
         "subClass=\"VRTWarpedDataset\"><GDALWarpOptions>"
         "<SourceDataset>SECRET</SourceDataset></GDALWarpOptions></VRTDataset>",
         "'subClass'"},
        {"options for opening",
         band(
             "<SimpleSource><SourceFilename relativeToVRT=\"1\">a.tif</SourceFilename><OpenOptions>"
             "<OOI key=\"ROOT_PATH\">/</OOI></OpenOptions></SimpleSource>"),
         "'OpenOptions'"},
        {"places in a system with a grid",
         vrt("<GCPList Projection=\"+proj=longlat +nadgrids=SECRET\"/>"), "'GCPList'"},
        {"a system with a grid", vrt("<SRS>+proj=longlat +ellps=GRS80 +nadgrids=SECRET</SRS>"),
         "nadgrids"},
        {"a system from a file", vrt("<SRS>+init=SECRET:key</SRS>"), "init"},
        {"metadata that name overviews",
         vrt("<Metadata domain=\"OVERVIEWS\"><MDI key=\"OVERVIEW_FILE\">SECRET</MDI></Metadata>" +
             of_a),
         "overviews"},
        {"metadata that name places",
         vrt("<Metadata domain=\"GEOLOCATION\"><MDI key=\"X_DATASET\">SECRET</MDI></Metadata>" +
             of_a),
         "its geolocation"},
        {"no XML", "<VRTDataset rasterXSize=\"64\"", "no XML"},
    }));
    DYNAMIC_SECTION(c.name) {
        const fs::path file = place.here / "all.vrt";
        write_content(file, place.filled(c.text));
        const OpenWatch watch(place.secret);
        const std::string said = shown(file);
        CHECK_THAT(said, contains(c.said) && contains(file.string()));
        CHECK(said.find('\n') == std::string::npos);
        CHECK_FALSE(watch.was_opened());
    }
}

TEST_CASE("mosaics of files next to and below them are read", "[common][geo][raster]") {
    const Place place;
    write_content(place.here / "inner.vrt", band(source("below/b.tif")));
    struct Case {
        const char* name;
        std::string text;
    };
    const auto c = GENERATE_REF(values<Case>({
        {"next to it", band(source("a.tif"))},
        {"below", band(source("below/b.tif"))},
        {"back and forth", band(source("below/../a.tif"))},
        {"absolute", band(source("HERE/a.tif", false))},
        {"a virtual raster", band(source("inner.vrt"))},
        {"with a system", vrt("<SRS dataAxisToSRSAxisMapping=\"2,1\">EPSG:3794</SRS><VRTRasterBand "
                              "dataType=\"Byte\" band=\"1\">"
                              "<ColorInterp>Gray</ColorInterp>" +
                              source("a.tif") + "</VRTRasterBand>")},
        {"a source with a scale",
         band("<ComplexSource resampling=\"bilinear\"><SourceFilename relativeToVRT=\"1\" "
              "shared=\"0\">a.tif</SourceFilename>"
              "<SourceBand>1</SourceBand><SourceProperties RasterXSize=\"64\" RasterYSize=\"64\" "
              "DataType=\"Byte\" "
              "BlockXSize=\"64\" BlockYSize=\"64\"/><SrcRect xOff=\"0\" yOff=\"0\" xSize=\"64\" "
              "ySize=\"64\"/><DstRect xOff=\"0\" "
              "yOff=\"0\" xSize=\"64\" ySize=\"64\"/><NODATA>0</NODATA></ComplexSource>")},
    }));
    DYNAMIC_SECTION(c.name) {
        write_content(place.here / "all.vrt", place.filled(c.text));
        CHECK(shown(place.here / "all.vrt") == "7");
        fs::create_symlink(place.here / "all.vrt", place.elsewhere / "named.vrt");
        CHECK(shown(place.elsewhere / "named.vrt") == "7");  // a user's own link
    }
    SECTION("a source that is not there is damage") {
        write_content(place.here / "all.vrt", band(source("none.tif")));
        CHECK(shown(place.here / "all.vrt") == "damaged");
    }
    SECTION("a source that lost its end is damage") {
        write_with_overviews(place.here / "long.tif");
        write_content(place.here / "all.vrt", band(source("long.tif")));
        CHECK(shown(place.here / "all.vrt") == "7");
        cut_last_directory(place.here / "long.tif");
        CHECK(shown(place.here / "all.vrt") == "damaged");
    }
    SECTION("overviews in a file of their own that lost its end are not used") {
        write_tiff(place.here / "a.tif.ovr", 9);
        CHECK(shown(place.here / "a.tif") == "7 9");
        write_with_overviews(place.here / "a.tif.ovr");
        CHECK(shown(place.here / "a.tif") != "7");
        cut_last_directory(place.here / "a.tif.ovr");
        CHECK(shown(place.here / "a.tif") == "7");
    }
    SECTION("its overviews") {
        write_content(place.here / "all.vrt", band(source("a.tif")));
        write_tiff(place.here / "all.vrt.ovr", 9);
        CHECK(shown(place.here / "all.vrt") == "7 9");
    }
}

TEST_CASE("what a raster is, its name and its driver tell, not its text",
          "[common][geo][raster][hostile]") {
    const Place place;
    const OpenWatch watch(place.secret);
    SECTION("a virtual raster by another name") {
        const char* name = GENERATE("x.tif", "x.png", "x", "x.vrt.tif");
        write_content(place.here / name, place.filled(band(source("a.tif"))));
        CHECK_THAT(shown(place.here / name), contains("a virtual raster that is not named .vrt"));
    }
    SECTION("a virtual raster as another's overviews") {
        write_content(place.here / "a.tif.ovr", place.filled(band(source("SECRET", false))));
        CHECK(shown(place.here / "a.tif") == "7");
    }
    SECTION("a virtual raster by another name as a source") {
        write_content(place.here / "b.tif", place.filled(band(source("SECRET", false))));
        write_content(place.here / "all.vrt", band(source("b.tif")));
        CHECK(shown(place.here / "all.vrt") == "damaged");
    }
    SECTION("formats that lead elsewhere") {
        struct Case {
            const char* name;
            std::string text;
        };
        const auto c = GENERATE(values<Case>({
            {"a web map",
             "<GDAL_WMS><Service "
             "name=\"WMS\"><ServerUrl>http://127.0.0.1:1/</ServerUrl></Service></GDAL_WMS>"},
            {"a coverage", "<WCS_GDAL><ServiceURL>http://127.0.0.1:1/</ServiceURL></WCS_GDAL>"},
            {"a database", std::string("SQLite format 3\0", 16)},
            {"a document", "%PDF-1.7\n"},
            {"a collection", "\x89HDF\r\n\x1a\n"},
            {"a raw file of Erdas", "EHFA_HEADER_TAG"},
            {"nothing", ""},
        }));
        write_content(place.here / "x.tif", c.text);
        INFO(c.name);
        CHECK_THAT(shown(place.here / "x.tif"),
                   contains("no raster that can be read") && contains("allowed: GeoTIFF"));
    }
    SECTION("names that are no files") {
        const std::string name =
            GENERATE(as<std::string>(), "/vsimem/x.tif", "/vsistdin/", "/vsizip/HERE/a.zip/a.tif",
                     "GTIFF_DIR:1:HERE/a.tif", "<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"/>",
                     "MEM:::DATAPOINTER=4096,PIXELS=1,LINES=1", "");
        CHECK_THAT(shown(place.filled(name)), contains("no such file"));
        CHECK_THAT(shown(place.here), contains("no file, but a folder"));
    }
    CHECK_FALSE(watch.was_opened());
}

TEST_CASE("side files are files beside the raster, and name no others",
          "[common][geo][raster][hostile]") {
    const Place place;
    const fs::path raster = place.here / "a.tif";
    const std::string pam = "<PAMDataset>TEXT</PAMDataset>";
    // The cases outlive the run that made them, and so its place: each is given that of its own
    // run.
    struct Case {
        const char* name;
        std::function<void(const Place&)> make;
        const char* said;
    };
    const auto text = [](const char* file, const std::string& content) {
        return [=](const Place& at) { write_content(at.here / file, at.filled(content)); };
    };
    const auto link = [](const char* file) {
        return [=](const Place& at) { fs::create_symlink(at.secret, at.here / file); };
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"overviews elsewhere", link("a.tif.ovr"), "a.tif.ovr is no file next to"},
        {"a mask elsewhere", link("a.tif.msk"), "a.tif.msk is no file next to"},
        {"a world file that is a pipe",
         [](const Place& at) { ::mkfifo((at.here / "a.tfw").c_str(), 0600); },
         "a.tfw is no file next to"},
        {"a link to nowhere",
         [](const Place& at) { fs::create_symlink("/nowhere/at/all", at.here / "a.prj"); },
         "a.prj is no file next to"},
        {"a system with a grid",
         text("a.tif.aux.xml",
              replaced(pam, "TEXT", "<SRS>+proj=longlat +ellps=GRS80 +nadgrids=SECRET</SRS>")),
         "nadgrids"},
        {"a system from a file",
         text("a.tif.aux.xml", replaced(pam, "TEXT", "<SRS>+init=SECRET:key</SRS>")), "init"},
        {"a system of places",
         text("a.tif.aux.xml", replaced(pam, "TEXT", "<GCPList Projection=\"+init=SECRET:key\"/>")),
         "init"},
        {"overviews by name",
         text("a.tif.aux.xml", replaced(pam, "TEXT",
                                        "<Metadata domain=\"OVERVIEWS\"><MDI "
                                        "key=\"OVERVIEW_FILE\">SECRET</MDI></Metadata>")),
         "for its overviews"},
        {"places by name",
         text("a.tif.aux.xml", replaced(pam, "TEXT",
                                        "<Metadata domain=\"GEOLOCATION\"><MDI "
                                        "key=\"X_DATASET\">SECRET</MDI></Metadata>")),
         "for its geolocation"},
        {"a grid in a .prj",
         text("a.prj",
              "GEOGCS[\"x\",DATUM[\"y\",SPHEROID[\"z\",6378137,298],EXTENSION[\"PROJ4_GRIDS\","
              "\"SECRET\"]],PRIMEM[\"g\",0],"
              "UNIT[\"degree\",0.0174532925199433]]"),
         "a.prj names files"},
        {"overviews by name in a tag",
         [](const Place& at) {
             write_tiff(at.here / "a.tif", kPublic, [&](GDALDataset& out) {
                 out.SetMetadataItem("OVERVIEW_FILE", at.secret.c_str(), "OVERVIEWS");
             });
         },
         "for its overviews"},
    }));
    DYNAMIC_SECTION(c.name) {
        c.make(place);
        const OpenWatch watch(place.secret);
        CHECK_THAT(shown(raster), contains(c.said) && contains(raster.string()));
        CHECK_FALSE(watch.was_opened());
    }
}

TEST_CASE("no raster asks the network", "[common][geo][raster][hostile]") {
    const Place place;
    const Listener listener;
    const std::string url = "/vsicurl/" + listener.url();
    // ADDRESS stands for that of the listener of each run: the cases are made in the first.
    struct Case {
        const char* name;
        const char* file;
        std::string text;
    };
    const auto c = GENERATE(values<Case>({
        {"a source", "all.vrt", band(source("/vsicurl/ADDRESS", false))},
        {"a source said to be relative", "all.vrt", band(source("/vsicurl/ADDRESS"))},
        {"an address", "all.vrt", band(source("ADDRESS"))},
        {"overviews", "a.tif.aux.xml",
         "<PAMDataset><Metadata domain=\"OVERVIEWS\"><MDI "
         "key=\"OVERVIEW_FILE\">/vsicurl/ADDRESS</MDI></Metadata></PAMDataset>"},
    }));
    DYNAMIC_SECTION(c.name) {
        write_content(place.here / c.file, replaced(c.text, "ADDRESS", listener.url()));
        CHECK(shown(fs::exists(place.here / "all.vrt") ? place.here / "all.vrt"
                                                       : place.here / "a.tif")
                  .starts_with("read "));
        CHECK_FALSE(listener.was_contacted());
    }
    SECTION("nor does GDAL when it is called directly") {
        geo::start_gdal();
        const geo::GdalErrorScope errors;
        CHECK_FALSE(GDALDatasetUniquePtr(GDALDataset::Open(url.c_str(), GDAL_OF_RASTER)));
        CHECK_FALSE(listener.was_contacted());
    }
}

TEST_CASE("the formats that are allowed are read, with their side files", "[common][geo][raster]") {
    const Place place;
    const auto copied = [&](const char* driver, const fs::path& file) {
        const GDALDatasetUniquePtr from = geo::open_raster(place.here / "a.tif", "read");
        GDALDriver* const to = GetGDALDriverManager()->GetDriverByName(driver);
        REQUIRE(to != nullptr);
        const geo::GdalErrorScope errors;
        std::array<const char*, 3> exact{"REVERSIBLE=YES", "QUALITY=100", nullptr};  // of JPEG 2000
        char** const options =
            std::string_view(driver) == "JP2OpenJPEG" ? const_cast<char**>(exact.data()) : nullptr;
        REQUIRE(GDALDatasetUniquePtr(
            to->CreateCopy(file.c_str(), from.get(), FALSE, options, nullptr, nullptr)));
    };
    SECTION("with the side files that GDAL writes") {
        struct Case {
            const char* driver;
            const char* file;
        };
        const auto c = GENERATE(values<Case>({{"JPEG", "x.jpg"},
                                              {"PNG", "x.png"},
                                              {"JP2OpenJPEG", "x.jp2"},
                                              {"AAIGrid", "x.asc"},
                                              {"EHdr", "x.bil"},
                                              {"ENVI", "x.dat"},
                                              {"COG", "x.tif"},
                                              {"XYZ", "x.xyz"}}));
        INFO(c.driver);
        copied(c.driver, place.here / c.file);
        CHECK(shown(place.here / c.file) == "7");
        const GDALDatasetUniquePtr data = geo::open_raster(place.here / c.file, "read");
        std::array<double, 6> at{};
        CHECK(data->GetGeoTransform(at.data()) == CE_None);
        CHECK(at[0] == 460'000);
    }
    SECTION("with a world file alone") {
        const auto c = GENERATE(
            values<std::pair<const char*, const char*>>({{"PNG", "x.png"}, {"JPEG", "x.jpg"}}));
        copied(c.first, place.here / c.second);
        fs::remove(place.here / (std::string(c.second) + ".aux.xml"));
        write_content((place.here / c.second).replace_extension(".wld"),
                      "2\n0\n0\n-2\n1000\n2000\n");
        const GDALDatasetUniquePtr data = geo::open_raster(place.here / c.second, "read");
        std::array<double, 6> at{};
        CHECK(data->GetGeoTransform(at.data()) == CE_None);
        CHECK(at[0] == 999);
    }
    SECTION("a header that names another file shows its own") {
        copied("ENVI", place.here / "x.dat");
        std::ofstream(place.here / "x.hdr", std::ios::app)
            << "data file = ../elsewhere/secret.tif\ndem file = " << place.secret.string() << "\n";
        const OpenWatch watch(place.secret);
        CHECK(shown(place.here / "x.dat") == "7");
        CHECK_FALSE(watch.was_opened());
    }
    SECTION("an overview instead of the whole") {
        write_tiff(place.here / "a.tif.ovr", 9);
        CHECK(shown(place.here / "a.tif") == "7 9");
        const GDALDatasetUniquePtr data = geo::open_raster(place.here / "a.tif", "read", 0);
        std::uint8_t value = 0;
        CHECK(data->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, 1, 1, &value, 1, 1, GDT_Byte, 0, 0,
                                               nullptr) == CE_None);
        CHECK(value == 9);
    }
    SECTION("a photograph of a real place") {
        const fs::path photo = fs::path(TERRAVOX_SHARED_DATA) / "pdal/autzen/autzen.jpg";
        if (!fs::exists(photo)) {
            WARN("skipped: " << photo.string() << " is not there");
            return;
        }
        std::array<double, 6> at{};
        CHECK(geo::open_raster(photo, "read")->GetGeoTransform(at.data()) == CE_None);
        CHECK(at[0] > 0);
    }
}

TEST_CASE("a grid of text that ends early is refused at once", "[common][geo][raster]") {
    const Place place;
    const auto grid = [&](int rows) {
        std::string text = "ncols 20\nnrows 900\nxllcorner 0\nyllcorner 0\ncellsize 5\n";
        for (int row = 0; row < rows; ++row) {
            for (int column = 0; column < 20; ++column)
                text += std::to_string(row) + (column % 7 == 6 ? "\r\n" : " ");
            text += "\n";
        }
        write_content(place.here / "x.asc", text);
        return place.here / "x.asc";
    };
    const GDALDatasetUniquePtr whole = geo::open_raster(grid(900), "read");
    double last = 0;
    CHECK(whole->GetRasterBand(1)->RasterIO(GF_Read, 19, 899, 1, 1, &last, 1, 1, GDT_Float64, 0, 0,
                                            nullptr) == CE_None);
    CHECK(last == 899);
    // To GDAL each missing row is twice the work of the one before it.
    for (const int rows : {1, 2, 450, 898})
        CHECK_THROWS_WITH(geo::open_raster(grid(rows), "read"),
                          contains("cut short: it has fewer than the 18000 values"));
}

TEST_CASE("the GeoTIFF keys of a file are read as they are, of damaged ones none",
          "[common][geo][raster]") {
    const Place place;
    const fs::path file = place.here / "keys.tif";
    const char* const option = GENERATE("BIGTIFF=NO", "BIGTIFF=YES", "ENDIANNESS=BIG");
    CAPTURE(option);
    {
        geo::start_gdal();
        const char* const options[] = {option, nullptr};
        const GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            file.c_str(), 1, 1, 1, GDT_Byte, const_cast<char**>(options)));
        std::array<double, 6> at{460'000, 1, 0, 101'000, 0, -1};
        out->SetGeoTransform(at.data());
        out->SetSpatialRef(&geo::Crs::from_text("EPSG:3794+6360").ogr());
    }
    constexpr std::array<std::uint16_t, 4> kVertical = {4096, 0, 1, 6360};
    const auto keys = geo::find_geokeys_of_tiff(file);
    REQUIRE(keys.size() >= 8);
    CHECK(keys.size() == 4 * (std::size_t{keys[3]} + 1));
    CHECK(std::search(keys.begin(), keys.end(), kVertical.begin(), kVertical.end()) != keys.end());
    const std::string bytes = test::read_content(file);
    for (std::size_t end = 0; end < bytes.size(); end += 7) {
        write_content(file, bytes.substr(0, end));
        const auto found = geo::find_geokeys_of_tiff(file);
        INFO("cut at byte " << end);
        CHECK((found.empty() || found == keys));
    }
    write_content(file, "no TIFF");
    CHECK(geo::find_geokeys_of_tiff(file).empty());
}

TEST_CASE("a grid of text with a value that is no number is refused, naming it",
          "[common][geo][raster]") {
    const Place place;
    const auto with = [&](const std::string& value, const std::string& more = "") {
        write_content(place.here / "x.asc",
                      "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n" + more + "1.5 " +
                          value + "\n3 4");
        return place.here / "x.asc";
    };
    for (const char* good :
         {"2", "-2.5", "+2", "2,5", "2e0", "2.5E+00", "nan", "-nan", "inf", "1.#QNAN", "-1.#IND"}) {
        INFO(good);
        CHECK(geo::open_raster(with(good), "read") != nullptr);
    }
    for (const char* bad : {"****", "abc", "NA", "-", "N/A", "NULL", "2m", "0x2"}) {
        INFO(bad);
        CHECK_THROWS_WITH(geo::open_raster(with(bad, "NODATA_value -9999\n"), "read"),
                          contains("its value '" + std::string(bad) + "' is no number") &&
                              contains("NODATA_value"));
    }
}

TEST_CASE("a path lies in a folder or it does not, after all links", "[common][geo][raster]") {
    const Place place;
    fs::create_directory_symlink(place.elsewhere, place.here / "door");
    CHECK(geo::lies_in(place.here / "a.tif", place.here));
    CHECK(geo::lies_in(place.here / "below/b.tif", place.here));
    CHECK(geo::lies_in(place.here / "not/there.tif", place.here));
    CHECK(geo::lies_in(place.here / "door/secret.tif", place.elsewhere));
    CHECK_FALSE(geo::lies_in(place.here / "door/secret.tif", place.here));
    CHECK_FALSE(geo::lies_in(place.here / "not/../../elsewhere/secret.tif", place.here));
    CHECK_FALSE(geo::lies_in(place.here, place.here));
    CHECK_FALSE(geo::lies_in(place.folder.path() / "here2/a.tif", place.here));
    CHECK_FALSE(geo::lies_in(place.here / "a.tif", place.folder.path() / "none"));
}
