#include "raytracer/core/tiles/tile_codec.hpp"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <type_traits>

#include "common/util/error.hpp"
#include "raytracer/core/base/analysis_bands.hpp"

namespace terravox::tiles {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written as they lie in memory");

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kBefore = 1 + sizeof(std::uint64_t);  // version and checksum
// Sums and products of these stay within 32 and 64 bits.
constexpr int kFarthest_px = 1 << 24;
constexpr int kLargestStep_px = 1 << 16;
constexpr std::size_t kHole_bytes = 4 * sizeof(std::int32_t);
enum Flags : std::uint8_t { kRefines = 1, kLayers = 2, kBands = 4, kAllFlags = 7 };

/// Calls field(value) for all parts of a sample, in the order of the planes.
template <class Sample, class Field>
void visit_sample(Sample& s, const Field& field) {
    field(s.colour.r);
    field(s.colour.g);
    field(s.colour.b);
    field(s.alpha);
    field(s.depth_m);
    field(s.samples);
    field(s.error);
}
template <class Layers, class Field>
void visit_layers(Layers& l, const Field& field) {
    for (auto* c : {&l.direct, &l.indirect, &l.albedo}) {
        field(c->r);
        field(c->g);
        field(c->b);
    }
    for (auto* v : {&l.normal, &l.position})
        for (auto& part : *v)
            field(part);
    field(l.sun);
    field(l.water);
    field(l.material);
    for (auto* m : {&l.materials, &l.squares}) {
        for (auto& object : m->object)
            field(object);
        for (auto& share : m->share)
            field(share);
    }
}

/// Bytes that the fields of one pixel take.
constexpr std::size_t kSample_bytes = 7 * sizeof(float);
constexpr std::size_t kLayers_bytes =
    17 * sizeof(float) + 1 + 2 * Matte::kMax * (sizeof(std::uint32_t) + sizeof(float));

/// Multiples of `step` in [from, to); none below 0 anywhere.
std::uint64_t multiples(int from, int to, int step) noexcept {
    return static_cast<std::uint64_t>((to + step - 1) / step - (from + step - 1) / step);
}

std::uint64_t count_pixels(const RenderTile& t) noexcept {
    const auto count = [&t](int step) {
        return multiples(t.x0, t.x1, step) * multiples(t.y0, t.y1, step);
    };
    return count(t.step) - (t.refines ? count(2 * t.step) : 0);
}

std::string place(const RenderTile& t) {
    return "[" + std::to_string(t.x0) + ", " + std::to_string(t.x1) + ") x [" +
           std::to_string(t.y0) + ", " + std::to_string(t.y1) + ")";
}

/// @return what is wrong with a rectangle; empty: nothing
std::string wrong_with(const RenderTile& t) {
    if (t.x0 < 0 || t.y0 < 0 || t.x0 >= t.x1 || t.y0 >= t.y1 || t.x1 > kFarthest_px ||
        t.y1 > kFarthest_px)
        return "the rectangle " + place(t) + "; allowed: not empty, within 0 to " +
               std::to_string(kFarthest_px);
    if (t.step < 1 || t.step > kLargestStep_px ||
        !std::has_single_bit(static_cast<unsigned>(t.step)))
        return "step " + std::to_string(t.step) + "; allowed: powers of two up to " +
               std::to_string(kLargestStep_px);
    return {};
}

std::uint64_t plane_bytes(std::uint64_t pixels, PixelContent content) noexcept {
    return pixels *
           (kSample_bytes + (content.layers ? kLayers_bytes : 0) + content.bands * sizeof(float));
}

std::string too_much(const RenderTile& t, std::uint64_t bytes) {
    return std::to_string(bytes) + " bytes of pixels in the rectangle " + place(t) +
           "; allowed: up to " + std::to_string(kMaxTile_bytes);
}

/// Writes numbers one after the other.
class Writer {
public:
    template <class T>
    void put(T v) {
        static_assert(std::is_arithmetic_v<T>);
        const auto* from = reinterpret_cast<const std::byte*>(&v);
        m_bytes.insert(m_bytes.end(), from, from + sizeof v);
    }
    std::vector<std::byte>& bytes() noexcept { return m_bytes; }

private:
    std::vector<std::byte> m_bytes;
};

/// Reads them again; reading past the end is an error.
class Reader {
public:
    Reader(std::span<const std::byte> bytes, const std::string& origin)
        : m_left(bytes), m_origin(origin) {}
    template <class T>
    void get(T& v) {
        static_assert(std::is_arithmetic_v<T>);
        if (m_left.size() < sizeof v)
            fail("cut short");
        std::memcpy(&v, m_left.data(), sizeof v);
        m_left = m_left.subspan(sizeof v);
    }
    [[nodiscard]] std::span<const std::byte> left() const noexcept { return m_left; }
    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error("read the tile " + m_origin + ": " + what);
    }

private:
    std::span<const std::byte> m_left;
    const std::string& m_origin;
};

