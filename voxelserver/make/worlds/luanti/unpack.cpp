#include "voxelserver/make/worlds/luanti/unpack.hpp"

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
    throw util::Error("decompresses to more than " + std::to_string(Unpacker::kLimitBytes >> 20) +
                      " MiB; allowed: up to that");
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
