// fuzz-file-corpora FOLDER: inputs of the targets that need nothing of the ray tracer, in
// FOLDER/TARGET.
#include <cpl_string.h>
#include <gdal_priv.h>

#include <array>
#include <cstdio>
#include <fstream>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/farm/net/handshake.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/fuzz/corpus.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/data/ply/ply_bytes.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_map_block.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_chunk.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_files.hpp"
#include "tests/voxelserver/make/worlds/remote/batch_bytes.hpp"

namespace {

using namespace terravox;
using namespace terravox::fuzz;
namespace fs = std::filesystem;

void las(const fs::path& folder) {
    const Corpus corpus(folder, "las");
    for (const int format : {0, 1, 2, 3, 6, 7, 8})
        for (const char* ending : {".las", ".laz"})
            for (const std::size_t count : {std::size_t{3}, std::size_t{60}}) {
                const std::string name =
                    "format-" + std::to_string(format) + "-" + std::to_string(count) + ending;
                test::write_sample(corpus.path(name), format, count,
                                   geo::Crs::from_text("EPSG:3794").wkt());
            }
}

void ply(const fs::path& folder) {
    const Corpus corpus(folder, "ply");
    std::vector<pointcloud::Point> points(3);
    points[1].x = 1.5;
    points[2].classification = 6;
    corpus.add("text", test::ply_bytes(points, test::PlyKind::kText, "crs EPSG:2154"));
    corpus.add("little", test::ply_bytes(points, test::PlyKind::kLittle));
    corpus.add("big", test::ply_bytes(points, test::PlyKind::kBig));
}

/// A raster of floating-point heights with overviews, by GDAL; options as of its GTiff driver.
std::string tiff(const fs::path& file, std::initializer_list<const char*> options) {
    geo::start_gdal();
    CPLStringList words;
    for (const char* option : options)
        words.AddString(option);
    {
        const GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            file.c_str(), 40, 24, 1, GDT_Float32, words.List()));
        std::array<double, 6> place{460'000, 1, 0, 101'000, 0, -1};
        out->SetGeoTransform(place.data());
        out->SetSpatialRef(&geo::Crs::from_text("EPSG:3794").ogr());
        out->GetRasterBand(1)->SetNoDataValue(-9999);
        out->GetRasterBand(1)->Fill(123.5);
        std::array<int, 1> factors{2};
        out->BuildOverviews("NEAREST", 1, factors.data(), 0, nullptr, nullptr, nullptr);
    }
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// The first byte chooses the format: tests/fuzz/raster.cpp.
void rasters(const fs::path& folder) {
    const Corpus corpus(folder, "raster");
    const test::TemporaryFolder scratch;
    const fs::path file = scratch.path() / "heights.tif";
    const char kTiff = 0;
    const char kVrt = 1;
    const char kAsc = 2;
    const char kXyz = 5;
    int number = 0;
    for (const auto options : std::initializer_list<std::initializer_list<const char*>>{
             {"TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16", "COMPRESS=DEFLATE"},
             {"COMPRESS=LZW", "PREDICTOR=3"},
             {"BIGTIFF=YES"}})
        corpus.add("tiff-" + std::to_string(number++), kTiff + tiff(file, options));
    corpus.add(
        "vrt",
        kVrt + std::string(
                   "<VRTDataset rasterXSize=\"40\" rasterYSize=\"24\"><GeoTransform>460000, 1, 0, "
                   "101000, 0, "
                   "-1</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
                   "<SourceFilename "
                   "relativeToVRT=\"1\">input.tif</SourceFilename><SourceBand>1</SourceBand>"
                   "</SimpleSource></VRTRasterBand></VRTDataset>"));
    corpus.add(
        "asc",
        kAsc + std::string("ncols 3\nnrows 2\nxllcorner 460000\nyllcorner 101000\ncellsize 5\n"
                           "NODATA_value -9999\n1 2 3\n4.5 -9999 6e1\n"));
    corpus.add("xyz", kXyz + std::string("0 0 1\n1 0 2\n0 1 3\n1 1 4\n"));
}

void boxes(const fs::path& folder) {
    const voxel::BoxKey keys[] = {{0, 0, 0, 0}, {0, -1, 0, -1}, {1, 0, 0, 0}};
    const Corpus box(folder, "box");
    const Corpus batch(folder, "batch");
    std::string records;
    for (const auto& key : keys) {
        const auto made = small_box(key);
        const std::string name = std::to_string(key.level) + "-" + std::to_string(key.bx);
        box.add(name + ".blob", chars(made->blob()));
        box.add(name + ".zst", chars(voxel::compress(*made)));
        records += test::record(key, 200, chars(voxel::compress(*made)));
    }
    records += test::record({0, 1, 0, 0}, 204, "");
    for (const char part_bytes : {'\x06', '\xff'})
        batch.add("whole-" + std::to_string(static_cast<unsigned char>(part_bytes)),
                  part_bytes + records + test::last_record(4));
    batch.add("failed",
              'a' + test::record({0, 1, 0, 0}, 500, "no such square") + test::last_record(1));

    const Corpus archive(folder, "archive");
    voxel::ArchiveWriter writer(archive.path("small.tvx"), small_info(), 0);
    for (const auto& key : keys)
        writer.add(key, voxel::archive::Kind::kBox, voxel::compress(*small_box(key)));
    const std::string why = "a hole";
    writer.add({0, -1, 0, 0}, voxel::archive::Kind::kHole, std::as_bytes(std::span(why)));
    writer.finish(1);
    Corpus(folder, "world_json").add("small.json", voxel::world_to_json(small_info()));
}