/// The numbers of a tile's rectangle, in their order.
template <class Tile, class Number>
void visit_tile(Tile& t, const Number& number) {
    number(t.index);
    number(t.pass);
    number(t.x0);
    number(t.y0);
    number(t.x1);
    number(t.y1);
    number(t.step);
    number(t.first_sample);
    number(t.samples);
}
template <class Counts, class Number>
void visit_counts(Counts& c, const Number& number) {
    for (auto& n : c.rays)
        number(n);
    number(c.steps);
    number(c.slabs);
    number(c.spared);
    number(c.parked);
    number(c.hole_rays);
    for (auto& s : c.seconds)
        number(s);
}

std::uint64_t compute_checksum(std::span<const std::byte> bytes) noexcept {
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), kVersion);
}

/// Checks version and checksum, reads the head, and leaves the reader after the number of holes.
TileHead read_head(Reader& in) {
    std::uint8_t version = 0;
    std::uint8_t flags = 0;
    std::uint64_t checksum = 0;
    in.get(version);
    if (version != kVersion)
        in.fail("version " + std::to_string(version) + "; allowed: " + std::to_string(kVersion));
    in.get(checksum);
    if (checksum != compute_checksum(in.left()))
        in.fail("damaged: its checksum is another");
    TileHead head;
    in.get(flags);
    if ((flags & ~kAllFlags) != 0)
        in.fail("flags " + std::to_string(flags) + "; allowed: up to " + std::to_string(kAllFlags));
    visit_tile(head.tile, [&](auto& n) { in.get(n); });
    head.tile.refines = (flags & kRefines) != 0;
    head.content.layers = (flags & kLayers) != 0;
    if ((flags & kBands) != 0) {
        in.get(head.content.bands);
        if (head.content.bands < 1 || head.content.bands > core::kMaxBands)
            in.fail(std::to_string(head.content.bands) + " bands; allowed: 1 to " +
                    std::to_string(core::kMaxBands));
    }
    in.get(head.holes);
    if (const std::string wrong = wrong_with(head.tile); !wrong.empty())
        in.fail(wrong);
    head.pixels = count_pixels(head.tile);
    if (const std::uint64_t bytes = plane_bytes(head.pixels, head.content); bytes > kMaxTile_bytes)
        in.fail(too_much(head.tile, bytes));
    if (head.holes > in.left().size() / kHole_bytes)
        in.fail(std::to_string(head.holes) + " holes in " + std::to_string(in.left().size()) +
                " bytes");
    return head;
}

void read_holes(Reader& in, std::uint32_t count, std::set<voxel::BoxKey>& holes) {
    for (std::uint32_t i = 0; i < count; ++i) {
        voxel::BoxKey key;
        std::int32_t level = 0;
        in.get(level);
        in.get(key.bx);
        in.get(key.by);
        in.get(key.bz);
        key.level = level;
        if (level < 0 || level > voxel::kMaxLevel)
            in.fail("a hole of level " + std::to_string(level) + "; allowed: 0 to " +
                    std::to_string(voxel::kMaxLevel));
        if (!holes.empty() && !(*holes.rbegin() < key))
            in.fail("its holes are not in order");
        holes.insert(holes.end(), key);
    }
}

