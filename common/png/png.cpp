#include "common/png/png.hpp"

#include <libdeflate.h>
#include <png.h>

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/text.hpp"

namespace terravox::png {
namespace {

/// Signature, and the first chunk (IHDR): length, type, 13 bytes, checksum. Other chunks may follow
/// from here on. Ref: PNG specification, 5.2, 5.6, 11.2.2.
constexpr std::size_t kBeforeTexts = 8 + 4 + 4 + 13 + 4;

std::string big_endian(std::uint32_t value) {
    std::string out;
    for (int shift = 24; shift >= 0; shift -= 8)
        out += static_cast<char>(value >> shift & 0xff);
    return out;
}

/// @param type four letters
std::string chunk(const std::string& type, const std::string& data) {
    const std::string checked = type + data;
    return big_endian(static_cast<std::uint32_t>(data.size())) + checked +
           big_endian(libdeflate_crc32(0, checked.data(), checked.size()));
}

bool is_ascii(const std::string& text) noexcept {
    return std::all_of(text.begin(), text.end(),
                       [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

bool is_keyword(const std::string& text) noexcept {
    constexpr std::size_t kMaxLength = 79;
    const auto printable = [](char c) { return c >= ' ' && c <= '~'; };
    return !text.empty() && text.size() <= kMaxLength && text.front() != ' ' &&
           text.back() != ' ' && std::all_of(text.begin(), text.end(), printable);
}

/// The older kind of chunk where it suffices, which more programs read; its texts are Latin-1.
std::string text_chunk(const Text& text) {
    constexpr std::size_t kMaxLength = std::size_t{1} << 30;
    const std::string attempt = "write a PNG: its text '" + util::printable(text.keyword) + "': ";
    if (!is_keyword(text.keyword))
        throw util::Error(attempt +
                          "its keyword; allowed: 1 to 79 printable ASCII characters, without "
                          "spaces at its ends");
    if (text.value.find('\0') != std::string::npos)
        throw util::Error(attempt + "a byte of 0 in it; allowed: UTF-8 without");
    if (text.value.size() > kMaxLength)
        throw util::Error("{}{} bytes; allowed: up to {}", attempt, text.value.size(), kMaxLength);
    if (is_ascii(text.value))
        return chunk("tEXt", text.keyword + '\0' + text.value);
    const std::string not_compressed(2, '\0');
    const std::string no_language(1, '\0');
    const std::string no_translation(1, '\0');
    return chunk("iTXt",
                 text.keyword + '\0' + not_compressed + no_language + no_translation + text.value);
}

}  // namespace

// libpng's "simplified" interface catches its own long jumps, so that none crosses C++ frames, and
// compresses at zlib's default level, 6. It knows no texts: they are inserted into what it wrote.
std::string encode(std::span<const std::uint8_t> samples, const Shape& shape,
                   std::span<const Text> texts) {
    const auto fail = [&](const std::string& what) -> void {
        throw util::Error("write a PNG of {} x {} pixels: {}", shape.width_px, shape.height_px,
                          what);
    };
    if (shape.width_px < 1 || shape.height_px < 1 || (shape.channels != 3 && shape.channels != 4))
        fail(std::to_string(shape.channels) + " channels; allowed: 1 pixel and more, 3 or 4");
    const std::uint64_t bytes = static_cast<std::uint64_t>(shape.width_px) *
                                static_cast<std::uint64_t>(shape.height_px) *
                                static_cast<std::uint64_t>(shape.channels);
    if (bytes > kMaxBytes)
        fail(std::to_string(bytes) + " bytes; allowed: " + std::to_string(kMaxBytes));
    if (samples.size() != bytes)
        fail(std::to_string(samples.size()) + " samples were given, not " + std::to_string(bytes));

    std::string text_chunks;
    for (const Text& text : texts)
        text_chunks += text_chunk(text);

    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(shape.width_px);
    image.height = static_cast<png_uint_32>(shape.height_px);
    image.format = shape.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    // Sufficient for incompressible pixels: one pass is enough.
    png_alloc_size_t room = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::string out(room, '\0');
    const int written =
        png_image_write_to_memory(&image, out.data(), &room, 0, samples.data(), 0, nullptr);
    const std::string message = image.message;
    png_image_free(&image);
    if (written == 0)
        fail(message);
    out.resize(room);
    out.insert(kBeforeTexts, text_chunks);
    out.shrink_to_fit();
    return out;
}

}  // namespace terravox::png
