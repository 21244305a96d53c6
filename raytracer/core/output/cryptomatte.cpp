#include "raytracer/core/output/cryptomatte.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

namespace terravox::output {
namespace {

constexpr const char* kUnknown = "unknown";

std::uint32_t scramble(std::uint32_t k) noexcept {
    return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u;
}

}  // namespace

std::uint32_t murmur3_32(std::string_view bytes, std::uint32_t seed) noexcept {
    const auto byte = [&](std::size_t i) {
        return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i]));
    };
    std::uint32_t h = seed;
    const std::size_t whole = bytes.size() / 4 * 4;
    for (std::size_t i = 0; i < whole; i += 4) {
        h ^= scramble(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
        h = std::rotl(h, 13) * 5 + 0xe6546b64u;
    }
    std::uint32_t rest = 0;
    for (std::size_t i = bytes.size(); i > whole; --i)
        rest = rest << 8 | byte(i - 1);
    if (whole != bytes.size())
        h ^= scramble(rest);
    h ^= static_cast<std::uint32_t>(bytes.size());
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

std::uint32_t cryptomatte_id(std::string_view name) noexcept {
    const std::uint32_t hash = murmur3_32(name);
    const std::uint32_t exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

Cryptomatte::Cryptomatte(std::string type, const std::vector<std::string>& names)
    : m_type(std::move(type)), m_unknown(cryptomatte_id(kUnknown)) {
    nlohmann::json manifest = {{kUnknown, fmt::format("{:08x}", m_unknown)}};
    m_ids.reserve(names.size());
    for (const std::string& name : names) {
        m_ids.push_back(cryptomatte_id(name));
        manifest[name] = fmt::format("{:08x}", m_ids.back());
    }
    m_manifest = manifest.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::vector<std::string> Cryptomatte::channel_names(const std::string& type) {
    std::vector<std::string> out;
    for (std::size_t layer = 0; layer < kChannels / 4; ++layer)
        for (const char* channel : {".r", ".g", ".b", ".a"})
            out.push_back(type + "0" + std::to_string(layer) + channel);
    return out;
}

std::vector<std::pair<std::string, std::string>> Cryptomatte::metadata() const {
    const std::string key =
        "cryptomatte/" + fmt::format("{:08x}", murmur3_32(m_type)).substr(0, 7) + "/";
    return {{key + "name", m_type},
            {key + "hash", "MurmurHash3_32"},
            {key + "conversion", "uint32_to_float32"},
            {key + "manifest", m_manifest}};
}

std::array<float, Cryptomatte::kChannels> Cryptomatte::find_ranks(
    const tiles::Matte& matte) const noexcept {
    struct Rank {
        std::uint32_t id;
        float share;
    };
    std::array<Rank, tiles::Matte::kMax> ranks{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < tiles::Matte::kMax; ++i) {
        if (!(matte.share[i] > 0))
            continue;
        const Rank rank = {matte.object[i] < m_ids.size() ? m_ids[matte.object[i]] : m_unknown,
                           matte.share[i]};
        // Two objects may have one name.
        const auto same =
            std::find_if(ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(count),
                         [&](const Rank& r) { return r.id == rank.id; });
        if (same != ranks.begin() + static_cast<std::ptrdiff_t>(count))
            same->share += rank.share;
        else
            ranks[count++] = rank;
    }
    const auto before = [](const Rank& a, const Rank& b) {
        return a.share != b.share ? a.share > b.share : a.id < b.id;
    };
    for (std::size_t i = 1; i < count; ++i)
        for (std::size_t k = i; k > 0 && before(ranks[k], ranks[k - 1]); --k)
            std::swap(ranks[k], ranks[k - 1]);
    std::array<float, kChannels> out{};
    for (std::size_t i = 0; i < count; ++i) {
        out[2 * i] = std::bit_cast<float>(ranks[i].id);
        out[2 * i + 1] = ranks[i].share;
    }
    return out;
}

}  // namespace terravox::output
