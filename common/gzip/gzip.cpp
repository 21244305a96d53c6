#include "common/gzip/gzip.hpp"

#include <libdeflate.h>

#include <memory>
#include <new>

namespace terravox::gzip {

std::string pack(std::string_view bytes) {
    constexpr int kLevel = 12;  // the slowest and smallest
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(kLevel), &libdeflate_free_compressor);
    if (!compressor)
        throw std::bad_alloc();
    std::string out(libdeflate_gzip_compress_bound(compressor.get(), bytes.size()), '\0');
    out.resize(libdeflate_gzip_compress(compressor.get(), bytes.data(), bytes.size(), out.data(),
                                        out.size()));
    return out;
}

}  // namespace terravox::gzip
