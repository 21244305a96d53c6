#include "raytracer/core/tiles/tile_codec.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "common/util/error.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/tiles/synthetic_tiles.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

using Bytes = std::vector<std::byte>;

tiles::RenderTile rectangle(int x0, int y0, int x1, int y1, int step = 1, bool refines = false) {
    tiles::RenderTile tile;
    tile.index = 77;
    tile.pass = 2;
    tile.first_sample = 3;
    tile.samples = 9;
    tile.x0 = x0;
    tile.y0 = y0;
    tile.x1 = x1;
    tile.y1 = y1;
    tile.step = step;
    tile.refines = refines;
    return tile;
}

/// Of numbers alone, without gaps: as bytes.
template <class T>
Bytes to_bytes(const T& value) {
    const auto* at = reinterpret_cast<const std::byte*>(&value);
    return {at, at + sizeof value};
}

bool same(const tiles::PixelSample& a, const tiles::PixelSample& b) {
    return to_bytes(a) == to_bytes(b);
}
static_assert(sizeof(tiles::PixelSample) == 7 * sizeof(float));
bool same(const tiles::LayerSample& a, const tiles::LayerSample& b) {
    return to_bytes(a.direct) == to_bytes(b.direct) &&
           to_bytes(a.indirect) == to_bytes(b.indirect) &&
           to_bytes(a.albedo) == to_bytes(b.albedo) && to_bytes(a.normal) == to_bytes(b.normal) &&
           to_bytes(a.position) == to_bytes(b.position) && to_bytes(a.sun) == to_bytes(b.sun) &&
           to_bytes(a.water) == to_bytes(b.water) && a.material == b.material &&
           to_bytes(a.materials) == to_bytes(b.materials) &&
           to_bytes(a.squares) == to_bytes(b.squares);
}
bool same(const tiles::TileResult& a, const tiles::TileResult& b) {
    const auto alike = [](const auto& x, const auto& y) {
        return std::equal(x.begin(), x.end(), y.begin(), y.end(),
                          [](const auto& p, const auto& q) { return same(p, q); });
    };
    return a.tile == b.tile && alike(a.samples, b.samples) && alike(a.layers, b.layers) &&
           a.bands == b.bands && a.holes == b.holes && to_bytes(a.counts) == to_bytes(b.counts);
}

// Where numbers lie in encoded bytes; the format is fixed, so the test may know it.
constexpr std::size_t kFlagsAt = 9;
constexpr std::size_t kX0At = 18;
constexpr std::size_t kY0At = 22;
constexpr std::size_t kX1At = 26;
constexpr std::size_t kY1At = 30;
constexpr std::size_t kStepAt = 34;
constexpr std::size_t kHolesAt = 46;
constexpr std::size_t kSecondsAt = 50 + 13 * 8;
constexpr std::size_t kPlanesAt = 50 + 20 * 8;

/// Changes bytes as an attacker would: with a valid checksum.
template <class T>
Bytes forged(Bytes bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
    const std::uint64_t checksum = XXH3_64bits_withSeed(bytes.data() + 9, bytes.size() - 9, 1);
    std::memcpy(bytes.data() + 1, &checksum, sizeof checksum);
    return bytes;
}

using Pixel = tiles::PixelSample;
using Layers = tiles::LayerSample;
using Tile = tiles::TileResult;

}  // namespace

TEST_CASE("a decoded tile equals the encoded one, bit by bit", "[raytracer][tiles][codec]") {
    struct Case {
        const char* name;
        tiles::RenderTile tile;
    };
    const auto c =
        GENERATE(values<Case>({{"one pixel", rectangle(0, 0, 1, 1)},
                               {"a usual tile", rectangle(64, 128, 128, 192)},
                               {"an odd rest", rectangle(1900, 1077, 1921, 1080)},
                               {"a coarse pass", rectangle(64, 0, 128, 64, 8)},
                               {"a pass that refines", rectangle(60, 3, 131, 64, 4, true)},
                               {"a tile without a pixel", rectangle(1, 1, 3, 3, 64)}}));
    const bool with_layers = GENERATE(false, true);
    DYNAMIC_SECTION(c.name << (with_layers ? ", layers" : "")) {
        for (unsigned seed = 1; seed <= 20; ++seed) {
            INFO("seed " << seed);
            const tiles::TileResult tile = tile_of_chance(c.tile, with_layers, seed);
            const Bytes bytes = tiles::encode_tile(tile);
            REQUIRE(same(tiles::decode_tile(bytes, "test"), tile));
            CHECK(tiles::encode_tile(tile) == bytes);
            const tiles::TileHead head = tiles::read_tile_head(bytes, "test");
            CHECK(head.tile == tile.tile);
            CHECK(head.pixels == tile.samples.size());
            CHECK(head.holes == tile.holes.size());
            CHECK(head.content.layers == !tile.layers.empty());
        }
    }
}

