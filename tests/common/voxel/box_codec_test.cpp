#include "common/voxel/box.hpp"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"

using namespace terravox;
using namespace terravox::voxel;
using terravox::test::contains;
using terravox::test::random_scene;
using terravox::test::Scene;
using terravox::test::to_attr;

namespace {

using Bytes = std::vector<std::byte>;
constexpr BoxKey kCodedKey{2, -70'000, -1, 123'456};

// Where the fields of the blob's header lie (docs/formats/box.md).
constexpr std::size_t kVersionAt = 8;
constexpr std::size_t kLevelAt = 12;
constexpr std::size_t kCellCountAt = 28;
constexpr std::size_t kAttrCountAt = 32;
constexpr std::size_t kChecksumAt = 56;
constexpr std::size_t kCellsAt = 64;

// Small enough that every prefix can be tried.
Scene small_scene() {
    Scene scene;
    std::mt19937 random(3);
    for (int z = 20; z < 28; ++z)
        for (int x = 30; x < 40; ++x)
            scene.add(x, z, 60, 62 + static_cast<int>(random() % 9), random() % 5 != 0);
    return scene;
}

Bytes make_copy(std::span<const std::byte> bytes) {
    return {bytes.begin(), bytes.end()};
}
bool same(std::span<const std::byte> a, std::span<const std::byte> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

template <class T>
Bytes with(Bytes blob, std::size_t at, T value) {
    std::memcpy(blob.data() + at, &value, sizeof value);
    return blob;
}

// What a hostile or broken writer could send: wrong fields under a right checksum.
Bytes signed_again(Bytes blob) {
    const auto seed = XXH64(blob.data(), kChecksumAt, 0);
    return with(blob, kChecksumAt,
                std::uint64_t{XXH64(blob.data() + kCellsAt, blob.size() - kCellsAt, seed)});
}

Bytes zstd_frame(const Bytes& content) {
    Bytes out(ZSTD_compressBound(content.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), content.data(), content.size(), 1));
    return out;
}

// "refused: <message>" for an Error, "the same box" or "another box"; anything else that is thrown
// fails the test.
template <class Read>
std::string outcome(const Box& original, const Read& read) {
    try {
        const std::shared_ptr<const Box> box = read();
        return same(box->blob(), original.blob()) ? "the same box" : "another box";
    } catch (const util::Error& e) {
        return std::string("refused: ") + e.what();
    }
}

}  // namespace

TEST_CASE("a box survives compression, byte for byte", "[common][voxel][codec]") {
    struct Case {
        const char* name;
        std::shared_ptr<const Box> box;
    };
    Scene full;
    for (int z = -1; z < 65; ++z)
        for (int x = -1; x < 65; ++x)
            full.add(x, z, -1, 257, true);
    const auto c = GENERATE_COPY(values<Case>({
        {"a few voxels", small_scene().build(kCodedKey, to_attr)},
        {"hills and trees", random_scene(4).build(kCodedKey, to_attr)},
        {"solid rock", full.build(kCodedKey, to_attr)},
    }));
    const int level = GENERATE(1, 9);
    DYNAMIC_SECTION(c.name << ", zstd level " << level) {
        const auto back = decompress_box(compress(*c.box, level), "test");
        CHECK(same(back->blob(), c.box->blob()));
        CHECK(back->key() == kCodedKey);
        CHECK(back->checksum() == c.box->checksum());
        CHECK(back->attrs().size() == c.box->attrs().size());
        CHECK(back->top() == c.box->top());
        CHECK(same(Box::from_blob(c.box->blob(), "test")->blob(), c.box->blob()));
    }
}

TEST_CASE("a frame or blob that is cut off, or has more bytes, is refused",
          "[common][voxel][codec]") {
    const auto box = small_scene().build(kCodedKey, to_attr);
    Bytes frame = compress(*box);
    Bytes blob = make_copy(box->blob());
    for (std::size_t size = 0; size < blob.size(); ++size) {
        INFO(size << " of " << frame.size() << " and " << blob.size() << " bytes");
        CHECK_THROWS_AS(Box::from_blob(std::span(blob).first(size), "test"), util::Error);
        if (size < frame.size())
            CHECK_THROWS_AS(decompress_box(std::span(frame).first(size), "test"), util::Error);
    }
    frame.push_back(std::byte{0});
    blob.push_back(std::byte{0});
    CHECK_THROWS_AS(decompress_box(frame, "test"), util::Error);
    CHECK_THROWS_AS(Box::from_blob(blob, "test"), util::Error);
}

