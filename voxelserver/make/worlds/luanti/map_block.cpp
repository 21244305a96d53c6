#include "voxelserver/make/worlds/luanti/map_block.hpp"

#include <libdeflate.h>
#include <zstd.h>
#include <algorithm>
#include <string>

#include "common/util/error.hpp"

namespace terravox::luanti {
namespace {

constexpr std::size_t kFirstBytes = std::size_t{64} << 10;
// The window size up to which a frame may make the decompressor allocate: the game's own frames
// have smaller windows.
constexpr int kMaxWindowLog = 24;

[[noreturn]] void fail_too_large() {
    throw util::Error("decompresses to more than {} MiB; allowed: up to that",
                      Unpacker::kLimitBytes >> 20);
}

}  // namespace

struct Unpacker::Contexts {
    libdeflate_decompressor* deflate = libdeflate_alloc_decompressor();
    ZSTD_DCtx* zstd = ZSTD_createDCtx();

    Contexts() {
        if (deflate == nullptr || zstd == nullptr) {
            release();
            throw util::Error("decompress map blocks: no memory");
        }
        ZSTD_DCtx_setParameter(zstd, ZSTD_d_windowLogMax, kMaxWindowLog);
    }
    ~Contexts() { release(); }
    Contexts(const Contexts&) = delete;
    Contexts& operator=(const Contexts&) = delete;

private:
    void release() noexcept {
        libdeflate_free_decompressor(deflate);
        ZSTD_freeDCtx(zstd);
    }
};

Unpacker::Unpacker() : m_contexts(std::make_unique<Contexts>()), m_buffer(kFirstBytes) {}
Unpacker::~Unpacker() = default;

Unpacker::Stream Unpacker::zlib(std::span<const std::uint8_t> packed) {
    for (;;) {
        std::size_t read = 0;
        std::size_t written = 0;
        const libdeflate_result result =
            libdeflate_zlib_decompress_ex(m_contexts->deflate, packed.data(), packed.size(),
                                          m_buffer.data(), m_buffer.size(), &read, &written);
        if (result == LIBDEFLATE_SUCCESS)
            return {std::span(m_buffer).first(written), read};
        if (result != LIBDEFLATE_INSUFFICIENT_SPACE)
            throw util::Error("broken zlib data");
        if (m_buffer.size() >= kLimitBytes)
            fail_too_large();
        m_buffer.resize(std::min(kLimitBytes, 4 * m_buffer.size()));
    }
}

std::span<const std::uint8_t> Unpacker::zstd(std::span<const std::uint8_t> packed) {
    ZSTD_DCtx_reset(m_contexts->zstd, ZSTD_reset_session_only);
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    ZSTD_outBuffer out{m_buffer.data(), m_buffer.size(), 0};
    for (;;) {
        const std::size_t left = ZSTD_decompressStream(m_contexts->zstd, &out, &in);
        if (ZSTD_isError(left) != 0)
            throw util::Error(std::string("broken zstd data: ") + ZSTD_getErrorName(left));
        if (left == 0)
            return std::span(m_buffer).first(out.pos);
        if (out.pos < out.size) {
            if (in.pos == in.size)
                throw util::Error("broken zstd data: it ends within its frame");
            continue;
        }
        if (m_buffer.size() >= kLimitBytes)
            fail_too_large();
        m_buffer.resize(std::min(kLimitBytes, 4 * m_buffer.size()));
        out.dst = m_buffer.data();
        out.size = m_buffer.size();
    }
}

}  // namespace terravox::luanti

// Ref: "World Format", doc/world_format.md of Luanti. Numbers are big-endian.
namespace terravox::luanti {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr int kFirstZstdVersion = 29;
constexpr int kFirstLightingVersion = 27;
constexpr std::size_t kNodeBytes = kBlockNodes * 4;  // two of param0, one each of param1, param2
constexpr std::size_t kMaxNames = kBlockNodes;       // a block has no more kinds than nodes

/// Reads numbers from bytes, never beyond their end.
class Cursor {
public:
    explicit Cursor(Bytes bytes) : m_left(bytes) {}

