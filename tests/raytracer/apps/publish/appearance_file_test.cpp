#include "raytracer/apps/publish/appearance_file.hpp"

#include <libdeflate.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/util/det_math.hpp"
#include "common/util/folders.hpp"
#include "raytracer/core/material/material_table.hpp"
#include "raytracer/core/sky/dome.hpp"
#include "raytracer/core/sky/sky_table.hpp"
#include "tests/catch.hpp"

using namespace terravox;

namespace {

float from_half(std::uint16_t half) {
    const int exponent = half >> 10 & 31;
    const int mantissa = half & 0x3ff;
    const float size = exponent == 0
                           ? std::ldexp(static_cast<float>(mantissa), -24)
                           : std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25);
    return (half & 0x8000) != 0 ? -size : size;
}

std::string unpacked(const std::string& gzip) {
    std::string out(std::size_t{4} << 20, '\0');
    std::size_t bytes = 0;
    libdeflate_decompressor* reader = libdeflate_alloc_decompressor();
    REQUIRE(reader != nullptr);
    const auto result = libdeflate_gzip_decompress(reader, gzip.data(), gzip.size(), out.data(),
                                                   out.size(), &bytes);
    libdeflate_free_decompressor(reader);
    REQUIRE(result == LIBDEFLATE_SUCCESS);
    out.resize(bytes);
    return out;
}

/// appearance.bin as its format describes it.
struct Parsed {
    nlohmann::json facts;
    std::string halves;

    explicit Parsed(const std::string& compressed) {
        const std::string file = unpacked(compressed);
        REQUIRE(file.substr(0, 8) == "TVXLOOK\n");
        std::uint32_t version = 0;
        std::uint32_t bytes = 0;
        std::memcpy(&version, file.data() + 8, 4);
        std::memcpy(&bytes, file.data() + 12, 4);
        REQUIRE(version == 1);
        REQUIRE(bytes % 8 == 0);
        facts = nlohmann::json::parse(file.substr(16, bytes));
        halves = file.substr(16 + bytes);
    }
    [[nodiscard]] std::vector<float> array(const char* name) const {
        const auto& part = facts["arrays"][name];
        std::vector<float> out(part["halves"].get<std::size_t>());
        for (std::size_t i = 0; i < out.size(); ++i) {
            std::uint16_t half = 0;
            std::memcpy(&half, halves.data() + part["offset"].get<std::size_t>() + 2 * i, 2);
            out[i] = from_half(half);
        }
        return out;
    }
};

const material::MaterialAppearances& appearances() {
    static const auto read = material::read_materials(material::find_materials("")).appearances;
    return read;
}

const Parsed& parsed() {
    static const Parsed file(publish::appearance_file(appearances(), {}));
    return file;
}

}  // namespace

TEST_CASE("a float survives as the nearest half", "[publish]") {
    CHECK(publish::to_half(0) == 0);
    CHECK(publish::to_half(1) == 0x3c00);
    CHECK(publish::to_half(-2) == 0xc000);
    CHECK(publish::to_half(65504) == 0x7bff);
    CHECK(publish::to_half(1e9f) == 0x7bff);
    CHECK(publish::to_half(-INFINITY) == 0xfbff);
    CHECK(publish::to_half(NAN) == 0);
    CHECK(publish::to_half(0x1p-24f) == 1);
    CHECK(publish::to_half(0x1p-26f) == 0);
    for (int half = 0; half < 0x7c00; ++half)
        REQUIRE(publish::to_half(from_half(static_cast<std::uint16_t>(half))) == half);
    for (float v = 1e-6f; v < 6e4f; v *= 1.37f)
        REQUIRE(std::abs(from_half(publish::to_half(v)) - v) <= std::max(v * 0x1p-11f, 0x1p-25f));
}

TEST_CASE("drawings of materials are found where the file says", "[publish]") {
    const material::MaterialTable table(appearances());
    const std::vector<float> ratio = parsed().array("ratio");
    const std::vector<float> own = parsed().array("own");
    REQUIRE(parsed().facts["materials"].size() == voxel::kMaterialCount);
    for (std::size_t i = 0; i < voxel::kMaterialCount; ++i) {
        const auto material = static_cast<voxel::Material>(i);
        const auto& facts = parsed().facts["materials"][i];
        CHECK(facts["name"] == voxel::material_name(material));
        for (const auto& [name, side] :
             {std::pair{"side", core::Face::kWest}, std::pair{"bottom", core::Face::kBottom},
              std::pair{"top", core::Face::kTop}}) {
            const material::PaintedFace& face = table.painted(material, side);
            const auto& painted = facts[name];
            REQUIRE(painted["variants"] == face.variants);
            if (face.variants == 0)
                continue;
            const std::uint32_t variant = face.variants - 1;
            const std::uint32_t texel =
                variant * material::kMipAt[material::kMips] + material::kMipAt[1] + 5 * 8 + 3;
            const material::Dot dot = table.pool().dot(face, variant, 1, 3, 5);
            const std::size_t at = (painted["first"].get<std::size_t>() + texel) * 4;
            REQUIRE(at + 3 < ratio.size());
            CHECK(std::abs(ratio[at] - dot.ratio.r) <= dot.ratio.r * 0x1p-10f);
            CHECK(std::abs(ratio[at + 3] - dot.opacity) <= 0x1p-10f);
            if (!face.has_own)
                continue;
            const std::size_t own_at = (painted["ownFirst"].get<std::size_t>() + texel) * 4;
            REQUIRE(own_at + 3 < own.size());
            CHECK(std::abs(own[own_at + 3] - dot.share) <= 0x1p-10f);
        }
    }
}

TEST_CASE("the sky of the file is that of the program", "[publish]") {
    const auto& facts = parsed().facts["sky"];
    const int rows = facts["rows"];
    const int columns = facts["columns"];
    const std::vector<float> nodes = parsed().array("sky");
    const std::size_t altitudes = facts["altitudes_deg"].size();
    REQUIRE(nodes.size() == altitudes * static_cast<std::size_t>(rows * columns * 9));
    const sky::Atmosphere air(2.5);
    for (const std::size_t i : {std::size_t{5}, std::size_t{12}, altitudes - 3}) {
        const double altitude_deg = facts["altitudes_deg"][i];
        const sky::SkyTable table(sky::Scattering(air, altitude_deg * det::kPi / 180), 0,
                                  sky::picture_scale() * det::kPi);
        // At a node of both: the horizon under the sun, and the zenith.
        const auto check = [&](int row, int column, double elevation, double azimuth_cosine) {
            const double sun_cosine = 0.3;
            const voxel::Colour wanted = table.at(elevation, azimuth_cosine, sun_cosine);
            const float* node = &nodes[(i * static_cast<std::size_t>(rows * columns) +
                                        static_cast<std::size_t>(row * columns + column)) *
                                       9];
            const auto red = static_cast<float>(sky::rayleigh_phase(sun_cosine)) * node[0] +
                             static_cast<float>(sky::mie_phase(sun_cosine)) * node[3] + node[6];
            CHECK(std::abs(red - wanted.r) <= 2e-3f * std::abs(wanted.r) + 1e-6f);
        };
        check(0, 0, 0, 1);
        check(0, columns - 1, 0, -1);
        check(rows - 1, 0, 1, 1);
    }
}
