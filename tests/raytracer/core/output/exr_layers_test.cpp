#include <bit>
#include <nlohmann/json.hpp>

#include "raytracer/core/output/cryptomatte.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/core/output/picture_reader.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

constexpr int kWidth = 61;
constexpr int kHeight = 37;

output::PictureInfo some_info() {
    output::PictureInfo info;
    info.metadata = {{"Software", "terravox test"},
                     {"terravox:scene", "[camera]\nfov_deg = 40\n# Škofja Loka\n"},
                     {"terravox:crs_wkt", "PROJCS[\"D96/TM\"]"}};
    info.world_to_camera.emplace();
    info.world_to_ndc.emplace();
    for (std::size_t i = 0; i < 16; ++i)
        (*info.world_to_camera)[i] = static_cast<float>(i) * 0.5f,
        (*info.world_to_ndc)[i] = static_cast<float>(i) - 8;
    info.square_names = {"462_101", "463_101", "462_100",
                         "463_100"};  // of five: the last is unknown
    return info;
}

}  // namespace

TEST_CASE("an EXR with all layers gives back each of them", "[raytracer][output][layers]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "all.exr";
    output::Film film(kWidth, kHeight, true);
    film.add(synthetic_tile(0, 0, kWidth, kHeight, true));
    output::write_image(film, file, some_info());
    const PictureFile back = read_picture(file);
    const ExrHeader header(file);
    CHECK(entries_in(folder.path()) == 1);

    const auto near_half = [](float stored, float given) {
        return std::abs(stored - std::clamp(given, -65504.0f, 65504.0f)) <=
               std::abs(given) / 2048 + 1e-7f;
    };
    std::map<std::string, int> wrong;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const tiles::PixelSample& p = film.at(x, y);
            const tiles::LayerSample& l = film.layers_at(x, y);
            const auto exact = [&](const char* name, float given) {
                wrong[name] += same_bits(back.at(x, y, name), given) ? 0 : 1;
            };
            const auto about = [&](const char* name, float given) {
                wrong[name] += near_half(back.at(x, y, name), given) ? 0 : 1;
            };
            exact("R", p.colour.r);
            exact("G", p.colour.g);
            exact("B", p.colour.b);
            exact("A", p.alpha);
            exact("Z", p.depth_m);
            exact("position.X", l.position[0]);
            exact("position.Y", l.position[1]);
            exact("position.Z", l.position[2]);
            exact("material.ID", static_cast<float>(l.material));
            about("albedo.R", l.albedo.r);
            about("albedo.G", l.albedo.g);
            about("albedo.B", l.albedo.b);
            about("direct.R", l.direct.r);
            about("direct.G", l.direct.g);
            about("direct.B", l.direct.b);
            about("indirect.R", l.indirect.r);
            about("indirect.G", l.indirect.g);
            about("indirect.B", l.indirect.b);
            about("normal.X", l.normal[0]);
            about("normal.Y", l.normal[1]);
            about("normal.Z", l.normal[2]);
            about("sun.V", l.sun);
            about("water.V", l.water);
        }
    for (const auto& [name, count] : wrong) {
        INFO(name);
        CHECK(count == 0);
        CHECK(header.channels.count(name) == 1);
    }
    CHECK(header.channels.size() == wrong.size() + 24);
    CHECK(header.channels.at("Z") == 2);
    CHECK(header.channels.at("position.Y") == 2);
    CHECK(header.channels.at("CryptoMaterial00.r") == 2);
    CHECK(header.channels.at("normal.Y") == 1);
}

TEST_CASE("matrices and texts stand in the header under the names that other programs look for",
          "[raytracer][output][layers]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "all.exr";
    output::Film film(8, 8);
    film.add(synthetic_tile(0, 0, 8, 8, false));
    const output::PictureInfo info = some_info();
    output::write_image(film, file, info);
    const ExrHeader header(file);
    CHECK(header.matrix("worldToCamera") == *info.world_to_camera);
    CHECK(header.matrix("worldToNDC") == *info.world_to_ndc);
    CHECK(header.attributes.at("terravox:scene").value == info.metadata[1].second);
    CHECK(header.attributes.at("terravox:crs_wkt").value == info.metadata[2].second);
    CHECK(header.channels.size() == 5);
    CHECK(header.attributes.count("chromaticities") == 1);
    CHECK(header.attributes.count("capDate") == 0);  // two runs give the same bytes
    CHECK_FALSE(header.tiled);
}

TEST_CASE("a reader of Cryptomatte cuts out each material and each square with its share",
          "[raytracer][output][layers][cryptomatte]") {
    // Straight from the specification: find the mattes by their metadata, take the ids from the
    // manifest, add up the shares of the ranks.
    const TemporaryFolder folder;
    const auto file = folder.path() / "all.exr";
    output::Film film(kWidth, kHeight, true);
    film.add(synthetic_tile(0, 0, kWidth, kHeight, true));
    const output::PictureInfo info = some_info();
    output::write_image(film, file, info);
    const PictureFile back = read_picture(file);
    const ExrHeader header(file);
    int types = 0;
    for (const auto& [key, attribute] : header.attributes) {
        if (!key.starts_with("cryptomatte/") || !key.ends_with("/name"))
            continue;
        ++types;
        const std::string type = attribute.value;
        const std::string root = key.substr(0, key.rfind('/'));
        INFO(type);
        CHECK(root.size() == std::string("cryptomatte/").size() + 7);
        CHECK(header.attributes.at(root + "/hash").value == "MurmurHash3_32");
        CHECK(header.attributes.at(root + "/conversion").value == "uint32_to_float32");
        const auto manifest = nlohmann::json::parse(header.attributes.at(root + "/manifest").value);
        CHECK(
            manifest.size() ==
            (type == "CryptoSquare" ? 5 : voxel::kMaterialCount));  // of materials "unknown" is one
        std::map<std::uint32_t, std::string> names;
        for (const auto& [name, id] : manifest.items())
            names[static_cast<std::uint32_t>(std::stoul(id.get<std::string>(), nullptr, 16))] =
                name;
        std::vector<int> channels;
        for (int layer = 0; layer < 3; ++layer)
            for (const char* part : {".r", ".g", ".b", ".a"})
                channels.push_back(back.channel(type + "0" + std::to_string(layer) + part));
        int wrong = 0;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                std::map<std::string, float> read;
                std::map<std::string, float> given;
                float last = 2;
                for (std::size_t rank = 0; rank < 6; ++rank) {
                    const float id = back.at(x, y, channels[2 * rank]);
                    const float share = back.at(x, y, channels[2 * rank + 1]);
                    wrong += share <= last ? 0 : 1;
                    last = share;
                    if (share > 0)
                        read[names.count(std::bit_cast<std::uint32_t>(id)) != 0
                                 ? names[std::bit_cast<std::uint32_t>(id)]
                                 : "not in the manifest"] += share;
                }
                const tiles::LayerSample& l = film.layers_at(x, y);
                const tiles::Matte& matte = type == "CryptoSquare" ? l.squares : l.materials;
                for (std::size_t i = 0; i < tiles::Matte::kMax; ++i) {
                    if (!(matte.share[i] > 0))
                        continue;
                    const auto object = matte.object[i];
                    given[type != "CryptoSquare" ? std::string(voxel::material_name(
                                                       static_cast<voxel::Material>(object)))
                          : object < info.square_names.size() ? info.square_names[object]
                                                              : "unknown"] += matte.share[i];
                }
                wrong += read == given ? 0 : 1;
            }
        CHECK(wrong == 0);
    }
    CHECK(types == 2);
}