    Bytes take(std::size_t count) {
        if (count > m_left.size())
            throw util::Error("ends too early: {} bytes left of {}", m_left.size(), count);
        const Bytes out = m_left.first(count);
        m_left = m_left.subspan(count);
        return out;
    }
    void skip(std::size_t count) { (void)take(count); }
    std::uint8_t u8() { return take(1)[0]; }
    std::uint16_t u16() {
        const Bytes b = take(2);
        return static_cast<std::uint16_t>(b[0] << 8 | b[1]);
    }
    [[nodiscard]] Bytes left() const noexcept { return m_left; }

private:
    Bytes m_left;
};

void expect(const char* what, int value, int allowed) {
    if (value != allowed)
        throw util::Error("{} is {}; allowed: {}", what, value, allowed);
}

void read_widths(Cursor& in) {
    expect("the width of node ids", in.u8(), 2);
    expect("the width of node parameters", in.u8(), 2);
}

void read_names(Cursor& in, std::vector<MapBlock::Name>& names) {
    expect("the version of the node names", in.u8(), 0);
    const std::size_t count = in.u16();
    if (count > kMaxNames)
        throw util::Error("names {} nodes; allowed: up to {}", count, kMaxNames);
    for (std::size_t i = 0; i < count; ++i) {
        MapBlock::Name& entry = names.emplace_back();
        entry.id = in.u16();
        const std::size_t length = in.u16();
        if (length == 0 || length > MapBlock::kMaxNameBytes)
            throw util::Error("a node name of {} bytes; allowed: 1 to {}", length,
                              MapBlock::kMaxNameBytes);
        const Bytes bytes = in.take(length);
        entry.name = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    const auto by_id = [](const MapBlock::Name& a, const MapBlock::Name& b) { return a.id < b.id; };
    std::sort(names.begin(), names.end(), by_id);
    const auto twice = std::adjacent_find(
        names.begin(), names.end(),
        [](const MapBlock::Name& a, const MapBlock::Name& b) { return a.id == b.id; });
    if (twice != names.end())
        throw util::Error("names node id {} twice", twice->id);
}

void read_ids(Bytes nodes, MapBlock& out) {
    if (nodes.size() != kNodeBytes)
        throw util::Error("node data of {} bytes; allowed: {}", nodes.size(), kNodeBytes);
    for (std::size_t i = 0; i < kBlockNodes; ++i)
        out.ids[i] = static_cast<std::uint16_t>(nodes[2 * i] << 8 | nodes[2 * i + 1]);
}

void skip_static_objects(Cursor& in) {
    constexpr std::size_t kTypeAndPosition = 1 + 3 * 4;
    in.skip(1);  // version
    const int count = in.u16();
    for (int i = 0; i < count; ++i) {
        in.skip(kTypeAndPosition);
        in.skip(in.u16());
    }
}

}  // namespace

const MapBlock& MapBlockReader::read(Bytes blob) {
    constexpr std::size_t kTimestamp = 4;
    Cursor in(blob);
    m_block.names.clear();
    m_block.version = in.u8();
    if (m_block.version < kOldestVersion || m_block.version > kNewestVersion)
        throw util::Error("format version {}; allowed: {} to {}", m_block.version, kOldestVersion,
                          kNewestVersion);
    if (m_block.version >= kFirstZstdVersion)
        in = Cursor(m_unpacker.zstd(in.left()));
    in.skip(1);  // flags
    if (m_block.version >= kFirstLightingVersion)
        in.skip(2);  // which sides are lit completely
    if (m_block.version >= kFirstZstdVersion) {
        in.skip(kTimestamp);
        read_names(in, m_block.names);
        read_widths(in);
        read_ids(in.take(kNodeBytes), m_block);
        return m_block;
    }
    read_widths(in);
    const Unpacker::Stream nodes = m_unpacker.zlib(in.left());
    read_ids(nodes.bytes, m_block);
    in.skip(nodes.packed_bytes);
    in.skip(m_unpacker.zlib(in.left()).packed_bytes);  // metadata of nodes
    skip_static_objects(in);
    in.skip(kTimestamp);
    read_names(in, m_block.names);
    return m_block;
}

}  // namespace terravox::luanti
