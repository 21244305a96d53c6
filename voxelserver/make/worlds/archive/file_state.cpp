#include "voxelserver/make/worlds/archive/file_state.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace terravox::worlds {
namespace {

constexpr std::string_view kWeak = "W/";

bool is_weak(const std::string& etag) noexcept {
    return etag.starts_with(kWeak);
}

/// The part of a tag that weak comparison uses: weak and strong tags of the same text are the same.
std::string_view opaque(const std::string& etag) noexcept {
    return std::string_view(etag).substr(is_weak(etag) ? kWeak.size() : 0);
}

bool is_etag(const std::string& text) noexcept {
    constexpr std::size_t kQuotes = 2;
    if (text.size() > FileState::kMaxEtag_bytes)
        return false;
    const std::string_view tag = opaque(text);
    if (tag.size() < kQuotes || tag.front() != '"' || tag.back() != '"')
        return false;
    const auto fits = [](char c) { return c > ' ' && c < '\x7f' && c != '"'; };
    return std::all_of(tag.begin() + 1, tag.end() - 1, fits);
}

/// "Sun, 06 Nov 1994 08:49:37 GMT", the only form that servers may send.
bool is_date(const std::string& text) noexcept {
    constexpr std::string_view kForm = "Aaa, 00 Aaa 0000 00:00:00 GMT";
    const auto fits = [](char form, char c) {
        if (form == 'A')
            return c >= 'A' && c <= 'Z';
        if (form == 'a')
            return c >= 'a' && c <= 'z';
        if (form == '0')
            return c >= '0' && c <= '9';
        return form == c;
    };
    return std::equal(kForm.begin(), kForm.end(), text.begin(), text.end(), fits);
}

/// Of "bytes 0-99/1234", and of the "bytes */1234" of an unsatisfiable range.
std::optional<std::uint64_t> whole_size(std::string_view range) noexcept {
    const auto slash = range.rfind('/');
    if (!range.starts_with("bytes ") || slash == std::string_view::npos)
        return std::nullopt;
    const std::string_view number = range.substr(slash + 1);
    std::uint64_t size = 0;
    const auto read = std::from_chars(number.data(), number.data() + number.size(), size);
    if (read.ec != std::errc{} || read.ptr != number.data() + number.size())
        return std::nullopt;
    return size;
}

}  // namespace

FileState FileState::of(const remote::HttpReply& reply) {
    FileState out;
    if (is_etag(reply.etag))
        out.etag = reply.etag;
    if (is_date(reply.last_modified))
        out.last_modified = reply.last_modified;
    constexpr long kWhole = 200;
    out.bytes = reply.status == kWhole ? reply.body.size() : whole_size(reply.content_range);
    return out;
}

std::string FileState::condition() const {
    if (!etag.empty() && !is_weak(etag))
        return "If-Match: " + etag;
    if (!last_modified.empty())
        return "If-Unmodified-Since: " + last_modified;
    return {};
}

bool FileState::differs_from(const FileState& later) const {
    if (bytes && later.bytes && *bytes != *later.bytes)
        return true;
    if (!etag.empty() && !later.etag.empty())
        return opaque(etag) != opaque(later.etag);
    if (!last_modified.empty() && !later.last_modified.empty())
        return last_modified != later.last_modified;
    return !etag.empty() || !last_modified.empty();
}

std::string FileState::text() const {
    std::string out = !etag.empty() ? etag : last_modified;
    if (bytes)
        out += (out.empty() ? "" : ", ") + std::to_string(*bytes) + " bytes";
    return out;
}

}  // namespace terravox::worlds