TEST_CASE("measured values survive encoding, and count for the hash", "[raytracer][tiles][codec]") {
    for (std::size_t bands = 1; bands <= core::kMaxBands; ++bands) {
        INFO(bands << " bands");
        tiles::TileResult tile = tile_of_chance(rectangle(3, 5, 20, 16), bands % 2 == 0, 9);
        for (std::size_t i = 0; i < bands * tile.samples.size(); ++i)
            tile.bands.push_back(static_cast<float>(i) * 0.25F - 300);
        tile.bands[1] = core::kNoData;
        const Bytes bytes = tiles::encode_tile(tile);
        REQUIRE(same(tiles::decode_tile(bytes, "test"), tile));
        CHECK(tiles::read_tile_head(bytes, "test").content.bands == bands);
        tiles::TileResult other = tile;
        other.bands.back() += 1;
        CHECK(tiles::hash_of_pixels(other) != tiles::hash_of_pixels(tile));
        tiles::RenderTile first_rows = tile.tile;
        first_rows.y1 = 10;
        CHECK(tiles::hash_of_pixels(other, first_rows) == tiles::hash_of_pixels(tile, first_rows));
    }
}

TEST_CASE("measured values that no cell has are refused", "[raytracer][tiles][codec]") {
    tiles::TileResult tile = tile_of_chance(rectangle(0, 0, 4, 2), false, 3);
    tile.bands.assign(2 * tile.samples.size(), 1);
    const Bytes bytes = tiles::encode_tile(tile);
    for (const std::uint8_t count : {0, 1, 3, 9, 255}) {
        INFO(static_cast<int>(count) << " bands");
        CHECK_THROWS_AS(tiles::decode_tile(forged(bytes, kHolesAt, count), "test"), util::Error);
    }
    tile.bands[5] = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(tiles::decode_tile(tiles::encode_tile(tile), "test"), contains("not finite"));
    tile.bands.pop_back();
    CHECK_THROWS_AS(tiles::encode_tile(tile), util::Error);
    tile.bands.assign((core::kMaxBands + 1) * tile.samples.size(), 1);
    CHECK_THROWS_AS(tiles::encode_tile(tile), util::Error);
}

TEST_CASE("bytes that were cut short anywhere are refused", "[raytracer][tiles][codec]") {
    const Bytes bytes = tiles::encode_tile(tile_of_chance(rectangle(0, 0, 7, 5), true, 5));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        INFO(size << " of " << bytes.size());
        REQUIRE_THROWS_AS(tiles::decode_tile(std::span(bytes).first(size), "test"), util::Error);
        REQUIRE_THROWS_AS(tiles::read_tile_head(std::span(bytes).first(size), "test"), util::Error);
        if (size > kPlanesAt) {
            const Bytes forged_rest =
                forged(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)),
                       kFlagsAt, bytes[kFlagsAt]);
            REQUIRE_THROWS_AS(tiles::decode_tile(forged_rest, "test"), util::Error);
        }
    }
    Bytes longer = bytes;
    longer.push_back(std::byte{0});
    CHECK_THROWS_AS(tiles::decode_tile(longer, "test"), util::Error);
    CHECK_THROWS_WITH(tiles::decode_tile(forged(longer, kFlagsAt, bytes[kFlagsAt]), "test"),
                      contains("not one whole zstd frame"));
}

TEST_CASE("a single bit that changed anywhere is noticed", "[raytracer][tiles][codec]") {
    const Bytes bytes = tiles::encode_tile(tile_of_chance(rectangle(0, 0, 7, 5), true, 6));
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        Bytes damaged = bytes;
        damaged[bit / 8] ^= std::byte{1} << static_cast<int>(bit % 8);
        INFO("bit " << bit);
        REQUIRE_THROWS_AS(tiles::decode_tile(damaged, "test"), util::Error);
    }
    CHECK_THROWS_WITH(tiles::decode_tile(Bytes{std::byte{2}, std::byte{0}}, "worker 7"),
                      contains("read the tile worker 7: version 2; allowed: 1"));
}