void minecraft_files(const fs::path& folder) {
    const Corpus nbt(folder, "nbt");
    const Corpus region(folder, "region");
    const Corpus zip(folder, "zip");
    test::MadeChunk chunk;
    for (int y = 0; y < 20; ++y)
        chunk.set(y % 16, y, 3, static_cast<std::uint16_t>(y % 9));
    using test::Made;
    int kind = 1;
    for (const auto made :
         {Made::kColumns, Made::kNumeric, Made::kStraddling, Made::kPadded, Made::kFlat}) {
        const std::string name = std::to_string(static_cast<int>(made));
        nbt.add("chunk-" + name, chars(test::chunk_nbt(chunk, made)));
        test::MadeRegion file;
        file.put(0, test::chunk_nbt(chunk, made), kind);
        region.add("region-" + name, chars(file.bytes));
        const std::string ending = made == Made::kColumns ? ".mcr" : ".mca";
        test::write_zip(zip.path("world-" + name + ".zip"),
                        {{"w/level.dat", test::level_dat_nbt("zipped")},
                         {"w/region/r.0.0" + ending, file.bytes}});
        kind = kind % 4 + 1;
    }
    nbt.add("level.dat", chars(test::level_dat_nbt("a world")));
}

void map_blocks(const fs::path& folder) {
    const Corpus corpus(folder, "map_block");
    test::luanti::MadeBlock block;
    block.names = {"air", "default:stone", "default:water_source"};
    for (int y = 0; y < 9; ++y)
        block.set(y, y, 3, static_cast<std::uint16_t>(y % 3));
    for (const int version : {25, 27, 28, 29})
        corpus.add("version-" + std::to_string(version),
                   chars(test::luanti::map_block_blob(block, version)));
    corpus.add("body", chars(test::luanti::body_29(block)));
}

void handshake(const fs::path& folder) {
    const Corpus corpus(folder, "handshake");
    const std::string hello = std::string(net::kHandshakeMagic) +
                              static_cast<char>(net::kHandshakeVersion) +
                              std::string(net::kNonce_bytes, 'n');
    const std::string proof(net::kProof_bytes, 'p');
    corpus.add("to-listener", '\x07' + hello + proof);
    corpus.add("to-dialler", '\x50' + hello + std::string(net::kAnswer_bytes, '\2'));
}

void texts(const fs::path& folder) {
    const Corpus animation(folder, "animation");
    animation.add("keys.toml",
                  "fps = 10\nease = true\n[[key]]\ntime_s = 0\n[key.camera]\nposition = [0, 0, "
                  "10]\ntarget = [1, 0, 0]\n"
                  "[[key]]\nframe = 10\n[key.camera]\nposition = [5, 2, 3]\nfov_deg = 20\n");
    animation.add("day.toml",
                  "seconds = 2\n[day]\nfrom = 5\nto = 21\nseconds = 2\n[turntable]\nturns = "
                  "1\nseconds = 2\ntarget = [1, 2, 3]\n");
    const Corpus crs(folder, "crs");
    for (const char* code : {"EPSG:3794", "EPSG:25832", "EPSG:28992", "EPSG:4326", "EPSG:3857"}) {
        crs.add(std::string(code).substr(5), code);
        crs.add(std::string(code).substr(5) + ".wkt", geo::Crs::from_text(code).wkt());
    }
    const fs::path config = fs::path(TERRAVOX_SOURCE_DIR) / "config";
    const auto add_all = [&](const char* target, const fs::path& from) {
        const Corpus corpus(folder, target);
        for (const auto& entry : fs::directory_iterator(from))
            if (entry.path().extension() == ".toml")
                corpus.add_file(entry.path());
    };
    add_all("scene", config / "scenes");
    add_all("settings", config / "classes");
    add_all("settings", config / "palettes");
    Corpus(folder, "settings").add_file(config / "voxelize.toml");
    Corpus(folder, "worker_config").add_file(config / "worker.toml");
    Corpus(folder, "worker_config")
        .add("listen.toml",
             "version = 1\nlisten = \"127.0.0.1:7413\"\nthreads = 2\nname = \"w\"\nonce = true\n");
    for (const char* name : {"materials.toml", "materials-clay.toml"}) {
        Corpus(folder, "materials").add_file(config / name);
        Corpus(folder, "toml").add_file(config / name);
    }
    add_all("toml", config / "scenes");
}