/// Stores one field of all pixels at a time, with its bytes by significance: all first ones, all
/// second ones and so on. Exponents and signs of neighbours are alike, so that such bytes compress
/// well where whole floats do not.
class Planes {
public:
    explicit Planes(std::byte* at) noexcept : m_at(at) {}
    /// @param value (i): reference to the field of pixel i
    template <class Value>
    void put(std::size_t pixels, const Value& value) noexcept {
        for (std::size_t i = 0; i < pixels; ++i) {
            const auto bytes = std::bit_cast<std::array<std::byte, sizeof(value(i))>>(value(i));
            for (std::size_t b = 0; b < bytes.size(); ++b)
                m_at[b * pixels + i] = bytes[b];
        }
        m_at += pixels * sizeof(value(0));
    }
    template <class Value>
    void get(std::size_t pixels, const Value& value) noexcept {
        using Field = std::decay_t<decltype(value(0))>;
        for (std::size_t i = 0; i < pixels; ++i) {
            std::array<std::byte, sizeof(Field)> bytes;
            for (std::size_t b = 0; b < bytes.size(); ++b)
                bytes[b] = m_at[b * pixels + i];
            value(i) = std::bit_cast<Field>(bytes);
        }
        m_at += pixels * sizeof(Field);
    }

private:
    std::byte* m_at;
};

/// Calls plane(value) for each field, where value(i) is that field of pixel i. Fields are
/// identified by their offset in the first pixel.
template <class Samples, class Visit, class Plane>
void each_plane(Samples& samples, const Visit& visit, const Plane& plane) {
    if (samples.empty())
        return;
    auto* const first = samples.data();
    constexpr std::size_t stride = sizeof(*first);
    visit(*first, [&](auto& field) {
        auto* const at = &field;
        plane([at](std::size_t i) -> decltype(auto) {
            using Field = std::remove_reference_t<decltype(*at)>;
            using Byte = std::conditional_t<std::is_const_v<Field>, const std::byte, std::byte>;
            return *reinterpret_cast<Field*>(reinterpret_cast<Byte*>(at) + i * stride);
        });
    });
}

const auto kVisitSample = [](auto& s, const auto& field) { visit_sample(s, field); };
const auto kVisitLayers = [](auto& l, const auto& field) { visit_layers(l, field); };

bool is_share(float v) noexcept {
    return v >= 0 && v <= 1;
}
bool is_finite(const voxel::Colour& c) noexcept {
    return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}
bool is_finite(const std::array<float, 3>& v) noexcept {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}
bool are_shares(const Matte& m) noexcept {
    return std::all_of(m.share.begin(), m.share.end(), is_share);
}

/// @return which value is impossible for a pixel; nullptr: none
const char* wrong_with(const PixelSample& s) noexcept {
    if (!is_finite(s.colour))
        return "a colour that is not finite; allowed: finite numbers";
    if (!is_share(s.alpha))
        return "a share of hits beyond 0 to 1";
    if (!(s.depth_m >= 0))
        return "a depth below 0 m, or none; allowed: from 0 m";
    if (!(s.error >= 0) || !std::isfinite(s.error))
        return "an error below 0, or not finite; allowed: from 0";
    return s.samples == 0 ? "a pixel of no samples; allowed: 1 and more" : nullptr;
}
const char* wrong_with(const LayerSample& l) noexcept {
    if (!is_finite(l.direct) || !is_finite(l.indirect) || !is_finite(l.albedo))
        return "a colour of its layers that is not finite; allowed: finite numbers";
    if (!is_finite(l.normal) || !is_finite(l.position))
        return "a normal or position that is not finite; allowed: finite numbers";
    if (!is_share(l.sun) || !is_share(l.water) || !are_shares(l.materials) ||
        !are_shares(l.squares))
        return "a share of its layers beyond 0 to 1";
    const auto known = [](std::uint32_t material) {
        return material < static_cast<std::uint32_t>(voxel::kMaterialCount);
    };
    if (!known(static_cast<std::uint32_t>(l.material)) ||
        !std::all_of(l.materials.object.begin(), l.materials.object.end(), known))
        return "a number that no material has; allowed: those of docs/formats/box.md";
    return nullptr;
}

template <class Samples>
void check_values(const Samples& samples, const Reader& in) {
    for (const auto& sample : samples)
        if (const char* wrong = wrong_with(sample))
            in.fail(wrong);
}

struct ZstdDeleter {
    void operator()(ZSTD_CCtx* c) const noexcept { ZSTD_freeCCtx(c); }
    void operator()(ZSTD_DCtx* c) const noexcept { ZSTD_freeDCtx(c); }
};
/// One per thread, since making one takes longer than compressing a small tile.
template <class Context>
Context* make_context(Context* (*make)()) {
    thread_local const std::unique_ptr<Context, ZstdDeleter> context(make());
    if (!context)
        throw std::bad_alloc();
    return context.get();
}