TEST_CASE("a damaged blob is refused, whichever bit has flipped", "[common][voxel][codec]") {
    const auto box = small_scene().build(kCodedKey, to_attr);
    Bytes blob = make_copy(box->blob());
    for (std::size_t bit = 0; bit < blob.size() * 8; bit += bit < kCellsAt * 8 ? 1 : 13) {
        INFO("bit " << bit);
        blob[bit / 8] ^= std::byte{1} << (bit % 8);
        CHECK_THROWS_AS(Box::from_blob(blob, "test"), util::Error);
        blob[bit / 8] ^= std::byte{1} << (bit % 8);
    }
}

// zstd ignores a few bits of its own frame header, so a flip there may still give the box: but
// never another one.
TEST_CASE("a damaged frame is refused or harmless, never another box", "[common][voxel][codec]") {
    const auto box = random_scene(8).build(kCodedKey, to_attr);
    const Bytes frame = compress(*box);
    std::mt19937_64 random(8);
    int refused = 0;
    constexpr int kTries = 400;
    for (int i = 0; i < kTries; ++i) {
        Bytes damaged = frame;
        // Half of the flips go to the first bytes, where the sizes and tables are.
        const std::size_t at =
            random() % (i % 2 == 0 ? damaged.size() : std::min<std::size_t>(damaged.size(), 64));
        const auto flip = static_cast<std::byte>(1 + random() % 255);
        damaged[at] ^= flip;
        const auto result = outcome(*box, [&] { return decompress_box(damaged, "test"); });
        INFO("byte " << at << " ^ " << static_cast<int>(flip) << ": " << result);
        CHECK(result != "another box");
        refused += result != "the same box";
    }
    CHECK(refused > kTries * 9 / 10);
}

TEST_CASE("a blob that lies under a right checksum is refused by what is wrong",
          "[common][voxel][codec]") {
    const auto box = small_scene().build(kCodedKey, to_attr);
    const Bytes good = make_copy(box->blob());
    const auto cells = static_cast<std::uint32_t>(box->cells().size());
    const auto attrs = static_cast<std::uint32_t>(box->attrs().size());
    const std::size_t last_cell = kCellsAt + (cells - 1) * sizeof(TreeCell);
    const std::size_t first_root = kCellsAt;
    constexpr std::size_t kMaskAt = 0;
    constexpr std::size_t kDetailAt = 8;
    constexpr std::size_t kFirstAt = 16;
    struct Case {
        const char* name;
        Bytes blob;
        const char* said;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"another format", with(good, 0, 'X'), "magic"},
        {"an older version", with(good, kVersionAt, std::uint32_t{0}),
         "format version 0; allowed: 1"},
        {"a newer version", with(good, kVersionAt, std::uint32_t{2}),
         "format version 2; allowed: 1"},
        {"a level below zero", with(good, kLevelAt, std::int32_t{-1}),
         "level -1; allowed: 0 to 20"},
        {"a level too high", with(good, kLevelAt, std::int32_t{21}), "level 21"},
        {"no roots", with(good, kCellCountAt, std::uint32_t{0}), "0 cells"},
        {"more cells than fit", with(good, kCellCountAt, ~std::uint32_t{0}), "4294967295 cells"},
        {"more voxels than fit", with(good, kAttrCountAt, ~std::uint32_t{0}), "4294967295 voxels"},
        {"one cell too many", with(good, kCellCountAt, cells + 1), "promises"},
        {"one voxel too few", with(good, kAttrCountAt, attrs - 1), "promises"},
        {"three voxels for one cell",
         with(with(good, kCellCountAt, cells - 1), kAttrCountAt, attrs + 3), "index"},
        {"details in air", with(good, last_cell + kMaskAt, std::uint64_t{0}), "index"},
        {"a voxel more than stored",
         with(with(good, last_cell + kMaskAt, ~std::uint64_t{0}), last_cell + kDetailAt,
              ~std::uint64_t{0}),
         "index"},
        {"a cell that leads outside", with(good, last_cell + kFirstAt, ~std::uint32_t{0}), "index"},
        {"a root that leads to itself", with(good, first_root + kFirstAt, std::uint32_t{0}),
         "index"},
        {"a root with children that are not there",
         with(with(good, first_root + kMaskAt, ~std::uint64_t{0}), first_root + kDetailAt,
              ~std::uint64_t{0}),
         "index"},
        {"cells that no root leads to", with(good, first_root + kDetailAt, std::uint64_t{0}),
         "index"},
    }));
    DYNAMIC_SECTION(c.name) {
        const Bytes blob = signed_again(c.blob);
        CHECK_THROWS_AS(Box::from_blob(blob, "2/1/0/3"), util::Error);
        CHECK_THROWS_WITH(Box::from_blob(blob, "2/1/0/3"),
                          contains("read the box 2/1/0/3") && contains(c.said));
        CHECK_THROWS_WITH(decompress_box(zstd_frame(blob), "2/1/0/3"),
                          contains("read the box 2/1/0/3") && contains(c.said));
    }
}