void requests(const fs::path& folder) {
    const Corpus corpus(folder, "http");
    int number = 0;
    for (const char* text :
         {"GET /healthz",
          "GET /v2/world\nAccept-Encoding: zstd, gzip;q=0.5\nIf-None-Match: \"a\", W/\"b\"\n",
          "HEAD /v2/boxes/0/0/0/0\nHost: here\n",
          "GET /v2/boxes/1/0/-1/0\nAccept-Encoding: identity;q=0\n", "GET /v2/columns/0/0/0",
          "GET /v2/squares", "GET /v2/cached/1", "GET /v2/stats", "GET /metrics",
          "GET /openapi.json", "GET /", "GET /map/0/0/0.png", "GET /v2/map/0/0/0.png",
          "GET /gkot/origin.json?tmx=462000&tmy=101000",
          "GET /gkot/box?format=raw&tmx=462000.5&tmy=101000&tmz=3&x=0&y=0&z=0&sx=16&sy=16&sz=16",
          "POST /v2/boxes\nContent-Type: application/json\nContent-Length: "
          "41\n\n{\"boxes\":[[0,0,0,0],[1,0,-1,0],[0,1,1,0]]}"})
        corpus.add(std::to_string(number++), text);
}

void geojson(const fs::path& folder) {
    const Corpus corpus(folder, "geojson");
    const std::string crs =
        R"(,"crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::3794"}}})";
    const auto feature = [](const std::string& type, const std::string& coordinates,
                            const std::string& properties) {
        return R"({"type":"Feature","properties":)" + properties + R"(,"geometry":{"type":")" +
               type + R"(","coordinates":)" + coordinates + "}}";
    };
    const std::string square = "[[8,8],[40,8],[40,40],[8,40],[8,8]]";
    const std::string hole = "[[16,16],[16,24],[24,24],[24,16],[16,16]]";
    const std::pair<const char*, std::string> files[] = {
        {"house", feature("Polygon", "[" + square + "," + hole + "]", R"({"height":"7.5 m"})")},
        {"houses", feature("MultiPolygon", "[[[[1,1],[5,1],[5,5],[1,1]]],[" + square + "]]",
                           R"({"top":12,"name":"a house"})")},
        {"lamps", feature("MultiPoint", "[[3,4],[50.5,60.5,2]]", R"({"height":6})") + "," +
                      feature("Point", "[9,9]", "null")},
        {"path", feature("LineString", "[[1,2,3],[30,40,5]]", "{}") + "," +
                     feature("MultiLineString", "[[[1,2],[3,4]],[[5,6],[7,8]]]", "{}")},
        {"bow", feature("Polygon", "[[[1,1],[9,9],[9,1],[1,9],[1,1]]]", R"({"top":5})")},
        {"open", feature("Polygon", "[[[1,1],[9,1],[9,9]]]", R"({"top":5})")},
        {"nowhere", R"({"type":"Feature","properties":null,"geometry":null})"},
    };
    for (const auto& [name, features] : files)
        corpus.add(name, R"({"type":"FeatureCollection","features":[)" + features + "]" + crs);
    corpus.add("degrees", feature("Polygon", "[[[15,46],[15.001,46],[15,46.001],[15,46]]]",
                                  R"({"height":3})"));
    corpus.add("geometry", R"({"type":"Point","coordinates":[20,30])" + crs);
    const std::size_t depth = 30'000;
    corpus.add("deep", R"({"type":"Point","coordinates":)" + std::string(depth, '[') +
                           std::string(depth, ']') + "}");
}

void jobs(const fs::path& folder) {
    const Corpus corpus(folder, "jobs");
    int number = 0;
    for (const char* text :
         {R"({"kind":"terrain","area":[10,20.5,30,1e2],"resolution_m":2})",
          R"({"kind":"sky","area":[0,0,9,9],"directions":64,"range_m":50.5,"thin_blocks":true})",
          R"({"kind":"sun","area":[-1,0,1,1],"date":"2026-06-21","at":"12:00","step_min":30,)"
          R"("zone":"Europe/Ljubljana","surface":"ground"})",
          R"({"kind":"sun","area":[0,0,1,1],"from":"2026-01-01","to":"2026-12-31","monthly":true})",
          R"({"kind":"energy","area":[0,0,1,1],"directions":16,"linke":3.5,"surface":"top"})",
          R"({"kind":"sight","area":[0,0,1,1],"observers":[[0.5,0.25,1.6],[1,2,3]],"target_m":2})",
          R"({"kind":"sky","area":[0,0,1e9,1e9]})", R"({"kind":"noise"})", "[[[[]]]]"})
        corpus.add(std::to_string(number++), text);
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) {
        std::fputs("usage: fuzz-file-corpora FOLDER\n", stderr);
        return 2;
    }
    try {
        const fs::path folder = arguments[1];
        las(folder);
        ply(folder);
        rasters(folder);
        boxes(folder);
        minecraft_files(folder);
        map_blocks(folder);
        handshake(folder);
        texts(folder);
        requests(folder);
        geojson(folder);
        jobs(folder);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "write the corpora: %s\n", e.what());
        return 1;
    }
    return 0;
}