/// Appends one frame.
void compress(std::span<const std::byte> planes, std::vector<std::byte>& out) {
    const std::size_t before = out.size();
    out.resize(before + ZSTD_compressBound(planes.size()));
    const std::size_t size =
        ZSTD_compressCCtx(make_context(ZSTD_createCCtx), out.data() + before, out.size() - before,
                          planes.data(), planes.size(), 1);
    if (ZSTD_isError(size) != 0)
        throw util::Error(std::string("compress a tile: ") + ZSTD_getErrorName(size));
    out.resize(before + size);
}

/// @param bytes expected size of the only frame, which must fill the input
std::vector<std::byte> decompress(std::span<const std::byte> frame, std::uint64_t bytes,
                                  const Reader& in) {
    const unsigned long long claimed = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (claimed == ZSTD_CONTENTSIZE_ERROR || claimed == ZSTD_CONTENTSIZE_UNKNOWN)
        in.fail("its pixels are no zstd frame with a known size");
    if (claimed != bytes)
        in.fail(std::to_string(claimed) + " bytes of pixels; its rectangle requires " +
                std::to_string(bytes));
    if (ZSTD_findFrameCompressedSize(frame.data(), frame.size()) != frame.size())
        in.fail("its pixels are not one whole zstd frame");
    std::vector<std::byte> raw(bytes);
    const std::size_t size = ZSTD_decompressDCtx(make_context(ZSTD_createDCtx), raw.data(),
                                                 raw.size(), frame.data(), frame.size());
    if (ZSTD_isError(size) != 0)
        in.fail(ZSTD_getErrorName(size));
    if (size != bytes)
        in.fail(std::to_string(size) + " bytes of pixels; its rectangle requires " +
                std::to_string(bytes));
    return raw;
}

}  // namespace

std::uint64_t pixel_bytes(const RenderTile& tile, PixelContent content) noexcept {
    return plane_bytes(count_pixels(tile), content);
}

std::vector<std::byte> encode_tile(const TileResult& result) {
    const RenderTile& t = result.tile;
    const auto fail = [&](const std::string& what) {
        throw util::Error("encode the tile " + std::to_string(t.index) + ": " + what);
    };
    if (const std::string wrong = wrong_with(t); !wrong.empty())
        fail(wrong);
    const std::uint64_t pixels = count_pixels(t);
    const bool with_layers = !result.layers.empty();
    if (result.samples.size() != pixels || (with_layers && result.layers.size() != pixels))
        fail(std::to_string(result.samples.size()) + " samples and " +
             std::to_string(result.layers.size()) +
             " of its layers; allowed: " + std::to_string(pixels));
    const std::size_t bands = pixels > 0 ? result.bands.size() / pixels : 0;
    if (result.bands.size() != bands * pixels || bands > core::kMaxBands)
        fail(std::to_string(result.bands.size()) + " measured values; allowed: up to " +
             std::to_string(core::kMaxBands) + " for each of " + std::to_string(pixels) +
             " pixels");
    const std::uint64_t bytes =
        plane_bytes(pixels, {with_layers, static_cast<std::uint8_t>(bands)});
    if (bytes > kMaxTile_bytes)
        fail(too_much(t, bytes) + ", so make quality.tile smaller");

    Writer out;
    const auto put = [&](auto& n) { out.put(n); };
    out.put(kVersion);
    out.put(std::uint64_t{0});
    out.put(static_cast<std::uint8_t>((t.refines ? kRefines : 0) | (with_layers ? kLayers : 0) |
                                      (bands > 0 ? kBands : 0)));
    visit_tile(t, put);
    if (bands > 0)
        out.put(static_cast<std::uint8_t>(bands));
    out.put(static_cast<std::uint32_t>(result.holes.size()));
    visit_counts(result.counts, put);
    for (const voxel::BoxKey& key : result.holes) {
        out.put(static_cast<std::int32_t>(key.level));
        out.put(key.bx);
        out.put(key.by);
        out.put(key.bz);
    }

    std::vector<std::byte> raw(bytes);
    Planes planes(raw.data());
    const auto plane = [&](const auto& value) { planes.put(pixels, value); };
    each_plane(result.samples, kVisitSample, plane);
    each_plane(result.layers, kVisitLayers, plane);
    for (std::size_t b = 0; b < bands; ++b)
        plane([&](std::size_t i) -> const float& { return result.bands[i * bands + b]; });
    compress(raw, out.bytes());
    const std::uint64_t checksum = compute_checksum(std::span(out.bytes()).subspan(kBefore));
    std::memcpy(out.bytes().data() + 1, &checksum, sizeof checksum);
    return std::move(out.bytes());
}

