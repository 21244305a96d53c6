#include "voxelserver/serve/http/service.hpp"

#include <zstd.h>

#include <charconv>

namespace terravox::http {
namespace {

// What fits into one packet anyway is not sent faster.
constexpr std::size_t kWorthCompressing = 1400;

}  // namespace

Response json_reply(std::string text, const Request& request) {
    Response out;
    out.add("Content-Type", "application/json")
        .add("Cache-Control", "no-store")
        .add("Vary", "Accept-Encoding");
    const Coding coding = choose_coding(request.header("Accept-Encoding"));
    if (coding == Coding::kNone)
        return not_acceptable();
    if (coding == Coding::kZstd && text.size() > kWorthCompressing) {
        std::string packed(ZSTD_compressBound(text.size()), '\0');
        const std::size_t size =
            ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 1);
        if (ZSTD_isError(size) == 0) {
            packed.resize(size);
            text = std::move(packed);
            out.add("Content-Encoding", "zstd");
        }
    }
    out.body = std::make_shared<const std::string>(std::move(text));
    return out;
}

// A client may cache it, but must revalidate it with If-None-Match each time: the server may have
// other data tomorrow.
void add_validators(Response& out, std::string_view etag) {
    out.add("ETag", etag).add("Cache-Control", "no-cache");
}

Response not_modified(std::string_view etag) {
    Response out;
    out.status = 304;
    add_validators(out, etag);
    return out;
}

Response not_acceptable() {
    return problem(406,
                   "the request takes neither zstd nor identity; allowed: Accept-Encoding with one "
                   "of them, or none");
}

Response not_numbers(const Request& request) {
    return problem(400, "read the address " + std::string(request.path) +
                            ": not whole numbers from -2147483648 to 2147483647, such as -12");
}

Response no_such_level(int level, int levels) {
    return problem(
        404, "level " + std::to_string(level) + "; allowed: 0 to " + std::to_string(levels - 1));
}

std::string etag_of(std::uint64_t hash, std::string_view tail) {
    static constexpr char kHex[] = "0123456789abcdef";
    std::string out(18 + tail.size() + 1, '-');
    out[0] = '"';
    for (int i = 0; i < 16; ++i)
        out[static_cast<std::size_t>(16 - i)] = kHex[hash >> (4 * i) & 15];
    out.replace(18, tail.size(), tail);
    out.back() = '"';
    return out;
}

std::optional<std::int32_t> parse_int32(std::string_view text) noexcept {
    std::int32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    const bool minus = text.front() == '-';
    const char first = text[minus ? 1 : 0];
    if (first == '0' && text.size() > 1)
        return std::nullopt;  // 007, -0
    return value;
}

}  // namespace terravox::http