TEST_CASE("bytes of chance are refused, with a checksum that is right, too",
          "[raytracer][tiles][codec]") {
    const Bytes bytes = tiles::encode_tile(tile_of_chance(rectangle(0, 0, 9, 4), true, 7));
    std::mt19937 random(8);
    int refused = 0;
    for (int run = 0; run < 20'000; ++run) {
        Bytes damaged = bytes;
        for (unsigned i = 1 + random() % 3; i > 0; --i)
            damaged[9 + random() % (damaged.size() - 9)] = static_cast<std::byte>(random());
        damaged = forged(damaged, kFlagsAt, damaged[kFlagsAt]);
        try {
            // What is believed must be a tile: it can be encoded.
            (void)tiles::encode_tile(tiles::decode_tile(damaged, "test"));
        } catch (const util::Error&) {
            ++refused;
        }
    }
    CHECK(refused > 1000);
}

TEST_CASE("hostile heads are refused before any memory is taken for pixels",
          "[raytracer][tiles][codec]") {
    constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();
    constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min();
    const Bytes bytes = tiles::encode_tile(tile_of_chance(rectangle(16, 32, 24, 40), true, 9));
    struct Case {
        const char* name;
        std::size_t at;
        std::int32_t value;
        const char* said;
    };
    const auto c =
        GENERATE(values<Case>({{"left beyond right", kX0At, 24, "rectangle"},
                               {"top beyond bottom", kY0At, 41, "rectangle"},
                               {"left of the picture", kX0At, -1, "rectangle"},
                               {"above the picture", kY0At, kMin, "rectangle"},
                               {"far right", kX1At, kMax, "rectangle"},
                               {"far below", kY1At, kMax, "rectangle"},
                               {"an odd step", kStepAt, 3, "step 3; allowed"},
                               {"the largest step", kStepAt, 1 << 30, "step"},
                               {"wider than its pixels", kX1At, 25, "requires"},
                               {"wide", kX1At, 1 << 20, "bytes of pixels"},
                               {"more than may be", kX1At, 1 << 24, "allowed: up to 1073741824"},
                               {"as many holes as can be", kHolesAt, -1, "holes in"},
                               {"more holes than there are", kHolesAt, 100'000, "holes in"}}));
    DYNAMIC_SECTION(c.name) {
        const Bytes hostile = forged(bytes, c.at, c.value);
        CHECK_THROWS_AS(tiles::decode_tile(hostile, "test"), util::Error);
        CHECK_THROWS_WITH(tiles::decode_tile(hostile, "test"), contains(c.said));
    }
    CHECK_THROWS_WITH(tiles::decode_tile(forged(bytes, kFlagsAt, std::uint8_t{0}), "test"),
                      contains("requires"));
    CHECK_THROWS_WITH(tiles::decode_tile(forged(bytes, kFlagsAt, std::uint8_t{8}), "test"),
                      contains("flags"));
    CHECK_THROWS_WITH(tiles::decode_tile(forged(bytes, kSecondsAt, -1.0), "test"),
                      contains("times below 0"));
}

TEST_CASE("holes are boxes that there can be, each once", "[raytracer][tiles][codec]") {
    tiles::TileResult tile = tile_of_chance(rectangle(0, 0, 4, 4), false, 10);
    tile.holes = {{0, 1, 2, 3}, {0, 1, 2, 4}, {20, -1, 0, 1 << 30}};
    const Bytes bytes = tiles::encode_tile(tile);
    CHECK(tiles::decode_tile(bytes, "test").holes == tile.holes);
    CHECK_THROWS_WITH(tiles::decode_tile(forged(bytes, kPlanesAt + 32, 21), "test"),
                      contains("level 21; allowed: 0 to 20"));
    CHECK_THROWS_WITH(tiles::decode_tile(forged(bytes, kPlanesAt, -1), "test"),
                      contains("level -1"));
    CHECK_THROWS_WITH(tiles::decode_tile(forged(bytes, kPlanesAt + 28, 3), "test"),
                      contains("not in order"));
}

TEST_CASE("values that no pixel can have are refused", "[raytracer][tiles][codec]") {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    struct Case {
        const char* name;
        void (*spoil)(Pixel&, Layers&);
        bool refused = true;
    };
    const auto c = GENERATE(values<Case>({
        {"untouched", [](Pixel&, Layers&) {}, false},
        {"infinitely far", [](Pixel& s, Layers&) { s.depth_m = kInfinity; }, false},
        {"all of it", [](Pixel& s, Layers&) { s.alpha = 1; }, false},
        {"a colour below 0", [](Pixel& s, Layers&) { s.colour.g = -1; }, false},
        {"no number", [](Pixel& s, Layers&) { s.colour.r = kNan; }},
        {"endless light", [](Pixel& s, Layers&) { s.colour.b = kInfinity; }},
        {"more than all", [](Pixel& s, Layers&) { s.alpha = 1.0001f; }},
        {"less than none", [](Pixel& s, Layers&) { s.alpha = -0.1f; }},
        {"behind the eye", [](Pixel& s, Layers&) { s.depth_m = -1; }},
        {"no depth", [](Pixel& s, Layers&) { s.depth_m = kNan; }},
        {"no samples", [](Pixel& s, Layers&) { s.samples = 0; }},
        {"error below 0", [](Pixel& s, Layers&) { s.error = -1; }},
        {"no error", [](Pixel& s, Layers&) { s.error = kNan; }},
        {"endless error", [](Pixel& s, Layers&) { s.error = kInfinity; }},
        {"direct", [](Pixel&, Layers& l) { l.direct.r = kNan; }},
        {"indirect", [](Pixel&, Layers& l) { l.indirect.g = kInfinity; }},
        {"albedo", [](Pixel&, Layers& l) { l.albedo.b = kNan; }},
        {"normal", [](Pixel&, Layers& l) { l.normal[2] = kNan; }},
        {"position", [](Pixel&, Layers& l) { l.position[0] = -kInfinity; }},
        {"sun", [](Pixel&, Layers& l) { l.sun = 2; }},
        {"water", [](Pixel&, Layers& l) { l.water = kNan; }},
        {"material",
         [](Pixel&, Layers& l) {
             l.material = static_cast<voxel::Material>(voxel::kMaterialCount);
         }},
        {"share of a material", [](Pixel&, Layers& l) { l.materials.share[5] = -0.5f; }},
        {"a matte's material",
         [](Pixel&, Layers& l) { l.materials.object[0] = voxel::kMaterialCount; }},
        {"share of a square", [](Pixel&, Layers& l) { l.squares.share[0] = kInfinity; }},
        {"any square", [](Pixel&, Layers& l) { l.squares.object[0] = ~0U; }, false},
    }));
    DYNAMIC_SECTION(c.name) {
        tiles::TileResult tile = tile_of_chance(rectangle(0, 0, 6, 6), true, 12);
        c.spoil(tile.samples[17], tile.layers[17]);
        const Bytes bytes = tiles::encode_tile(tile);
        if (c.refused)
            CHECK_THROWS_AS(tiles::decode_tile(bytes, "test"), util::Error);
        else
            CHECK(same(tiles::decode_tile(bytes, "test"), tile));
    }
}

TEST_CASE("a tile that is not whole, or too large, is not encoded", "[raytracer][tiles][codec]") {
    tiles::TileResult tile = tile_of_chance(rectangle(0, 0, 6, 6), true, 13);
    tile.samples.pop_back();
    CHECK_THROWS_WITH(tiles::encode_tile(tile),
                      contains("encode the tile 77: 35 samples and 36 of its layers; allowed: 36"));
    tile = tile_of_chance(rectangle(0, 0, 6, 6), true, 13);
    tile.layers.pop_back();
    CHECK_THROWS_AS(tiles::encode_tile(tile), util::Error);
    tile = {};
    tile.tile = rectangle(5, 0, 5, 6);
    CHECK_THROWS_WITH(tiles::encode_tile(tile), contains("rectangle"));
}

TEST_CASE("the hash of pixels is that of what they show, and nothing else",
          "[raytracer][tiles][codec]") {
    const tiles::TileResult tile = tile_of_chance(rectangle(0, 0, 40, 30), true, 14);
    const std::uint64_t hash = tiles::hash_of_pixels(tile);
    tiles::TileResult same_pixels = tile;
    same_pixels.counts = {};
    same_pixels.holes.clear();
    same_pixels.tile.index = 5;
    CHECK(tiles::hash_of_pixels(same_pixels) == hash);
    CHECK(tiles::hash_of_pixels(tiles::decode_tile(tiles::encode_tile(tile), "test")) == hash);
    // Bytes between the fields of a layer do not count.
    std::vector<std::byte> dirt(sizeof(tiles::LayerSample) * tile.layers.size(), std::byte{0xa5});
    auto* layers = reinterpret_cast<tiles::LayerSample*>(dirt.data());
    tiles::TileResult dirty = tile;
    for (std::size_t i = 0; i < tile.layers.size(); ++i) {
        const tiles::LayerSample& from = tile.layers[i];
        tiles::LayerSample& to = layers[i];
        to.direct = from.direct;
        to.indirect = from.indirect;
        to.albedo = from.albedo;
        to.normal = from.normal;
        to.position = from.position;
        to.sun = from.sun;
        to.water = from.water;
        to.material = from.material;
        to.materials = from.materials;
        to.squares = from.squares;
        std::memcpy(static_cast<void*>(&dirty.layers[i]), &to, sizeof to);
    }
    CHECK(tiles::hash_of_pixels(dirty) == hash);
    CHECK(tiles::encode_tile(dirty) == tiles::encode_tile(tile));

    std::set<std::uint64_t> seen{hash};
    const auto differs = [&](const char* what, auto change) {
        tiles::TileResult other = tile;
        change(other.samples[700], other.layers[700], other);
        INFO(what);
        CHECK(seen.insert(tiles::hash_of_pixels(other)).second);
    };
    differs("colour",
            [](Pixel& s, Layers&, Tile&) { s.colour.r = std::nextafter(s.colour.r, 9.0f); });
    differs("alpha", [](Pixel& s, Layers&, Tile&) { s.alpha += 0.25f; });
    differs("depth", [](Pixel& s, Layers&, Tile&) { s.depth_m = 12345; });
    differs("samples", [](Pixel& s, Layers&, Tile&) { ++s.samples; });
    differs("error", [](Pixel& s, Layers&, Tile&) { s.error += 1; });
    differs("direct", [](Pixel&, Layers& l, Tile&) { l.direct.g += 1e10f; });
    differs("material", [](Pixel&, Layers& l, Tile&) {
        l.material =
            l.material == voxel::Material::kRock ? voxel::Material::kSoil : voxel::Material::kRock;
    });
    differs("matte", [](Pixel&, Layers& l, Tile&) { l.squares.object[5] += 1; });
    differs("share", [](Pixel&, Layers& l, Tile&) { l.materials.share[5] += 0.125f; });
    differs("one less", [](Pixel&, Layers&, Tile& t) {
        t.samples.pop_back();
        t.layers.pop_back();
    });
    differs("no layers", [](Pixel&, Layers&, Tile& t) { t.layers.clear(); });
    differs("order", [](Pixel& s, Layers&, Tile& t) { std::swap(s, t.samples[701]); });
}

TEST_CASE("the hash of rows is that of a tile of those rows", "[raytracer][tiles][codec]") {
    const bool with_layers = GENERATE(false, true);
    const int step = GENERATE(1, 2);
    const int y0 = GENERATE(64, 72, 90);
    const int y1 = GENERATE(72, 91, 96);
    if (y0 >= y1)
        return;
    const tiles::TileResult whole =
        tile_of_chance(rectangle(32, 64, 61, 96, step, step == 1), with_layers, 5);
    tiles::TileResult rows;
    rows.tile = whole.tile;
    rows.tile.y0 = y0;
    rows.tile.y1 = y1;
    std::size_t at = 0;
    whole.tile.each_pixel([&](int, int y) {
        if (y >= y0 && y < y1) {
            rows.samples.push_back(whole.samples[at]);
            if (with_layers)
                rows.layers.push_back(whole.layers[at]);
        }
        ++at;
    });
    CHECK(tiles::hash_of_pixels(whole, rows.tile) == tiles::hash_of_pixels(rows));
    CHECK(tiles::hash_of_pixels(whole, whole.tile) == tiles::hash_of_pixels(whole));
    if (rows.samples.empty())
        return;
    ++rows.samples.back().samples;
    CHECK(tiles::hash_of_pixels(whole, rows.tile) != tiles::hash_of_pixels(rows));
}
