#include <fstream>

#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "tests/voxelserver/data/imagery/image_files.hpp"

using namespace terravox;
using namespace terravox::test;
using imagery::Orthophotos;
namespace fs = std::filesystem;

namespace {

std::string read_all_bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void put_bytes(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

/// Opens an image and reads all of it. @return how it went
std::string try_all(const fs::path& file) {
    const auto f = frame();
    try {
        const Orthophotos photos({file}, f);
        for (int i = 0; i < 4; ++i)
            (void)photos.read(voxel_x(f, 0) + i % 2 * 150, voxel_z(f, 300) + i / 2 * 150, 150, 150);
        return "read";
    } catch (const util::Error& e) {
        if (std::string(e.what()).find(file.filename().string()) == std::string::npos)
            return std::string("the error does not name the file: ") + e.what();
        if (std::string(e.what()).find('\n') != std::string::npos)
            return std::string("more than one line: ") + e.what();
        return "refused";
    }
}

}  // namespace

TEST_CASE("an image that cannot be placed or read is refused, naming it",
          "[voxelserver][imagery][bad]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "image.tif";
    SECTION("no such file") {
        CHECK_THROWS_WITH(Orthophotos({file}, frame()), contains("image.tif"));
    }
    SECTION("no image") {
        put_bytes(file, "no image");
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("no raster that can be read"));
    }
    SECTION("no place") {
        geo::start_gdal();
        GDALDatasetUniquePtr(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            file.string().c_str(), 4, 4, 3, GDT_Byte, nullptr));
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("not georeferenced"));
    }
    SECTION("a place without size") {
        ImageFile image;
        image.geo = {kEast0, 1, 1, kNorth0, 1, 1};
        write_image(file, image);
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("size of its pixels"));
    }
    SECTION("too many pixels to a voxel") {
        ImageFile image;
        image.geo = {kEast0, 1e-4, 0, kNorth0, 0, -1e-4};
        write_image(file, image);
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("allowed: up to 4096"));
    }
    SECTION("one block of 40000 x 40000 pixels") {
        ImageFile image;
        image.width = image.height = 64;
        image.options = {"BLOCKYSIZE=64"};
        write_image(file, image);
        std::string bytes = read_all_bytes(file);
        // Entries of the directory (12 bytes: tag, type, count, value): ImageWidth, ImageLength,
        // RowsPerStrip become 40000.
        int changed = 0;
        for (std::size_t i = 8; i + 12 <= bytes.size() && i < 400; ++i) {
            const auto tag = static_cast<unsigned char>(bytes[i]) |
                             static_cast<unsigned char>(bytes[i + 1]) << 8;
            if ((tag == 256 || tag == 257 || tag == 278) && bytes[i + 2] == 3 &&
                bytes[i + 3] == 0 && bytes[i + 4] == 1 && bytes[i + 8] == 64) {
                bytes[i + 8] = static_cast<char>(40000 & 255);
                bytes[i + 9] = static_cast<char>(40000 >> 8);
                ++changed;
            }
        }
        REQUIRE(changed == 3);
        put_bytes(file, bytes);
        CHECK(try_all(file) == "refused");
    }
}

TEST_CASE("an image cut short or with flipped bytes is read or refused",
          "[voxelserver][imagery][bad]") {
    const TemporaryFolder folder;
    const fs::path whole = folder.path() / "whole.tif";
    const fs::path file = folder.path() / "damaged.tif";
    ImageFile image;
    image.width = image.height = 200;
    image.geo = {kEast0, 1, 0, kNorth0 + 300, 0, -1};
    image.value = noise;
    const auto compression = GENERATE(std::string("COMPRESS=DEFLATE"), std::string("COMPRESS=LZW"),
                                      std::string("COMPRESS=NONE"));
    image.options = {compression, "TILED=YES", "BLOCKXSIZE=64", "BLOCKYSIZE=64"};
    INFO(image.options[0]);
    write_image(whole, image);
    const std::string bytes = read_all_bytes(whole);
    int refused = 0;
    for (int i = 1; i <= 20; ++i) {
        std::string part = bytes;
        if (i % 2 == 0)
            part.resize(bytes.size() * static_cast<std::size_t>(i) / 21);
        else
            for (int j = 0; j < 40; ++j) {  // the first half of them in the directory
                const auto where = static_cast<std::size_t>(noise(i, j, 1) * 256 + noise(i, j, 2)) %
                                   (i < 10 ? 600 : part.size());
                part[where] = static_cast<char>(part[where] ^ (1 + noise(i, j, 3) % 255));
            }
        put_bytes(file, part);
        const std::string result = try_all(file);
        INFO("damage " << i);
        CHECK((result == "read" || result == "refused"));
        refused += result == "refused";
    }
    CHECK(refused > 5);
}

TEST_CASE("odd and broken TIFFs of a real collection are read or refused",
          "[voxelserver][imagery][bad]") {
    const fs::path collection = fs::path(TERRAVOX_SHARED_DATA) / "bad-tiff" / "libtiff";
    if (!fs::exists(collection)) {
        WARN("skipped: " << collection.string() << " is not there");
        return;
    }
    const TemporaryFolder folder;
    int files = 0;
    int read = 0;
    int placed = 0;
    for (const auto& entry : fs::directory_iterator(collection)) {
        if (entry.path().extension() != ".tif" && entry.path().extension() != ".tiff")
            continue;
        ++files;
        const fs::path bare = folder.path() / entry.path().filename();
        put_bytes(bare, read_all_bytes(entry.path()));
        const std::string without_place = try_all(bare);
        INFO(bare.filename().string() << " as it is: " << without_place);
        CHECK((without_place == "read" || without_place == "refused"));
        placed += without_place == "read";
        // A world file puts it in the middle of the rectangle that is read.
        fs::path world = bare;
        world.replace_extension(".tfw");
        std::ofstream(world) << "1\n0\n0\n-1\n"
                             << std::to_string(kEast0 + 10.5) << "\n"
                             << std::to_string(kNorth0 + 290.5) << "\n";
        const std::string result = try_all(bare);
        INFO(bare.filename().string() << ": " << result);
        CHECK((result == "read" || result == "refused"));
        read += result == "read";
    }
    CHECK(files > 15);
    CHECK(read > 10);
    CHECK(placed <= 2);  // they are no maps
}