TEST_CASE("no random cells under a right checksum can lead a reader outside the box",
          "[common][voxel][codec]") {
    const auto box = small_scene().build(kCodedKey, to_attr);
    std::mt19937_64 random(17);
    int refused = 0;
    for (int i = 0; i < 300; ++i) {
        Bytes blob = make_copy(box->blob());
        const std::size_t at = kCellsAt + random() % (box->cells().size_bytes());
        blob[at] ^= static_cast<std::byte>(1 + random() % 255);
        blob = signed_again(blob);
        INFO("try " << i << ", byte " << at);
        try {
            const auto read = Box::from_blob(blob, "test");
            std::size_t solid = 0;
            for (int y = 0; y < kBoxSizeY; y += 1)
                for (int z = 16; z < 32; ++z)
                    for (int x = 28; x < 44; ++x)
                        solid += read->solid(x, y, z);
            CHECK(solid <= std::size_t{256} * 16 * 16);
            CHECK((read->top() >= 0 && read->top() <= kBoxSizeY));
        } catch (const util::Error&) {
            ++refused;
        }
    }
    CHECK(refused > 0);
}

TEST_CASE("frames that are no boxes are refused before they cost memory",
          "[common][voxel][codec]") {
    const auto text = [](std::string_view s) { return make_copy(std::as_bytes(std::span(s))); };
    Bytes unknown_size(64);
    {
        ZSTD_CCtx* stream = ZSTD_createCCtx();
        const Bytes content(8);
        ZSTD_inBuffer in{content.data(), content.size(), 0};
        ZSTD_outBuffer out{unknown_size.data(), unknown_size.size(), 0};
        ZSTD_compressStream2(stream, &out, &in, ZSTD_e_continue);
        ZSTD_compressStream2(stream, &out, &in, ZSTD_e_end);
        unknown_size.resize(out.pos);
        ZSTD_freeCCtx(stream);
    }
    struct Case {
        const char* name;
        Bytes frame;
        const char* said;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing", {}, "not a zstd frame"},
        {"a web page", text("<html>404 Not Found</html>"), "not a zstd frame"},
        {"a frame of unknown size", unknown_size, "known size"},
        {"nine million zeros", zstd_frame(Bytes(9'000'000)), "claims 9000000 bytes"},
        {"a claim of 2^63 bytes", text({"\x28\xb5\x2f\xfd\xe0\0\0\0\0\0\0\0\x80", 13}),
         "claims 9223372036854775808 bytes"},
        {"an empty frame", zstd_frame({}), "0 bytes; at least 64"},
        {"a frame of zeros", zstd_frame(Bytes(4096)), "magic"},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK_THROWS_AS(decompress_box(c.frame, "0/0/0/0"), util::Error);
        CHECK_THROWS_WITH(decompress_box(c.frame, "0/0/0/0"),
                          contains("read the box 0/0/0/0") && contains(c.said));
    }
}