TileHead read_tile_head(std::span<const std::byte> bytes, const std::string& origin) {
    Reader in(bytes, origin);
    return read_head(in);
}

TileResult decode_tile(std::span<const std::byte> bytes, const std::string& origin) {
    Reader in(bytes, origin);
    const TileHead head = read_head(in);
    TileResult out;
    out.tile = head.tile;
    visit_counts(out.counts, [&](auto& n) { in.get(n); });
    if (!std::all_of(out.counts.seconds.begin(), out.counts.seconds.end(),
                     [](double s) { return s >= 0 && std::isfinite(s); }))
        in.fail("times below 0 s, or not finite");
    read_holes(in, head.holes, out.holes);

    std::vector<std::byte> raw = decompress(in.left(), plane_bytes(head.pixels, head.content), in);
    out.samples.resize(head.pixels);
    if (head.content.layers)
        out.layers.resize(head.pixels);
    out.bands.resize(head.content.bands * head.pixels);
    Planes planes(raw.data());
    const auto plane = [&](const auto& value) { planes.get(head.pixels, value); };
    each_plane(out.samples, kVisitSample, plane);
    each_plane(out.layers, kVisitLayers, plane);
    for (std::size_t b = 0; b < head.content.bands; ++b)
        plane([&](std::size_t i) -> float& { return out.bands[i * head.content.bands + b]; });
    check_values(out.samples, in);
    check_values(out.layers, in);
    if (!std::all_of(out.bands.begin(), out.bands.end(), [](float v) { return std::isfinite(v); }))
        in.fail("a measured value that is not finite; allowed: finite numbers");
    return out;
}

namespace {

/// Hashes fields of pixels, not their memory, which has padding. It works in chunks on the stack,
/// each with the hash of all before it as its seed, so that nothing is allocated.
class PixelHash {
public:
    explicit PixelHash(std::uint64_t seed) noexcept : m_hash(seed) {}
    template <class Field>
    void add(const Field& v) noexcept {
        if (m_used + sizeof v > m_chunk.size())
            close_chunk();
        std::memcpy(m_chunk.data() + m_used, &v, sizeof v);
        m_used += sizeof v;
    }
    [[nodiscard]] std::uint64_t finish() noexcept {
        close_chunk();
        return m_hash;
    }

private:
    void close_chunk() noexcept {
        m_hash = XXH3_64bits_withSeed(m_chunk.data(), m_used, m_hash);
        m_used = 0;
    }
    std::array<std::byte, 4096> m_chunk;
    std::size_t m_used = 0;
    std::uint64_t m_hash;
};

}  // namespace

std::uint64_t hash_of_pixels(const TileResult& result) noexcept {
    return hash_of_pixels(result, result.tile);
}

std::uint64_t hash_of_pixels(const TileResult& result, const RenderTile& rows) noexcept {
    std::size_t begin = 0, end = 0;  // of the samples, which stand row by row
    result.tile.each_pixel([&](int, int y) {
        begin += y < rows.y0 ? 1 : 0;
        end += y < rows.y1 ? 1 : 0;
    });
    begin = std::min(begin, result.samples.size());
    end = std::min(end, result.samples.size());
    PixelHash hash(end - begin);
    const auto add = [&](const auto& field) { hash.add(field); };
    for (std::size_t i = begin; i < end; ++i)
        visit_sample(result.samples[i], add);
    for (std::size_t i = begin; i < end && !result.layers.empty(); ++i)
        visit_layers(result.layers[i], add);
    const std::size_t bands =
        result.samples.empty() ? 0 : result.bands.size() / result.samples.size();
    for (std::size_t i = begin * bands; i < end * bands; ++i)
        hash.add(result.bands[i]);
    return hash.finish();
}

}  // namespace terravox::tiles
