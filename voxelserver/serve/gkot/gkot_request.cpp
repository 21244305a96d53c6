#include "voxelserver/serve/gkot/gkot_request.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string>

#include "common/util/error.hpp"

namespace terravox::gkot {
namespace {

/// Quotes a value for a one-line message: truncated, bytes other than plain ASCII as \xNN.
std::string in_quotes(std::string_view value) {
    constexpr std::size_t kMax = 40;
    std::string out = "'";
    for (const char c : value.substr(0, kMax)) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x20 && byte < 0x7f && c != '\'' && c != '\\') {
            out += c;
            continue;
        }
        char text[8];
        std::snprintf(text, sizeof text, "\\x%02x", byte);
        out += text;
    }
    return out + (value.size() > kMax ? "...'" : "'");
}

/// The known parameters of one query, decoded.
class Parameters {
public:
    /// @param attempt begins every message
    /// @param names the known parameters, with spaces around each
    Parameters(std::string_view query, std::string attempt, std::string_view names)
        : m_attempt(std::move(attempt)) {
        if (query.size() > kMaxQueryBytes)
            throw util::UsageError(m_attempt + ": a query of " + std::to_string(query.size()) +
                                   " bytes; allowed: 0 to " + std::to_string(kMaxQueryBytes));
        while (!query.empty()) {
            const std::string_view part = query.substr(0, query.find('&'));
            query.remove_prefix(std::min(query.size(), part.size() + 1));
            if (part.empty())
                continue;
            const std::size_t equals = part.find('=');
            const std::string name = decoded(part.substr(0, equals), part);
            if (name.empty() || name.find(' ') != std::string::npos ||
                names.find(" " + name + " ") == std::string_view::npos)
                continue;
            if (equals == std::string_view::npos)
                fail(name, "has no value", "NAME=VALUE");
            const auto [at, is_new] =
                m_values.emplace(name, decoded(part.substr(equals + 1), part));
            if (!is_new)
                fail(name, "is given twice, " + in_quotes(at->second) + " at first", "once");
        }
    }

    [[noreturn]] void fail(std::string_view name, const std::string& what,
                           const std::string& allowed) const {
        throw util::UsageError(m_attempt + ": " + std::string(name) + " " + what +
                               "; allowed: " + allowed);
    }
    [[nodiscard]] bool has(const std::string& name) const { return m_values.contains(name); }
    [[nodiscard]] const std::string& text(const std::string& name,
                                          const std::string& allowed) const {
        const auto found = m_values.find(name);
        if (found == m_values.end())
            fail(name, "is missing", allowed);
        return found->second;
    }
    /// A number in [-most, most].
    [[nodiscard]] double number(const std::string& name, double most) const {
        char allowed[64];
        std::snprintf(allowed, sizeof allowed, "a number from %.0f to %.0f", -most, most);
        const std::string& value = text(name, allowed);
        double out = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), out);
        if (error != std::errc{} || end != value.data() + value.size() || !std::isfinite(out) ||
            std::abs(out) > most)
            fail(name, "= " + in_quotes(value), allowed);
        return out;
    }
    [[nodiscard]] std::int32_t integer(const std::string& name, const std::string& allowed) const {
        const std::string& value = text(name, allowed);
        std::int32_t out = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), out);
        if (error != std::errc{} || end != value.data() + value.size())
            fail(name, "= " + in_quotes(value), allowed);
        return out;
    }

private:
    [[nodiscard]] std::string decoded(std::string_view text, std::string_view part) const {
        std::string out;
        for (std::size_t i = 0; i < text.size(); ++i) {
            if (text[i] != '%') {
                out += text[i] == '+' ? ' ' : text[i];
                continue;
            }
            unsigned byte = 0;
            const std::string_view digits = text.substr(i + 1, 2);
            const auto [end, error] =
                std::from_chars(digits.data(), digits.data() + digits.size(), byte, 16);
            if (digits.size() != 2 || error != std::errc{} || end != digits.data() + 2 || byte == 0)
                throw util::UsageError(m_attempt + ": " + in_quotes(part) +
                                       " is badly encoded; allowed: %01 to %ff");
            out += static_cast<char>(byte);
            i += 2;
        }
        return out;
    }

    std::string m_attempt;
    std::map<std::string, std::string> m_values;
};

OriginRequest parse_origin(const Parameters& parameters) {
    return {parameters.number("tmx", kMaxCoordinate), parameters.number("tmy", kMaxCoordinate)};
}

std::int32_t parse_size(const Parameters& parameters, const std::string& name) {
    const std::string allowed = "a power of two, 1 to " + std::to_string(kMaxSide);
    const std::int32_t size = parameters.integer(name, allowed);
    if (size < 1 || size > kMaxSide || !std::has_single_bit(static_cast<std::uint32_t>(size)))
        parameters.fail(name, "= " + std::to_string(size), allowed);
    return size;
}

std::int32_t parse_coordinate(const Parameters& parameters, const std::string& name) {
    using Limits = std::numeric_limits<std::int32_t>;
    return parameters.integer(name, "a whole number from " + std::to_string(Limits::min()) +
                                        " to " + std::to_string(Limits::max()));
}

}  // namespace

OriginRequest parse_origin_request(std::string_view query) {
    return parse_origin({query, "find the origin", " tmx tmy "});
}

BoxRequest parse_box_request(std::string_view query) {
    const Parameters parameters(query, "send a box", " format tmx tmy tmz x y z sx sy sz ");
    if (const std::string& format = parameters.text("format", "raw"); format != "raw")
        parameters.fail("format", "= " + in_quotes(format), "raw");
    BoxRequest out;
    out.origin = parse_origin(parameters);
    if (parameters.has("tmz"))
        out.tmz = parameters.number("tmz", kMaxHeight_m);
    out.x = parse_coordinate(parameters, "x");
    out.y = parse_coordinate(parameters, "y");
    out.z = parse_coordinate(parameters, "z");
    out.sx = parse_size(parameters, "sx");
    out.sy = parse_size(parameters, "sy");
    out.sz = parse_size(parameters, "sz");
    const std::int64_t voxels = std::int64_t{out.sx} * out.sy * out.sz;
    if (voxels > kMaxVoxels)
        parameters.fail("sx * sy * sz", "= " + std::to_string(voxels),
                        "1 to " + std::to_string(kMaxVoxels));
    return out;
}

}  // namespace terravox::gkot
